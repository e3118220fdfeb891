"""Triangles and rays that are hard for a grid, as host arrays, and what structures are asked with."""

import drjit as dr
import numpy as np

from renderer.accel import watertight
from renderer.accel.boxes import union
from renderer.accel.pairs import pair
from renderer.accel.records import LEAF, TAG, WORDS
from renderer.core.backend import Bool, Float, UInt32
from renderer.core.numeric import FAR
from renderer.core.records import NO_SHAPE, Ray
from tests.accel.build_inputs import vector

COUNT = 600


def soup(count=COUNT, size=0.1):
    """Return small triangles anywhere in a cube, (count, 3, 3)."""
    rng = np.random.default_rng(1)
    return rng.random((count, 1, 3)) + size * (rng.random((count, 3, 3)) - 0.5)


def _sheet():
    x, y = np.meshgrid(np.arange(17.0), np.arange(17.0), indexing="ij")
    points = np.stack([x, y, np.zeros_like(x)], -1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack(corners, -2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))])


def _needles():
    rng = np.random.default_rng(3)
    along = rng.normal(size=(COUNT, 3))
    start = rng.random((COUNT, 3))
    return np.stack([start, start + along, start + along + 0.002 * rng.normal(size=(COUNT, 3))], 1)


def _lattice():
    """Three sets of sheets at whole numbers: a planes' corner at every point of a lattice."""
    sheets = [_sheet() + [0, 0, 4 * k] for k in range(3)]
    return np.concatenate([np.roll(sheet, axis, -1) for sheet in sheets for axis in range(3)])


def inputs():
    """Return {name: triangles}."""
    loose = soup()
    huge = np.array([[[-1.0, -1, -1], [2, 2, 1], [-1, 2, 2]]])
    return {
        "soup": loose,
        "needles": _needles(),
        "huge among tiny": np.concatenate([huge, 0.01 * loose + 0.5, huge + 0.3]),
        "teapot in stadium": np.concatenate([loose * 1e-3, soup(20, 5.0) * 100 - 50]),
        "identical": np.repeat(loose[:1], COUNT, 0),
        "flat": _sheet(),
        "lattice": _lattice(),
        "in a row": loose * [1, 1e-4, 1e-4],
        "far off": loose * 1e4 + 1e6,
        "a few steps of float apart": loose * 10 + 1e6,
        "tiny": loose * 1e-9,
        "large": loose * 1e12,
        "points": np.repeat(loose[:50, :1], 3, 1),
        "one": loose[:1],
        "two": loose[:2],
    }


def items(triangles):
    """Return leaf records and boxes of triangles."""
    pairs = pair(*(vector(triangles[:, k]) for k in range(3)))
    lo = hi = pairs.v0
    for corner in (pairs.v1, pairs.v2, pairs.v3):
        lo, hi = union(lo, hi, corner, corner)
    leaves, count = watertight.leaf_words(pairs, 0), len(pairs.first)
    dr.scatter(leaves, UInt32(LEAF), WORDS * dr.arange(UInt32, count) + TAG)
    dr.eval(leaves, lo, hi)
    return leaves, lo, hi


def rays(triangles, planes, count, seed=5):
    """Return origins and directions: at random, along axes, through corners, from cells' planes, and from far off.

    `planes` are for each axis the places of a grid's planes.
    """
    rng = np.random.default_rng(seed)
    corners = triangles.reshape(-1, 3)
    low, high = corners.min(0), corners.max(0)
    size = max((high - low).max(), 1e-9)
    o = low - 0.2 * size + (high - low + 0.4 * size) * rng.random((count, 3))
    at_corner, at_plane = (rng.random(count) < share for share in (0.1, 0.2))
    o[at_corner] = corners[rng.integers(len(corners), size=at_corner.sum())]
    for axis in range(3):
        o[at_plane, axis] = rng.choice(planes[axis], at_plane.sum())

    target = low + (high - low) * rng.random((count, 3))
    to_corner = rng.random(count) < 0.4
    target[to_corner] = corners[rng.integers(len(corners), size=to_corner.sum())]
    d = target.astype(np.float32).astype(np.float64) - o.astype(np.float32)
    flat, thin = rng.random((count, 3)) < 0.15, rng.random((count, 3)) < 0.05
    o[flat] = target[flat]  # so that they still meet something
    d[flat] = np.where(rng.random(flat.sum()) < 0.5, 0.0, -0.0)
    d[thin] *= 10.0 ** rng.uniform(-20, -4, thin.sum())  # far below, the leaf test's products vanish
    length = np.linalg.norm(d, axis=1, keepdims=True)
    d = np.where(length > 0, d / np.maximum(length, 1e-300), [0.0, 1.0, 0.0])
    away = rng.choice([0.0, 1.0, 30.0, 1e3, 3e4, 1e6], (count, 1), p=[0.5, 0.2, 0.1, 0.1, 0.05, 0.05])
    return Ray(vector(o - d * away * size), vector(d))


def leaf_test(ray):
    """Return the test of leaf records for structures."""
    axes = watertight.Axes.of(ray)

    def test(words):
        (met, t, index), (second_met, second_t, second) = watertight.test(words, axes)
        met, second_met = met & (t > 0), second_met & (second_t > 0)
        nearer = second_met & (~met | (second_t < t) | ((second_t == t) & (second < index)))
        return met | second_met, dr.select(nearer, second_t, t), dr.select(nearer, second, index)

    return test


def closest(structure, ray):
    """Return distance and index of the closest hits as host arrays."""
    t, index = structure.trace(ray, Float(FAR), UInt32(NO_SHAPE), leaf_test(ray), Bool(True))
    return np.array(t), np.array(index)


def any_hit(structure, ray, distance, active):
    """Return distance and index of some hit nearer than `distance` as host arrays."""
    t, index = structure.trace(ray, distance, UInt32(NO_SHAPE), leaf_test(ray), active, any_hit=True)
    return np.array(t), np.array(index)
