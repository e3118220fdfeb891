"""From a tree of boxes and its leaf records to the records that are traversed."""

import drjit as dr

from renderer.accel.records import NO_PRIMITIVE, ORIGIN, TAG, WIDTH, WORDS
from renderer.core.backend import Float, UInt32, Vector3f

# the difference of a plane and its node's origin is rounded to the nearest float, which may lie inside the box
SHRINK, GROW = 1 - 2.0**-22, 1 + 2.0**-22
NOWHERE = 0x7F00  # bfloat16 of 1.7e38: the lower planes of a box that is not there, whose upper ones are 0


def assemble(tree, leaves):
    """Return the records (UInt32, 16 words each, in the tree's order) of a tree over `leaves`, 16 words an item."""
    count = len(tree.primitive)
    records = dr.empty(UInt32, count * WORDS)

    word = dr.arange(UInt32, count * WORDS)
    record, column = word // WORDS, word % WORDS
    item = dr.gather(UInt32, tree.primitive, record)
    is_leaf = item != NO_PRIMITIVE
    dr.scatter(records, dr.gather(UInt32, leaves, item * WORDS + column, is_leaf), word, is_leaf)

    record = dr.arange(UInt32, count)
    inner = tree.primitive == NO_PRIMITIVE
    lowest = [_planes(tree, record, k, inner) for k in range(WIDTH)]
    for axis in range(3):
        columns = []
        for planes in zip(*(child[axis] for child in lowest)):  # lower planes of all children, then upper ones
            columns += [(planes[k] << 16) | planes[k + 1] for k in range(0, WIDTH, 2)]
        for offset, value in enumerate(columns):
            dr.scatter(records, value, record * WORDS + (4 * axis + offset), inner)
        dr.scatter(records, dr.reinterpret_array(UInt32, tree.lo[axis]), record * WORDS + (ORIGIN + axis), inner)
    dr.scatter(records, tree.first_child, record * WORDS + TAG, inner)
    dr.eval(records)
    return records


def _planes(tree, record, k, inner):
    """Return for each axis the lower and the upper plane of the child k as bfloat16 relative to the node's origin."""
    there = inner & (tree.child_count > k)
    child = tree.first_child + k
    lo, hi = dr.gather(Vector3f, tree.lo, child, there), dr.gather(Vector3f, tree.hi, child, there)
    result = []
    for axis in range(3):
        lower = dr.reinterpret_array(UInt32, (lo[axis] - tree.lo[axis]) * Float(SHRINK)) >> 16
        upper = (dr.reinterpret_array(UInt32, (hi[axis] - tree.lo[axis]) * Float(GROW)) + 0xFFFF) >> 16
        result.append((dr.select(there, lower, UInt32(NOWHERE)), dr.select(there, upper, 0)))
    return result
