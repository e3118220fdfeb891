"""Tracing through the hierarchy: the same to the last bit as testing every leaf, and right beside double precision."""

import itertools
import time

import numpy as np
import pytest

from renderer.accel import bvh as bvh_module
from renderer.accel import nodes
from renderer.accel.slabs import Slabs
from renderer.core.backend import Bool, Float, UInt32
from renderer.core.errors import RenderError
from renderer.core.numeric import FAR
from renderer.core.records import NO_SHAPE, Ray
from renderer.scene.geometry import SHADOW_END, leave
from tests.support.alone import run_alone
from tests.support.soups import SOUPS, Judge, geometry, rays_among, soup, unit, vectors

RAYS = 20_000
JUDGED = 1000  # of these; float64 tests all triangles, in memory
NAMES = list(SOUPS)


@pytest.fixture
def rng():
    """A generator that every test starts from the same state."""
    return np.random.default_rng(20240229)


def lanes(o, d):
    """Return rays with origins and directions (N, 3)."""
    return Ray(vectors(o), vectors(d))


def closest(scene, ray):
    """Return index and distance of the closest hits."""
    hit = scene.intersect(ray)
    return hit.index.numpy(), hit.t.numpy()


def assert_same(first, second):
    """Both found the same triangle, and the same bits of its distance."""
    for one, other in zip(first, second):
        assert np.array_equal(one.view(np.uint32), other.view(np.uint32))


@pytest.mark.parametrize("name", NAMES)
def test_closest_hits_are_those_of_all_leaves_and_right(rng, name):
    """Bit by bit beside the same leaf test without a hierarchy; to a stated rounding beside float64."""
    corners = soup(name, rng)
    o, d = rays_among(corners, rng, RAYS)
    index, t = closest(geometry(corners, "bvh"), lanes(o, d))
    assert_same((index, t), closest(geometry(corners, "none"), lanes(o, d)))
    hit = index != NO_SHAPE
    assert 0.2 < hit.mean() < 1 and (t[~hit] == np.float32(FAR)).all()
    judged = slice(JUDGED)
    decided = Judge(corners, o[judged], d[judged]).check(index[judged], t[judged], hit[judged])
    assert decided > 0.4, "the yardstick itself must be able to tell"


@pytest.mark.parametrize("name", NAMES)
def test_any_hit_is_whether_the_closest_one_is_near_enough(rng, name):
    """Both ways to ask, with ends before, at and behind the closest hit."""
    corners = soup(name, rng)
    o, d = rays_among(corners, rng, RAYS)
    ray, scenes = lanes(o, d), [geometry(corners, accel) for accel in ("bvh", "none")]
    index, t = closest(scenes[0], ray)
    reach = np.where(index != NO_SHAPE, t, np.ptp(corners))
    end = np.float32(reach * rng.choice([0.5, 1, 1 + 1e-6, 2], RAYS))
    active = Bool(rng.random(RAYS) < 0.9)
    blocked, plainly = (scene.occluded(ray, Float(end), active).numpy() for scene in scenes)
    assert np.array_equal(blocked, plainly)
    assert np.array_equal(blocked, active.numpy() & (t < end * np.float32(SHADOW_END)))
    assert 0.1 < blocked.mean() < 0.9


@pytest.mark.parametrize("name", NAMES)
def test_rays_that_left_a_triangle(rng, name):
    """Neither meets it again, nor what rounding of the origin could fake; both find the same."""
    corners = soup(name, rng)
    scene = geometry(corners, "bvh")
    o, d = rays_among(corners, rng, RAYS)
    hits = closest(scene, lanes(o, d))[0] != NO_SHAPE
    ray, out = lanes(o[hits], d[hits]), vectors(unit(rng.normal(size=(hits.sum(), 3))))
    hit = scene.intersect(ray)
    leaving = leave(scene.surface(ray, hit, with_uv=False), hit.index, out)
    index, t = closest(scene, leaving)
    assert_same((index, t), closest(geometry(corners, "none"), leaving))
    assert (index != hit.index.numpy()).all() and (t > 0).all()
    assert name in ("one", "flat") or (index != NO_SHAPE).mean() > 0.005


NOT_A_NUMBER = """
from renderer.core import llvm; llvm.prepare()
import numpy as np
from tests.support.soups import closest_index, geometry, soup, unit
rng = np.random.default_rng(0)
o, d = rng.random((64, 3)), unit(rng.normal(size=(64, 3)))
({value})[::2] = {what}
index = closest_index(geometry(soup("soup", rng), "bvh"), o, d)
assert (index[1::2] < 300).any()
"""


@pytest.mark.parametrize("value", ["o", "d", "o[:, 0:1]", "d[:, 1:2]"])
def test_not_a_number_ends_no_process(root, value):
    """Whatever such a ray meets, its neighbours find what they should; in a process of its own."""
    code = NOT_A_NUMBER.format(value=value, what="float('nan')")
    run_alone(code, root)


def test_ties_go_to_the_lower_index(rng):
    """Where triangles coincide, the first one is met, however the hierarchy was built; all numbers here are exact."""
    one = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    corners = np.repeat([one + [k, 0, 0] for k in range(8)], 50, axis=0)
    corners = np.float32(corners)[np.concatenate([rng.permutation(400), np.arange(400)])]
    aim = rng.integers(1, 4, (1000, 2)) / 8 + rng.integers(8, size=(1000, 1)) * [1, 0]
    index, t = closest(geometry(corners, "bvh"), lanes(np.column_stack([aim, np.full(1000, -2)]), [[0, 0, 1]] * 1000))
    first = [np.flatnonzero(corners[:, 0, 0] == k)[0] for k in range(8)]
    assert np.array_equal(index, np.array(first)[aim[:, 0].astype(int)]) and (t == 2).all()


ZEROS = (0.0, -0.0)


def _lowest_in_wall(u, v, side):
    """Return the first triangle of the wall's two lists, that below all diagonals and that above, that has a point."""
    lowest = np.full(u.shape, NO_SHAPE, np.uint32)
    for x, y in itertools.product(range(side), range(side)):
        across, up = u - x, v - y
        quad = (across >= 0) & (across <= 1) & (up >= 0) & (up <= 1)
        for number, half in ((y * side + x, up <= across), (side * side + y * side + x, up >= across)):
            lowest = np.where(quad & half, np.minimum(lowest, number), lowest)
    return lowest


@pytest.mark.parametrize("axis, sign", [*itertools.product(range(3), (1, -1))])
def test_rays_along_axes_through_corners_and_edges(axis, sign):
    """A wall of quads between whole numbers: where 0 meets infinity in a slab no box is lost, and t is exact."""
    side, height = 12, 3
    corners = soup("grid", None)[: 2 * side * side]
    corners = np.roll(corners, axis + 1, axis=-1)  # the wall's normal is along the axis
    u, v = (part.ravel() for part in np.meshgrid(*[np.arange(-4, 4 * side + 5) / 4] * 2))
    inside = (u >= 0) & (u <= side) & (v >= 0) & (v <= side)
    lowest = _lowest_in_wall(u, v, side)
    o = np.roll(np.stack([u, v, np.full(u.shape, -sign * height)], 1), axis + 1, axis=-1)
    for zeros in itertools.product(ZEROS, ZEROS):
        d = np.tile(np.roll([*zeros, sign], axis + 1), (len(o), 1))
        found = [closest(geometry(corners, accel), lanes(o, d)) for accel in ("bvh", "none")]
        assert_same(*found)
        assert np.array_equal(found[0][0], lowest)
        assert (found[0][1][inside] == height).all()


@pytest.mark.parametrize("axis, along", [*itertools.permutations(range(3), 2)])
def test_rays_within_a_wall_miss_it(axis, along):
    """Seen edge-on a triangle is not there: also for rays along its very edges."""
    corners = np.roll(soup("grid", None)[:288], axis + 1, axis=-1)
    o = np.zeros((50, 3))
    o[:, 3 - axis - along] = np.arange(50) / 4
    o[:, along] = -1
    d = np.tile(np.eye(3)[along], (50, 1))
    assert (closest(geometry(corners, "bvh"), lanes(o, d))[0] == NO_SHAPE).all()


def test_a_million_equal_triangles(rng):
    """No box tells them apart, so that all are tested: the first is found, in bounded time."""
    corners = np.tile(np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), (1_000_000, 1, 1))
    scene = geometry(corners, "bvh")
    aim = rng.integers(1, 4, (8, 2)) / 8
    o = np.column_stack([aim, np.full(8, -2)])
    began = time.process_time()
    index, t = closest(scene, lanes(o, np.tile([0, 0, 1], (8, 1))))
    assert (index == 0).all() and (t == 2).all()
    assert time.process_time() - began < 10


@pytest.mark.parametrize("registers", [1, 2, 3, 20])
def test_stack_continues_in_memory(monkeypatch, rng, registers):
    """However few entries registers hold, the same is found; 20 are more than this hierarchy needs."""
    corners = soup("soup", rng)
    o, d = rays_among(corners, rng, RAYS)
    expected = closest(geometry(corners, "none"), lanes(o, d))
    monkeypatch.setattr(bvh_module, "REGISTERS", registers)
    assert_same(closest(geometry(corners, "bvh"), lanes(o, d)), expected)


def test_no_lanes_wait_for_others(rng):
    """Inactive lanes keep what they were given, and do not change what the others find."""
    corners = soup("soup", rng)
    scene = geometry(corners, "bvh")
    o, d = rays_among(corners, rng, 1000)
    ray, active = lanes(o, d), rng.random(1000) < 0.5
    leaf = scene.leaf_test(ray)
    t, index = scene.structure.trace(ray, Float(FAR), UInt32(7), leaf, Bool(active))
    expected, distance = closest(scene, ray)
    assert np.array_equal(index.numpy(), np.where(active & (expected != NO_SHAPE), expected, 7))
    assert np.array_equal(t.numpy(), np.where(active, distance, np.float32(FAR)))


@pytest.mark.parametrize("count", [1, 2, 3, 15, 16, 17])
def test_a_few_rays(rng, count):
    """The same as among many: Dr.Jit takes what has one lane for the same everywhere, stacks included."""
    corners = soup("bumpy", rng)
    scene = geometry(corners, "bvh")
    o, d = rays_among(corners, rng, 200 * count)
    index, t = closest(scene, lanes(o, d))
    for first in range(0, 20 * count, count):
        some = slice(first, first + count)
        assert_same(closest(scene, lanes(o[some], d[some])), (index[some], t[some]))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["soup", "bumpy", "needles", "huge among tiny", "far away"])
def test_ten_million_rays(rng, name):
    """The same as above, where what is rare shows."""
    corners = soup(name, rng)
    scenes = [geometry(corners, accel) for accel in ("bvh", "none")]
    for _ in range(4):
        ray = lanes(*rays_among(corners, rng, 500_000))
        assert_same(*(closest(scene, ray) for scene in scenes))


# Sabotage: the comparisons above notice


def differences(corners, rng):
    """Return how many rays meet something else with and without the hierarchy."""
    o, d = rays_among(corners, rng, RAYS)
    (index, t), (other, s) = (closest(geometry(corners, accel), lanes(o, d)) for accel in ("bvh", "none"))
    return ((index != other) | (t != s)).sum()


def _later_children_are_forgotten(monkeypatch):
    take = bvh_module._take
    monkeypatch.setattr(bvh_module, "_take", lambda entry: (*take(entry)[:2], Bool(False)))


def _only_one_child_waits(monkeypatch):
    waiting = bvh_module._waiting
    monkeypatch.setattr(bvh_module, "_waiting", lambda first, keys: waiting(first, keys[:1] * 3))


def _planes_too_far_inside(monkeypatch):
    monkeypatch.setattr(nodes, "GROW", 0.9)


def _rays_down_an_axis_are_taken_for_rays_up(monkeypatch):
    slabs = bvh_module.Bvh.slabs

    def upwards(self, ray):
        found = slabs(self, ray)
        return Slabs(found.o, found.rates, found.slacks, [Bool(False)] * 3)

    monkeypatch.setattr(bvh_module.Bvh, "slabs", upwards)


SABOTAGES = [
    _later_children_are_forgotten, _only_one_child_waits, _planes_too_far_inside,
    _rays_down_an_axis_are_taken_for_rays_up,
]


@pytest.mark.parametrize("sabotage", SABOTAGES)
def test_a_broken_hierarchy_is_noticed(monkeypatch, rng, sabotage):
    """Each breaks one step of the traversal, or the boxes."""
    sabotage(monkeypatch)
    assert differences(soup("soup", rng), rng) > 10


def test_a_wrong_leaf_test_is_noticed(monkeypatch, rng):
    """Both structures agree on it; double precision does not."""
    from renderer.accel import watertight

    test = watertight.test

    def too_far(*args):
        return [(met, t * (1 + 2e-5), index) for met, t, index in test(*args)]

    monkeypatch.setattr(watertight, "test", too_far)
    corners = soup("bumpy", rng)
    o, d = rays_among(corners, rng, JUDGED)
    index, t = closest(geometry(corners, "bvh"), lanes(o, d))
    with pytest.raises(AssertionError):
        Judge(corners, o, d).check(index, t, index != NO_SHAPE)


def test_more_records_than_can_be_named_are_refused(monkeypatch, rng):
    """The stack's words hold a record's number in 26 bits; beyond, rays would go astray."""
    monkeypatch.setattr(bvh_module, "MAX_RECORDS", 100)
    with pytest.raises(RenderError, match="too many shapes for a hierarchy: .* and can have 100"):
        geometry(soup("soup", rng), "bvh")
