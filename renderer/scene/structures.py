"""The structure over a scene's shapes: their parameters become leaf records and boxes, and these what is traced."""

import drjit as dr

from renderer.accel import watertight
from renderer.accel.boxes import union
from renderer.accel.brute_force import BruteForce
from renderer.accel.build import build
from renderer.accel.bvh import Bvh
from renderer.accel.grid import Grid
from renderer.accel.nodes import assemble
from renderer.accel.pairs import pair, turn_alike
from renderer.accel.records import FREE, LEAF, PRIMITIVE, TAG, WORDS
from renderer.core.backend import Float, UInt32, Vector3f
from renderer.core.numeric import EPSILON, largest
from renderer.scene.geometry import TRIANGLES


def structure_over(triangles, groups=(), shapes=(), accel="bvh"):
    """Return the structure over Triangles, or None, and over those ShapeGroups of `shapes` that have a code."""
    parts = []
    if triangles is not None:
        positions = triangles.positions()
        pairs = pair(*positions)
        triangles.as_in_records = triangles.plain and turn_alike(pairs, positions)
        lo = hi = pairs.v0
        for corner in (pairs.v1, pairs.v2, pairs.v3):
            lo, hi = union(lo, hi, corner, corner)
        parts.append((watertight.leaf_words(pairs, triangles.first), TRIANGLES, lo, hi))
    for group in groups:
        if group.code is not None:
            members = shapes[group.first : group.first + group.rows.count]
            parts.append((_leaf_words(group), group.code, *_bounds(group.kind, members)))
    leaves, lo, hi = _joined(parts)
    if accel == "none":
        return BruteForce(leaves)
    if accel == "grid":
        return Grid.over(leaves, lo, hi)
    lowest, highest = (Vector3f(*map(bound, corner)) for bound, corner in ((dr.min, lo), (dr.max, hi)))
    half = highest * 0.5 - lowest * 0.5
    middle, radius = lowest + half, largest(half)
    dr.make_opaque(middle, radius)
    return Bvh(assemble(build(lo, hi), leaves), middle, radius)


def _leaf_words(group):
    """Return the leaf words of shapes, but for the tag."""
    count = group.rows.count
    words, place = dr.zeros(UInt32, WORDS * count), WORDS * dr.arange(UInt32, count)
    if group.inline:
        for column, word in zip(range(group.rows.width), FREE):
            dr.scatter(words, dr.reinterpret_array(UInt32, group.rows.column(column)), place + word)
    dr.scatter(words, dr.arange(UInt32, count) + group.first, place + PRIMITIVE)
    return words


def _bounds(kind, shapes):
    """Return the corners of boxes around shapes, rounded outwards."""
    lowest, highest = zip(*map(kind.bounds, shapes))
    lo, hi = (Vector3f(*(Float(list(axis)) for axis in zip(*corners))) for corners in (lowest, highest))
    return lo - abs(lo) * (2 * EPSILON), hi + abs(hi) * (2 * EPSILON)


def _joined(parts):
    """Return leaf words with their tags, and boxes, of several (words, code, lo, hi) as one."""
    counts = [len(lo.x) for _, _, lo, _ in parts]
    total, first = sum(counts), 0
    leaves = dr.empty(UInt32, WORDS * total)
    lo, hi = dr.empty(Vector3f, total), dr.empty(Vector3f, total)
    for count, (words, code, low, high) in zip(counts, parts):
        place = dr.arange(UInt32, count) + dr.opaque(UInt32, first)
        dr.scatter(words, UInt32(LEAF | code), WORDS * dr.arange(UInt32, count) + TAG)
        dr.scatter(leaves, words, dr.arange(UInt32, WORDS * count) + dr.opaque(UInt32, WORDS * first))
        dr.scatter(lo, low, place)
        dr.scatter(hi, high, place)
        first += count
    dr.eval(leaves, lo, hi)
    return leaves, lo, hi
