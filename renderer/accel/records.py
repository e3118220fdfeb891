"""The records that structures read, 16 words (64 bytes, one cache line) each: a leaf, or a node of four children.

Leaf: words 0 to 11 and 13 to 14 belong to the leaf test (a pair of triangles, or the parameters of a shape), word 12
is the number of its first primitive, and word 15 its kind with LEAF set.

Node: words 0 to 11 hold the planes of the children's boxes relative to the node's origin in words 12 to 14; word 15 is
the record of its first child, the others follow it. A plane is a bfloat16, the upper half of a float32: a word holds
those of two children, an axis four words (lower planes of children 0 and 1, of 2 and 3, and the upper planes
likewise). Quantised boxes as in [Ylitie2017], but with a floating point that needs no scale to be read.
"""

import drjit as dr

from renderer.core.backend import ArrayXu

WIDTH = 4  # children of a node
WORDS = 16
PACKET = 8  # words that one gather brings to each lane: the most that Dr.Jit 1.5 moves at once
PRIMITIVE, ORIGIN, TAG = 12, 12, 15  # words
FREE = (*range(12), 13, 14)  # words of a leaf that are its test's own
LEAF = 0x80000000  # bit of the tag; the others are the kind
NO_PRIMITIVE = 0xFFFFFFFF
HIGH_HALF = 0xFFFF0000


def closest(t, index, where, met, distance, primitive):
    """Return the closer of a hit so far and one just found, `where` and if `met`, and whether that is the latter.

    Ties go to the lower index, so that the hit does not depend on the structure, nor on its order. NaN is never closer.
    """
    closer = where & met & ((distance < t) | ((distance == t) & (primitive < index)))
    return dr.select(closer, distance, t), dr.select(closer, primitive, index), closer


def read(records, index, active):
    """Return the 16 words of one record in each active lane, 0 in the others."""
    lanes = dr.width(index)
    halves = [dr.gather(ArrayXu, records, 2 * index + half, active, shape=(PACKET, lanes)) for half in range(2)]
    return [words[k] for words in halves for k in range(PACKET)]
