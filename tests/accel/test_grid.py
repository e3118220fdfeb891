"""A uniform grid finds what testing everything finds: the same triangle at the same distance, bit for bit."""

import drjit as dr
import numpy as np
import pytest

from renderer.accel.brute_force import BruteForce
from renderer.accel.grid import Grid
from renderer.accel.records import LEAF, TAG
from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.numeric import FAR
from renderer.core.records import NO_SHAPE, Ray
from tests.accel import grid_inputs
from tests.accel.grid_inputs import any_hit, closest, items, leaf_test, rays

RAYS = 100_000
INPUTS = grid_inputs.inputs()


def planes(made):
    """Return for each axis where the planes between a level's cells are."""
    numbers = [np.arange(count + 1, dtype=np.float32) for count in made.counts]
    return [np.float32(low) + np.float32(made.edge) * number for low, number in zip(made.corner, numbers)]


def of_triangles(triangles, count=RAYS, **options):
    """Return the grid, the reference and the rays of one input."""
    leaves, lo, hi = items(triangles)
    structure = Grid.over(leaves, lo, hi, **options)
    return structure, BruteForce(leaves), rays(triangles, planes(structure.layouts[0]), count)


@pytest.mark.parametrize("name", INPUTS)
def test_hits_are_those_of_testing_everything(name):
    """From inside and outside, along axes, through corners, from cells' planes, up to 1e6 extents away.

    Which of several hits is found first depends on the order, if any is enough: it is no farther than asked for, and
    lanes that are not active find none.
    """
    structure, reference, ray = of_triangles(INPUTS[name])
    t, index = closest(structure, ray)
    expected_t, expected = closest(reference, ray)
    assert np.array_equal(index, expected) and np.array_equal(t, expected_t)
    if name != "points":
        assert 0.02 < (index != NO_SHAPE).mean() < 1

    rng = np.random.default_rng(2)
    distance = (expected_t * rng.choice([0.5, 1.0, 1.0001, 3.0], RAYS)).astype(np.float32)
    active = rng.random(RAYS) < 0.9
    end, any_index = any_hit(structure, ray, Float(distance), Bool(active))
    found = any_index != NO_SHAPE
    assert np.array_equal(found, active & (expected != NO_SHAPE) & (expected_t <= distance))
    assert (end[found] <= distance[found]).all() and (end[~found] == distance[~found]).all()


@pytest.mark.parametrize("density", [0.1, 64.0])
def test_hits_do_not_depend_on_the_density(density):
    """From a few cells to many more than items."""
    structure, reference, ray = of_triangles(INPUTS["soup"], density=density)
    assert all(map(np.array_equal, closest(structure, ray), closest(reference, ray)))


def test_corners_of_items_in_corners_of_cells_are_met():
    """What the leaf test takes for a hit is in a cell on the way, though the way may be off by rounding too."""
    rng = np.random.default_rng(9)
    count, ends = 500, np.array([[[0.0, 0, 0]] * 3, [[1.0, 1, 1]] * 3])
    legs = 0.05 * rng.random((count, 3, 3)) * [[[0], [1], [1]]]

    def at(corners):
        return np.concatenate([corners[:, None] + legs, ends])

    def over(triangles):
        leaves, lo, hi = items(triangles)
        return Grid.over(leaves, lo, hi, density=1), BruteForce(leaves)

    places = planes(over(at(0.9 * rng.random((count, 3))))[0].layouts[0])
    corners = np.stack([rng.choice(numbers[1:-2], count) for numbers in places], 1).astype(np.float64)
    corners *= 1 + 5e-7  # inside, by less than the rounding of rays from afar
    structure, reference = over(at(corners))
    assert all(map(np.array_equal, planes(structure.layouts[0]), places))

    d = rng.normal(size=(RAYS, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    o = corners[rng.integers(count, size=RAYS)] - d * rng.choice([0.5, 5.0, 25.0, 300.0], (RAYS, 1))
    ray = Ray(grid_inputs.vector(o), grid_inputs.vector(d))
    (t, index), expected = closest(structure, ray), closest(reference, ray)
    assert np.array_equal(t, expected[0]) and np.array_equal(index, expected[1])
    assert 0.1 < (index != NO_SHAPE).mean() < 0.9


def test_earlier_hits_and_limits_are_kept():
    """What other shapes brought stays unless something nearer is found; equal distances go to the lower index."""
    structure, reference, ray = of_triangles(INPUTS["soup"], 10_000)
    t, index = map(np.array, reference.trace(ray, Float(FAR), UInt32(NO_SHAPE), leaf_test(ray), Bool(True)))
    lower, higher = UInt32(np.where(index > 0, index - 1, 0)), UInt32(np.full(len(t), NO_SHAPE - 1, np.uint32))
    for given in (lower, higher):
        answers = [one.trace(ray, Float(t), given, leaf_test(ray), Bool(True)) for one in (structure, reference)]
        assert np.array_equal(*(np.array(answer[1]) for answer in answers))
        assert np.array_equal(*(np.array(answer[0]) for answer in answers))


def test_one_lane_is_enough():
    """Whatever is narrower than the rays."""
    structure, _, _ = of_triangles(INPUTS["soup"], 10)
    corner = INPUTS["soup"][5].mean(0)
    t, index = closest(structure, Ray(Vector3f(*map(float, corner - [0, 0, 5])), Vector3f(0, 0, 1)))
    assert index.shape == (1,) and t[0] < 5.001


@pytest.mark.parametrize("o, d", [
    ((np.nan, 0, 0), (0, 0, 1)), ((0.5, 0.5, 0.5), (np.nan, 0, 0)), ((0.5, 0.5, 0.5), (np.nan, np.nan, np.nan)),
    ((np.inf, 0, 0), (-1, 0, 0)), ((0.5, 0.5, 0.5), (np.inf, 0, 0)), ((1e30, 1e30, 1e30), (-0.6, -0.6, -0.6)),
    ((0.5, 0.5, 0.5), (0, 0, 0)), ((-3e38, 0.5, 0.5), (1, 0, 0)),
])
def test_every_walk_ends(o, d):
    """Also those of rays that are none; 16 of them, so that no lane is a constant."""
    structure, _, _ = of_triangles(INPUTS["soup"], 10)
    origin, direction = (Vector3f(*(Float([value] * 16) for value in v)) for v in (o, d))
    assert len(closest(structure, Ray(origin, direction))[0]) == 16


def count_of_tests(structure, ray, lanes):
    """Return how many leaf records each lane tests."""
    counts, leaf = dr.zeros(UInt32, lanes), leaf_test(ray)

    def counting(words):
        dr.scatter_add(counts, UInt32(1), dr.arange(UInt32, lanes), words[TAG] >= LEAF)
        return leaf(words)

    dr.eval(structure.trace(ray, Float(FAR), UInt32(NO_SHAPE), counting, Bool(True)))
    return np.array(counts)


def test_walks_end_at_the_first_hit():
    """Behind a screen nothing is tested, and only what lies along a ray before it."""
    sheets = np.concatenate([grid_inputs._sheet() + [0, 0, 2 * k] for k in range(8)])
    leaves, lo, hi = items(sheets)
    rng = np.random.default_rng(4)
    o = np.concatenate([rng.uniform(1, 15, (1000, 2)), np.full((1000, 1), -0.5)], 1)
    ray = Ray(grid_inputs.vector(o), grid_inputs.vector(np.tile([0.0, 0, 1], (1000, 1))))
    counts = count_of_tests(Grid.over(leaves, lo, hi), ray, 1000)
    assert 1 <= counts.min() and counts.mean() < 6 and len(lo.x) == 2048


def test_far_rays_take_a_coarser_level():
    """From 30 extents the finest serves, from 500 the next one, and only from beyond everything is tested."""
    triangles = INPUTS["soup"]
    leaves, lo, hi = items(triangles)
    structure, count = Grid.over(leaves, lo, hi), len(lo.x)
    means = []
    for away in (1.0, 30.0, 1000.0, 1e6):
        o = np.random.default_rng(6).random((1000, 3)) * [1, 1, 0] - [0, 0, away]
        ray = Ray(grid_inputs.vector(o), grid_inputs.vector(np.tile([0.0, 0, 1], (1000, 1))))
        means.append(count_of_tests(structure, ray, 1000).mean())
    assert means[0] < 30 and means[1] == pytest.approx(means[0], rel=0.1)
    assert means[1] < means[2] < 0.8 * count and means[3] == count


@pytest.mark.slow
@pytest.mark.parametrize("name", ["soup", "lattice", "huge among tiny", "far off"])
def test_millions_of_rays(name):
    """As above, with other seeds."""
    structure, reference, _ = of_triangles(INPUTS[name], 10)
    for seed in range(20):
        ray = rays(INPUTS[name], planes(structure.layouts[0]), 250_000, seed + 100)
        assert all(map(np.array_equal, closest(structure, ray), closest(reference, ray)))
