"""A binary hierarchy by merging, again and again, clusters that are each other's nearest neighbour [Meister2018].

Clusters lie in a list along a Morton curve, and each looks for its partner within RADIUS places. The distance of two
is the surface area of the box around both. Of equally near ones the partner is the one whose place differs in the lowest
bits: with (area, place ^ place', lesser place) every pair has its own rank, so that the first pair of all always merges
and among equal boxes all pairs (2k, 2k + 1) do. Nothing depends on the order in which lanes run.

Spacings that grow along the list leave only few pairs mutual. If less than one cluster in LEAST_MERGED merges, the
next round merges neighbours in the list instead, so that the number of rounds is logarithmic; and a path in the
tree is no longer than there were rounds, which `max_depth` limits.
"""

from dataclasses import dataclass

import drjit as dr

from renderer.accel.boxes import half_area, union
from renderer.core.backend import Bool, Float, UInt32, Vector3f

RADIUS = 8  # places
LEAST_MERGED = 12  # a round merges one cluster in so many, or the next one pairs neighbours
MOST_AREA = 3e38  # above the area of every box


@dataclass(frozen=True)
class BinaryTree:
    """Nodes 0 to n - 1 are the primitives, the others inner nodes in an order in which children precede their parent."""

    lo: Vector3f  # of all 2n - 1 nodes
    hi: Vector3f
    left: UInt32  # of inner nodes: entry k is of node n + k
    right: UInt32
    root: int


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


def build_binary(lo, hi, order, scale, max_depth):
    """Return the BinaryTree over boxes, given their order along a curve; no path has more than `max_depth` inner nodes.

    `max_depth` must be at least the binary logarithm of their number, rounded up.
    """
    count = len(order)
    nodes_lo, nodes_hi = dr.zeros(Vector3f, 2 * count - 1), dr.zeros(Vector3f, 2 * count - 1)
    left, right = dr.zeros(UInt32, max(count - 1, 1)), dr.zeros(UInt32, max(count - 1, 1))
    dr.scatter(nodes_lo, lo, dr.arange(UInt32, count))
    dr.scatter(nodes_hi, hi, dr.arange(UInt32, count))
    node = order
    lo, hi = dr.gather(Vector3f, lo, order), dr.gather(Vector3f, hi, order)
    dr.eval(nodes_lo, nodes_hi, node, lo, hi)

    created, by_place = 0, False
    for rounds_left in range(max_depth, 0, -1):
        if len(node) == 1:
            break
        if len(node) > 2 ** (rounds_left - 1):  # from here on, only halving reaches one cluster in time
            by_place = True
        partner, merges = _pairs(lo, hi, scale, by_place)
        place = dr.arange(UInt32, len(node))
        first = merges & (place < partner)
        new = dr.prefix_sum(dr.select(first, UInt32(1), 0)) + dr.opaque(UInt32, created)
        dr.eval(partner, first, new)
        kept = dr.compress(~merges | first)

        # the kept clusters, in their order
        first, new = dr.gather(Bool, first, kept), dr.gather(UInt32, new, kept)
        other = dr.gather(UInt32, partner, kept)
        left_child, right_child = dr.gather(UInt32, node, kept), dr.gather(UInt32, node, other, first)
        next_lo, next_hi = dr.gather(Vector3f, lo, kept), dr.gather(Vector3f, hi, kept)
        both_lo, both_hi = union(next_lo, next_hi, dr.gather(Vector3f, lo, other, first),
                                 dr.gather(Vector3f, hi, other, first))
        next_lo, next_hi = dr.select(first, both_lo, next_lo), dr.select(first, both_hi, next_hi)
        node_index = new + dr.opaque(UInt32, count)
        dr.scatter(left, left_child, new, first)
        dr.scatter(right, right_child, new, first)
        dr.scatter(nodes_lo, next_lo, node_index, first)
        dr.scatter(nodes_hi, next_hi, node_index, first)
        next_node = dr.select(first, node_index, left_child)
        dr.eval(next_node, next_lo, next_hi, left, right, nodes_lo, nodes_hi)
        merged = len(node) - len(kept)
        by_place = merged * LEAST_MERGED < len(node)
        created += merged
        node, lo, hi = next_node, next_lo, next_hi
    return BinaryTree(nodes_lo, nodes_hi, left, right, 2 * count - 2)
