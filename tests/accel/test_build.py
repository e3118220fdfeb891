"""The hierarchy over boxes: complete, tight, contiguous, the same every time, and never too deep."""

import numpy as np
import pytest

from renderer.accel.build import NO_PRIMITIVE, build
from renderer.core.backend import Float, Vector3f


def vector(points):
    """Return host points, (N, 3), as lanes."""
    return Vector3f(*(Float(np.ascontiguousarray(points[:, axis], np.float32)) for axis in range(3)))


def random_boxes(count, seed=0):
    """Return the corners of boxes in the unit cube, (N, 3) float32 each."""
    rng = np.random.default_rng(seed)
    lo = rng.random((count, 3), np.float32)
    return lo, lo + np.float32(0.1) * rng.random((count, 3), np.float32)


def assert_valid(tree, lo, hi, width):
    """Every primitive lies in one leaf, children are contiguous, and a parent is exactly as large as they need."""
    first, count, primitive = (np.array(part) for part in (tree.first_child, tree.child_count, tree.primitive))
    tree_lo, tree_hi = np.array(tree.lo).T, np.array(tree.hi).T
    inner, leaf = np.flatnonzero(count), np.flatnonzero(count == 0)
    assert np.array_equal(np.sort(primitive[leaf]), np.arange(len(lo)))
    assert np.array_equal(tree_lo[leaf], lo[primitive[leaf]]) and np.array_equal(tree_hi[leaf], hi[primitive[leaf]])
    assert (primitive[inner] == NO_PRIMITIVE).all() and (first[leaf] == 0).all()
    assert count[0] > 0 and count.max() <= width
    level, seen = np.array([0]), 0
    children = [first[inner] + k for k in range(width)]
    real = [k < count[inner] for k in range(width)]
    assert np.array_equal(np.sort(np.concatenate([c[r] for c, r in zip(children, real)])), np.arange(1, len(count)))
    for bound, reduce, worst in ((tree_lo, np.minimum, np.inf), (tree_hi, np.maximum, -np.inf)):
        tight = np.full((len(inner), 3), worst, np.float32)
        for child, there in zip(children, real):
            tight[there] = reduce(tight[there], bound[child[there]])
        assert np.array_equal(tight, bound[inner])
    while len(level):
        level, seen = np.concatenate([first[level] + k for k in range(width)])[
            np.concatenate([k < count[level] for k in range(width)])], seen + 1
        level = level[count[level] > 0]
    assert seen == tree.depth <= 64


@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 9, 17, 1000])
def test_tree_is_complete(count, width):
    """Each size and width gives a valid tree."""
    lo, hi = random_boxes(count)
    assert_valid(build(vector(lo), vector(hi), width), lo, hi, width)
