"""A binary hierarchy by merging, again and again, clusters that are each other's nearest neighbour [Meister2018].

Clusters lie in a list along a Morton curve, and each looks for its partner within RADIUS places. The distance of two
is the surface area of the box around both. Of equally near ones the partner is the one whose place differs in the
lowest bits: with (area, place ^ place', lesser place) every pair has its own rank, so that the first pair of all
always merges, and among equal boxes all pairs (2k, 2k + 1) do. Nothing depends on the order in which lanes run.

Spacings that grow along the list leave only few pairs mutual. If less than one cluster in LEAST_MERGED merges, the
next round merges neighbours in the list instead, so that the number of rounds is logarithmic; and a path in the
tree is no longer than there were rounds, which `max_depth` limits.
"""

import drjit as dr

from renderer.accel.binary import BinaryTree
from renderer.accel.boxes import half_area, union
from renderer.core.backend import Bool, Float, UInt32, Vector3f

RADIUS = 8  # places
LEAST_MERGED = 12  # a round merges one cluster in so many, or the next one pairs neighbours
MOST_AREA = 3e38  # above the area of every box


def _nearest(lo, hi, scale, count):
    """Return the place of each cluster's partner: the one within RADIUS places that makes the smallest box."""
    place = dr.arange(UInt32, len(lo.x))

    def look(k, best, nearest):
        other = place + k - RADIUS
        valid = (other < count) & (other != place)  # places before the first wrap around to huge ones
        other_lo, other_hi = dr.gather(Vector3f, lo, other, valid), dr.gather(Vector3f, hi, other, valid)
        area = half_area(*union(lo, hi, other_lo, other_hi), scale)
        better = (area < best) | ((area == best) & ((other ^ place) < (nearest ^ place)))
        return k + 1, dr.select(valid & better, area, best), dr.select(valid & better, other, nearest)

    state = (dr.zeros(UInt32, len(lo.x)), dr.full(Float, MOST_AREA, len(lo.x)), place ^ 1)
    return dr.while_loop(state, lambda k, *rest: k <= 2 * RADIUS, look, label="nearest")[2]


def _pairs(lo, hi, scale, by_place):
    """Return each cluster's partner and whether the two merge, as UInt32 and Bool."""
    count = len(lo.x)
    place = dr.arange(UInt32, count)
    if by_place:
        partner = place ^ 1
        return partner, partner < dr.opaque(UInt32, count)
    partner = _nearest(lo, hi, scale, dr.opaque(UInt32, count))
    dr.eval(partner)
    return partner, dr.gather(UInt32, partner, partner) == place


def build_binary(lo, hi, scale, max_depth):
    """Return the BinaryTree over boxes, which lie along a curve; no path has more than `max_depth` inner nodes.

    `max_depth` must be at least the binary logarithm of their number, rounded up.
    """
    count = len(lo.x)
    tree = _no_inner_nodes(lo, hi, count)
    node = dr.arange(UInt32, count)
    created, by_place = 0, False
    for rounds_left in range(max_depth, 0, -1):
        if len(node) == 1:
            break
        # from here on, only halving reaches one cluster in time
        by_place = by_place or len(node) > 2 ** (rounds_left - 1)
        partner, merges = _pairs(lo, hi, scale, by_place)
        kept_node, lo, hi = _merge(tree, node, lo, hi, partner, merges, created)
        merged = len(node) - len(kept_node)
        by_place = merged * LEAST_MERGED < len(node)
        created, node = created + merged, kept_node
    return tree


def _no_inner_nodes(lo, hi, count):
    """Return a tree with room for the inner nodes over boxes."""
    tree = BinaryTree(dr.zeros(Vector3f, 2 * count - 1), dr.zeros(Vector3f, 2 * count - 1),
                      dr.zeros(UInt32, 2 * count - 2), 2 * count - 2, dr.opaque(UInt32, count))
    place = dr.arange(UInt32, count)
    dr.scatter(tree.lo, lo, place)
    dr.scatter(tree.hi, hi, place)
    dr.eval(tree.lo, tree.hi, tree.child)
    return tree


def _merge(tree, node, lo, hi, partner, merges, created):
    """Add an inner node for each pair to the tree, which has `created` of them; return what clusters there are next."""
    first = merges & (dr.arange(UInt32, len(node)) < partner)
    new = dr.prefix_sum(dr.select(first, UInt32(1), 0)) + dr.opaque(UInt32, created)
    dr.eval(partner, first, new)
    kept = dr.compress(~merges | first)
    first, new, other = dr.gather(Bool, first, kept), dr.gather(UInt32, new, kept), dr.gather(UInt32, partner, kept)

    left, right = dr.gather(UInt32, node, kept), dr.gather(UInt32, node, other, first)
    own_lo, own_hi = dr.gather(Vector3f, lo, kept), dr.gather(Vector3f, hi, kept)
    other_lo, other_hi = dr.gather(Vector3f, lo, other, first), dr.gather(Vector3f, hi, other, first)
    both_lo, both_hi = union(own_lo, own_hi, other_lo, other_hi)
    node = dr.select(first, new + tree.leaf_count, left)
    lo, hi = dr.select(first, both_lo, own_lo), dr.select(first, both_hi, own_hi)

    dr.scatter(tree.child, left, 2 * new, first)
    dr.scatter(tree.child, right, 2 * new + 1, first)
    dr.scatter(tree.lo, lo, node, first)
    dr.scatter(tree.hi, hi, node, first)
    dr.eval(node, lo, hi, tree.child, tree.lo, tree.hi)
    return node, lo, hi
