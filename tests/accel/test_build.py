"""The hierarchy over boxes: complete, tight, contiguous, the same every time, and never too deep."""

import drjit as dr
import numpy as np
import pytest

from renderer.accel import ploc
from renderer.accel.build import MAX_DEPTH, NO_PRIMITIVE, build
from tests.accel.build_inputs import INPUTS, vector

COUNT = 20_000
RNG = np.random.default_rng(5)
INDEX = np.arange(COUNT)
ALONG_X = np.array([1.0, 0, 0])
CUBE = RNG.random((COUNT, 3))
HUGE_FIRST = (INDEX == 0)[:, None]


def spread_along(places, size):
    """Return boxes of a size at places along x."""
    lo = np.zeros((COUNT, 3))
    lo[:, 0] = places
    return lo, lo + size


HARD = {
    "all the same": (0 * CUBE, 0 * CUBE + 1),
    "one point": (0 * CUBE + 3, 0 * CUBE + 3),
    "one centre": (-CUBE, CUBE),
    "growing about one centre": (-np.exp2(INDEX / 250)[:, None] * CUBE, np.exp2(INDEX / 250)[:, None] * CUBE),
    "one corner, growing": (0 * CUBE, np.repeat(1.003 ** INDEX[:, None], 3, 1)),
    "quadratic spacing": spread_along(INDEX.astype(float) ** 2, 0.5),
    "quadratic spacing of points": spread_along(INDEX.astype(float) ** 2, 0.0),
    "geometric spacing": spread_along(1.004**INDEX, 0.5),
    "geometric spacing of tiny boxes": spread_along(1e-20 * 1.004**INDEX, 1e-21),
    "geometric spacing on the diagonal": (np.repeat(1.004 ** INDEX[:, None], 3, 1),) * 2,
    "one huge among tiny": (np.where(HUGE_FIRST, -1e6, CUBE), np.where(HUGE_FIRST, 1e6, CUBE + 1e-3)),
    "many huge among tiny": (np.where(INDEX[:, None] % 17, CUBE, 0), np.where(INDEX[:, None] % 17, CUBE, 1)),
    "far from the origin": (1e6 + 100 * CUBE, 1e6 + 100 * CUBE + 0.1),
    "tiny scene": (1e-20 * CUBE, 1e-20 * CUBE + 1e-23),
    "giant scene": (1e18 * CUBE, 1e18 * CUBE + 1e15),
    "within a plane": (CUBE * [1, 1, 0], CUBE * [1, 1, 0] + [0.01, 0.01, 0]),
    "on a line": (CUBE * ALONG_X, CUBE * ALONG_X + 0.001 * ALONG_X),
}
HARD = {name: tuple(corner.astype(np.float32) for corner in boxes) for name, boxes in HARD.items()}


def random_boxes(count, seed=0):
    """Return the corners of boxes in the unit cube, (N, 3) float32 each."""
    rng = np.random.default_rng(seed)
    lo = rng.random((count, 3), np.float32)
    return lo, lo + np.float32(0.1) * rng.random((count, 3), np.float32)


def assert_valid(tree, lo, hi, width):
    """Every primitive lies in one leaf, children are contiguous, and a parent is exactly as large as they need."""
    parts = tree.first_child, tree.child_count, tree.primitive
    first, count, primitive = (np.array(part).astype(int) for part in parts)
    tree_lo, tree_hi = np.array(tree.lo).T, np.array(tree.hi).T
    inner, leaf = np.flatnonzero(count), np.flatnonzero(count == 0)
    assert np.array_equal(np.sort(primitive[leaf]), np.arange(len(lo)))
    assert np.array_equal(tree_lo[leaf], lo[primitive[leaf]]) and np.array_equal(tree_hi[leaf], hi[primitive[leaf]])
    assert (primitive[inner] == NO_PRIMITIVE).all() and (first[leaf] == 0).all()
    assert count[0] > 0 and count.max() <= width
    assert np.array_equal(np.sort(children(first, count, inner)), np.arange(1, len(count)))
    starts = np.cumsum(count[inner]) - count[inner]
    assert np.array_equal(np.minimum.reduceat(tree_lo[children(first, count, inner)], starts), tree_lo[inner])
    assert np.array_equal(np.maximum.reduceat(tree_hi[children(first, count, inner)], starts), tree_hi[inner])
    level, depth = np.array([0]), 0
    while len(level):
        below = children(first, count, level)
        level, depth = below[count[below] > 0], depth + 1
    assert depth == tree.depth <= MAX_DEPTH


def children(first, count, records):
    """Return the children of inner records, one after the other."""
    counts = count[records]
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.repeat(first[records], counts) + place


def as_bytes(tree):
    """Return all that a Tree holds."""
    return tree.depth, [np.array(part).tobytes() for name, part in vars(tree).items() if name != "depth"]


@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 9, 17, 1000])
def test_tree_is_complete(count, width):
    """Each size and width gives a valid tree."""
    lo, hi = random_boxes(count)
    assert_valid(build(vector(lo), vector(hi), width), lo, hi, width)


@pytest.mark.parametrize("count", range(2, 40))
def test_small_trees_are_complete_after_many_rounds(count):
    """Few nodes that may all be in each other's way are moved without losing any."""
    lo, hi = random_boxes(count, seed=count)
    assert_valid(build(vector(lo), vector(hi), rounds=20), lo, hi, 4)


@pytest.mark.parametrize("name", INPUTS)
def test_mesh_tree_is_complete_after_many_rounds(name):
    """Thousands of moves leave a valid tree."""
    lo, hi = INPUTS[name](5000)
    assert_valid(build(vector(lo), vector(hi), rounds=12), lo, hi, 4)


@pytest.mark.parametrize("name", HARD)
def test_hard_boxes_give_a_valid_tree(name):
    """No arrangement of boxes makes an invalid tree, or one that is too deep."""
    assert_valid(build(*map(vector, HARD[name])), *HARD[name], 4)


def merging_work(name, monkeypatch):
    """Return the lengths of the lists of clusters of all rounds, in units of the first."""
    lengths, merge = [], ploc._merge
    monkeypatch.setattr(ploc, "_merge", lambda tree, node, *rest: lengths.append(len(node)) or merge(tree, node, *rest))
    build(*map(vector, HARD[name]), rounds=0)
    assert len(lengths) > np.log2(COUNT)
    return sum(lengths) / COUNT


@pytest.mark.parametrize("name", HARD)
def test_merging_takes_linear_work(name, monkeypatch):
    """The lists of clusters shrink so fast that all together are no longer than a few of the first."""
    assert merging_work(name, monkeypatch) < ploc.LEAST_MERGED


@pytest.mark.parametrize("name", ["all the same", "one point"])
def test_equal_boxes_halve_in_number(name, monkeypatch):
    """Equally near partners agree on each other: all pairs merge in every round."""
    assert merging_work(name, monkeypatch) < 2.01


def test_growing_spacing_needs_the_pairing_of_neighbours(monkeypatch):
    """The input that the rule is for breaks the bound on work without it."""
    limit = ploc.LEAST_MERGED
    monkeypatch.setattr(ploc, "LEAST_MERGED", COUNT)
    assert merging_work("quadratic spacing", monkeypatch) > limit


@pytest.mark.parametrize("name", ["all the same", "many huge among tiny", "one centre"])
def test_same_boxes_give_the_same_bytes(name):
    """Neither another run nor another number of threads changes anything."""
    boxes = [vector(np.concatenate([corner, corner[::-1] + 2])) for corner in HARD[name]]
    threads, results = dr.thread_count(), []
    try:
        for count in (threads, threads, 1, 2, 3):
            dr.set_thread_count(count)
            results.append(as_bytes(build(*boxes)))
    finally:
        dr.set_thread_count(threads)
    assert all(result == results[0] for result in results[1:])


@pytest.mark.parametrize("name", INPUTS)
def test_same_mesh_gives_the_same_bytes(name):
    """Neither another run nor another number of threads changes anything where boxes differ."""
    boxes = list(map(vector, INPUTS[name](30_000)))
    threads, results = dr.thread_count(), []
    try:
        for count in (threads, 1, 2):
            dr.set_thread_count(count)
            results.append(as_bytes(build(*boxes)))
    finally:
        dr.set_thread_count(threads)
    assert results[0] == results[1] == results[2]


@pytest.mark.slow
def test_a_million_equal_boxes():
    """Where all ties are, sizes are as large as they get in practice."""
    lo = np.zeros((1_000_000, 3), np.float32)
    tree = build(vector(lo), vector(lo + 1))
    assert_valid(tree, lo, lo + 1, 4)
    assert tree.depth <= 11
