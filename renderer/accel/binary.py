"""Binary hierarchies in arrays: nodes 0 to n - 1 are the primitives, n to 2n - 2 the inner nodes.

All that goes from the root down or from the primitives up goes level by level, a kernel a level; what is read and what
is written in one of them never overlaps, so that the order of lanes does not matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.accel.boxes import union
from renderer.core.backend import Bool, UInt32, Vector3f


@dataclass
class BinaryTree:
    """A hierarchy whose inner nodes may be linked anew; their boxes are then stale until `refit`."""

    lo: Vector3f  # corners of all 2n - 1 nodes
    hi: Vector3f
    child: UInt32  # inner node n + k has the children child[2k] and child[2k + 1]
    root: int
    leaf_count: UInt32  # n, opaque

    @property
    def node_count(self):
        """Return 2n - 1."""
        return len(self.lo.x)

    def children(self, node, active=True):
        """Return the two children of inner nodes."""
        place = 2 * (node - self.leaf_count)
        return dr.gather(UInt32, self.child, place, active), dr.gather(UInt32, self.child, place + 1, active)

    def box(self, node, active=True):
        """Return the corners of nodes."""
        return dr.gather(Vector3f, self.lo, node, active), dr.gather(Vector3f, self.hi, node, active)


def levels(tree, within=None):
    """Return the inner nodes as a list of UInt32 arrays, those of one depth each, from the root on.

    `within` (Bool of all nodes) leaves out the subtrees of nodes where it is false.
    """
    level, found = dr.full(UInt32, tree.root, 1), []
    dr.make_opaque(level)
    while len(level):
        found.append(level)
        place = dr.arange(UInt32, 2 * len(level))
        node = dr.gather(UInt32, level, place >> 1)
        child = dr.gather(UInt32, tree.child, 2 * (node - tree.leaf_count) + (place & 1))
        inner = child >= tree.leaf_count
        if within is not None:
            inner &= dr.gather(Bool, within, child)
        dr.eval(child, inner)
        level = dr.gather(UInt32, child, dr.compress(inner))
        dr.eval(level)
    return found


def refit(tree, by_depth):
    """Make the boxes of inner nodes just as large as their children need, given `levels(tree)`."""
    for level in reversed(by_depth):
        left, right = tree.children(level)
        lo, hi = union(*tree.box(left), *tree.box(right))
        dr.eval(lo, hi)  # a read still pending would make the writes copy the whole array
        dr.scatter(tree.lo, lo, level)
        dr.scatter(tree.hi, hi, level)
        dr.eval(tree.lo, tree.hi)
