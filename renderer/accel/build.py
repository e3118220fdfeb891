"""The bounding volume hierarchy of a scene, built in whole-array operations.

Boxes are sorted along a Morton curve and merged pairwise to a binary tree; subtrees are moved to where they cost less,
and what results is collapsed to a wide tree (docs/bvh-build.md). The same boxes give the same bytes, whatever the
number of threads.
"""

from dataclasses import dataclass

import drjit as dr

from renderer.accel.boxes import scene_scale
from renderer.accel.collapse import MAX_WIDTH, collapse
from renderer.accel.morton import morton_order
from renderer.accel.ploc import build_binary
from renderer.accel.records import NO_PRIMITIVE
from renderer.accel.reinsert import reinsert
from renderer.core.backend import UInt32, Vector3f

MAX_DEPTH = 64  # levels of inner nodes, whatever the boxes
ROUNDS = 4  # of reinsertion


@dataclass(frozen=True)
class Tree:
    """A hierarchy as evaluated arrays, an entry a record; record 0 is the root and always an inner node."""

    lo: Vector3f  # exact bounds
    hi: Vector3f
    first_child: UInt32  # record of the first child, the others follow; 0 for primitives
    child_count: UInt32  # 1 to width; 0 for primitives
    primitive: UInt32  # its index; NO_PRIMITIVE for inner nodes
    depth: int  # inner nodes on the longest path


def build(lo, hi, width=4, rounds=ROUNDS):
    """Return the Tree over primitives with the bounds `lo` and `hi` (Vector3f, a lane each, finite, lo <= hi).

    There must be at least one; boxes may be flat, points, or all the same. The scene's extent must stay below 1e38;
    numbers below 1e-38 count as zeros. `rounds` trades time for quality (docs/bvh-build.md).
    """
    assert 2 <= width <= MAX_WIDTH
    dr.eval(lo, hi)
    if len(lo.x) == 1:
        return _single(lo, hi)
    lowest, scale = scene_scale(lo, hi)
    order = morton_order(lo, hi, lowest, scale)
    binary = build_binary(dr.gather(Vector3f, lo, order), dr.gather(Vector3f, hi, order), scale, MAX_DEPTH)
    by_depth = reinsert(binary, scale, rounds, MAX_DEPTH)
    nodes, first_child, child_count, depth = collapse(binary, by_depth, width, scale)
    is_leaf = child_count == 0
    primitive = dr.select(is_leaf, dr.gather(UInt32, order, nodes, is_leaf), UInt32(NO_PRIMITIVE))
    tree = Tree(*binary.box(nodes), first_child, child_count, primitive, depth)
    dr.eval(tree.lo, tree.hi, tree.first_child, tree.child_count, tree.primitive)
    return tree


def _single(lo, hi):
    """Return the tree of one primitive: a root with one child."""
    both = dr.zeros(UInt32, 2)
    tree = Tree(dr.gather(Vector3f, lo, both), dr.gather(Vector3f, hi, both), UInt32(1, 0), UInt32(1, 0),
                UInt32(NO_PRIMITIVE, 0), 1)
    dr.eval(tree.lo, tree.hi, tree.first_child, tree.child_count, tree.primitive)
    return tree
