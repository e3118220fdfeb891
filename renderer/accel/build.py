"""The bounding volume hierarchy of a scene, built in whole-array operations.

Boxes are sorted along a Morton curve, merged pairwise to a binary tree, and that is collapsed to a wide one. The same
boxes give the same bytes, whatever the number of threads.
"""

from dataclasses import dataclass

import drjit as dr

from renderer.accel.boxes import scene_scale
from renderer.accel.collapse import NO_PRIMITIVE, collapse
from renderer.accel.morton import morton_order
from renderer.accel.ploc import build_binary
from renderer.core.backend import UInt32, Vector3f

MAX_DEPTH = 64  # levels of inner nodes; 2^64 primitives would fit


@dataclass(frozen=True)
class Tree:
    """A hierarchy as evaluated arrays, an entry a record; record 0 is the root and always an inner node."""

    lo: Vector3f  # exact bounds
    hi: Vector3f
    first_child: UInt32  # record of the first child, the others follow; 0 for primitives
    child_count: UInt32  # 1 to width; 0 for primitives
    primitive: UInt32  # its index; NO_PRIMITIVE for inner nodes
    depth: int  # inner nodes on the longest path


def build(lo, hi, width=4):
    """Return the Tree over primitives with the bounds `lo` and `hi` (Vector3f, a lane each, finite, lo <= hi).

    There must be at least one; boxes may be flat, points, or all the same. Extents must stay below 1e38.
    """
    dr.eval(lo, hi)
    count = len(lo.x)
    if count == 1:
        return _single(lo, hi)
    lowest, scale = scene_scale(lo, hi)
    binary = build_binary(lo, hi, morton_order(lo, hi, lowest, scale), scale, MAX_DEPTH)
    (nodes, first_child, child_count), depth = collapse(binary, width, scale)
    tree = Tree(dr.gather(Vector3f, binary.lo, nodes), dr.gather(Vector3f, binary.hi, nodes), first_child, child_count,
                dr.select(child_count == 0, nodes, UInt32(NO_PRIMITIVE)), depth)
    dr.eval(tree.lo, tree.hi, tree.first_child, tree.child_count, tree.primitive)
    return tree


def _single(lo, hi):
    """Return the tree of one primitive: a root with one child."""
    both = dr.zeros(UInt32, 2)
    tree = Tree(dr.gather(Vector3f, lo, both), dr.gather(Vector3f, hi, both), UInt32(1, 0), UInt32(1, 0),
                UInt32(NO_PRIMITIVE, 0), 1)
    dr.eval(tree.lo, tree.hi, tree.first_child, tree.child_count, tree.primitive)
    return tree
