"""From a binary hierarchy to the cheapest one with up to `width` children a node that is made of its nodes.

cost(v, k) is what the subtree of v costs if it may show up to k nodes to its parent. A node of the wide tree costs its
area, a primitive nothing more than it does anyway [Ylitie2017, sec. 3.1, without its leaves of several primitives]:

    split(v, k) = min over 0 < j < k of cost(left, j) + cost(right, k - j)
    cost(v, 1)  = area(v) + split(v, width)
    cost(v, k)  = min(cost(v, k - 1), split(v, k))

The choices are kept on the way up, four bits a k, and followed on the way down, where the wide tree's records are made
breadth first.
"""

from __future__ import annotations

import drjit as dr

from renderer.accel.boxes import half_area
from renderer.core.backend import Float, UInt32
from renderer.core.numeric import greater

NOTHING = 0xFFFFFFFF  # no node of the binary tree
MAX_WIDTH = 8  # the choices of one node fit into 32 bits
FEWER = 8  # a choice: what k - 1 chooses
LEAST_AREA = 1e-20  # of nodes without area, which are better few, too


def _choices(tree, by_depth, width, scale):
    """Return each inner node's choices: bits 4k to 4k + 3 are j of its best split to k nodes, or FEWER."""
    costs = [dr.zeros(Float, tree.node_count) for _ in range(width - 1)]
    choices = dr.zeros(UInt32, tree.node_count)
    dr.eval(costs, choices)
    for level in reversed(by_depth):
        left, right = tree.children(level)
        left_costs, right_costs = ([dr.gather(Float, cost, node) for cost in costs] for node in (left, right))
        splits = {k: _best_split(left_costs, right_costs, k) for k in range(2, width + 1)}
        best = [greater(half_area(*tree.box(level), scale), Float(LEAST_AREA)) + splits[width][0]]
        choice = splits[width][1] << (4 * (width - 1))
        for k in range(2, width):
            fewer = best[-1] <= splits[k][0]
            best.append(dr.select(fewer, best[-1], splits[k][0]))
            choice |= dr.select(fewer, UInt32(FEWER), splits[k][1]) << (4 * (k - 1))
        dr.eval(best, choice)  # a read still pending would make the writes copy the whole array
        for cost, value in zip(costs, best):
            dr.scatter(cost, value, level)
        dr.scatter(choices, choice, level)
        dr.eval(costs, choices)
    return choices


def _best_split(left_costs, right_costs, k):
    """Return the least cost of k nodes from two children, and how many of them are from the left one."""
    best, from_left = left_costs[0] + right_costs[k - 2], UInt32(1)
    for j in range(2, k):
        cost = left_costs[j - 1] + right_costs[k - j - 1]
        from_left = dr.select(cost < best, UInt32(j), from_left)
        best = dr.select(cost < best, cost, best)
    return best, from_left


def _split(tree, choices, node, budget, width, active=True):
    """Return `((left, its budget), (right, its budget))` of inner nodes that show `budget` nodes."""
    choice = dr.gather(UInt32, choices, node, active)
    from_left = (choice >> (4 * (budget - 1))) & 7
    left, right = tree.children(node, active)
    return (left, _needed(tree, choices, left, from_left, width, active)), (
        right, _needed(tree, choices, right, budget - from_left, width, active))


def _needed(tree, choices, node, budget, width, active):
    """Return how many nodes a subtree shows if it may show `budget`."""
    inner = active & (node >= tree.leaf_count)
    choice = dr.gather(UInt32, choices, node, inner)
    for _ in range(width - 2):
        fewer = (budget > 1) & ((choice >> (4 * (budget - 1)) & FEWER) != 0)
        budget = dr.select(fewer, budget - 1, budget)
    return dr.select(inner, budget, UInt32(1))


def _children(tree, choices, node, width):
    """Return the children of wide nodes, in order, as a list of `width` UInt32 that ends with NOTHING."""
    slots = [*_split(tree, choices, node, dr.full(UInt32, width, len(node)), width)]
    for _ in range(width - 2):
        # the first that shows more than itself is replaced by its two children
        place, opened, budget = dr.full(UInt32, NOTHING, len(node)), UInt32(0), UInt32(1)
        for k, (child, shown) in reversed(list(enumerate(slots))):
            more = shown > 1
            place, opened = dr.select(more, UInt32(k), place), dr.select(more, child, opened)
            budget = dr.select(more, shown, budget)
        opens = place != NOTHING
        left, right = _split(tree, choices, opened, budget, width, opens)
        slots = _insert(slots, place, left, right)
    return [child for child, _ in slots]


def _insert(slots, place, left, right):
    """Return slots, one more, with the one at `place` replaced by two and those behind it moved on."""
    last = (dr.full(UInt32, NOTHING, len(place)), dr.full(UInt32, 1, len(place)))
    inserted = []
    for k, old in enumerate([*slots, last]):
        if k:
            old = _choose(place == k - 1, right, _choose(place < k - 1, slots[k - 1], old))
        inserted.append(_choose(place == k, left, old))
    return inserted


def _choose(mask, first, second):
    """Return one of two slots."""
    return tuple(dr.select(mask, a, b) for a, b in zip(first, second))


def collapse(tree, by_depth, width, scale):
    """Return `(nodes, first_child, child_count, depth)`: binary node, and children, of each record, breadth first.

    `by_depth` are the tree's levels. Records are UInt32 arrays; `depth` is the number of levels with inner nodes.
    """
    choices = _choices(tree, by_depth, width, scale)
    nodes, first_child, child_count = (dr.zeros(UInt32, tree.node_count) for _ in range(3))
    level, record = dr.full(UInt32, tree.root, 1), dr.zeros(UInt32, 1)  # whose children are made next
    dr.make_opaque(level, record)
    dr.scatter(nodes, level, record)
    used, depth = 1, 0
    while len(level):
        slots = _children(tree, choices, level, width)
        counts = dr.zeros(UInt32, len(level))
        for slot in slots:
            counts += dr.select(slot == NOTHING, UInt32(0), 1)
        first = dr.prefix_sum(counts) + dr.opaque(UInt32, used)
        dr.eval(slots, counts, first)
        dr.scatter(first_child, first, record)
        dr.scatter(child_count, counts, record)
        for k, slot in enumerate(slots):
            dr.scatter(nodes, slot, first + k, slot != NOTHING)
        dr.eval(nodes, first_child, child_count)
        made = first[len(level) - 1] + counts[len(level) - 1] - used
        children = dr.arange(UInt32, made) + dr.opaque(UInt32, used)
        inner = dr.gather(UInt32, nodes, children) >= tree.leaf_count
        record = dr.gather(UInt32, children, dr.compress(inner))
        level = dr.gather(UInt32, nodes, record)
        dr.eval(record, level)
        used, depth = used + made, depth + 1
    present = dr.arange(UInt32, used)
    return *(dr.gather(UInt32, part, present) for part in (nodes, first_child, child_count)), depth
