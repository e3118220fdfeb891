"""From a binary hierarchy to one with up to `width` children a node, level by level from the root."""

from __future__ import annotations

import drjit as dr

from renderer.accel.boxes import half_area
from renderer.core.backend import Float, UInt32, Vector3f

NO_PRIMITIVE = 0xFFFFFFFF
NOTHING = 0xFFFFFFFF  # no node of the binary tree


def _open(tree, node, width, leaf_count, scale):
    """Return up to `width` descendants of each inner node as a list of UInt32, NOTHING behind the last.

    From its two children on, the largest one is replaced by its own two.
    """
    inner = node - leaf_count
    slots = [dr.gather(UInt32, tree.left, inner), dr.gather(UInt32, tree.right, inner)]
    areas = [_inner_area(tree, slot, leaf_count, scale) for slot in slots]
    for _ in range(width - 2):
        largest, place = areas[0], dr.zeros(UInt32, len(node))
        for k in range(1, len(slots)):
            bigger = areas[k] > largest
            largest, place = dr.select(bigger, areas[k], largest), dr.select(bigger, UInt32(k), place)
        opens = largest >= 0
        chosen = slots[0]
        for k in range(1, len(slots)):
            chosen = dr.select(place == k, slots[k], chosen)
        left = dr.gather(UInt32, tree.left, chosen - leaf_count, opens)
        right = dr.gather(UInt32, tree.right, chosen - leaf_count, opens)
        left_area = _inner_area(tree, left, leaf_count, scale, opens)
        for k in range(len(slots)):
            here = opens & (place == k)
            slots[k], areas[k] = dr.select(here, left, slots[k]), dr.select(here, left_area, areas[k])
        slots.append(dr.select(opens, right, UInt32(NOTHING)))
        areas.append(dr.select(opens, _inner_area(tree, right, leaf_count, scale, opens), Float(-1)))
    return slots


def _inner_area(tree, node, leaf_count, scale, active=True):
    """Return half the area of inner nodes, and -1 for primitives, which cannot be opened."""
    active = active & (node >= leaf_count)
    lo, hi = dr.gather(Vector3f, tree.lo, node, active), dr.gather(Vector3f, tree.hi, node, active)
    return dr.select(active, half_area(lo, hi, scale), Float(-1))


def collapse(tree, width, scale):
    """Return `(nodes, first_child, child_count, depth)`: binary node, and children, of each record, breadth first.

    Records are UInt32 arrays; `depth` is the number of levels with inner nodes.
    """
    leaf_count = dr.opaque(UInt32, (tree.root + 2) // 2)
    capacity = tree.root + 1
    nodes, first_child = dr.zeros(UInt32, capacity), dr.zeros(UInt32, capacity)
    child_count = dr.zeros(UInt32, capacity)
    dr.scatter(nodes, UInt32(tree.root), UInt32(0))
    level = dr.full(UInt32, tree.root, 1)  # binary nodes of the records whose children are made next
    record = dr.zeros(UInt32, 1)
    used, depth = 1, 0
    while len(level):
        slots = _open(tree, level, width, leaf_count, scale)
        counts = dr.zeros(UInt32, len(level))
        for slot in slots:
            counts += dr.select(slot == NOTHING, UInt32(0), 1)
        dr.eval(counts, slots)
        first = dr.prefix_sum(counts) + dr.opaque(UInt32, used)
        dr.scatter(first_child, first, record)
        dr.scatter(child_count, counts, record)
        for k, slot in enumerate(slots):
            dr.scatter(nodes, slot, first + k, slot != NOTHING)
        dr.eval(first, nodes, first_child, child_count)
        made = int(first[len(first) - 1]) + int(counts[len(counts) - 1]) - used
        children = dr.arange(UInt32, made) + dr.opaque(UInt32, used)
        inner = dr.gather(UInt32, nodes, children) >= leaf_count
        record = dr.gather(UInt32, children, dr.compress(inner))
        level = dr.gather(UInt32, nodes, record)
        dr.eval(record, level)
        used, depth = used + made, depth + 1
    present = dr.arange(UInt32, used)
    return [dr.gather(UInt32, part, present) for part in (nodes, first_child, child_count)], depth
