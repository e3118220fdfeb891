"""Coherent rays that share a walk in groups: they meet what each of them meets alone."""

import numpy as np
import pytest

import renderer.accel.slabs as slabs_module
from renderer.accel.slabs import Slabs
from renderer.core.backend import Float, Vector3f
from renderer.core.records import NO_SHAPE, Ray
from renderer.engine import queries
from tests.support.soups import ball, geometry, unit


def lanes(array):
    """Return (N, 3) numbers as a vector of lanes."""
    return Vector3f(*(Float(np.float32(column)) for column in np.asarray(array).T))


def bundle(rng, count, spread):
    """Return origins and directions of rays in bundles of four that differ by `spread`, at a ball around the origin."""
    o = np.repeat(3 * unit(rng.normal(size=(-(-count // 4), 3))), 4, axis=0)[:count]
    spot = rng.uniform(-1, 1, (count, 3)) * spread  # first, so that the numbers come in this order
    aim = spot + np.repeat(rng.uniform(-1, 1, (-(-count // 4), 3)), 4, axis=0)[:count]
    return o + spread * rng.normal(size=(count, 3)), unit(aim - o)


def differences(scene, o, d):
    """Return how many rays meet something else in a group than alone, and the share that meets anything."""
    ray = Ray(lanes(o), lanes(d))
    alone, grouped = scene.intersect(ray), queries.closest(scene, ray, coherent=True)
    other = (alone.index.numpy() != grouped.index.numpy()) | (alone.t.numpy() != grouped.t.numpy())
    return other.sum(), (grouped.index.numpy() != NO_SHAPE).mean()


@pytest.fixture
def rng():
    """The same numbers for every test."""
    return np.random.default_rng(0)


@pytest.fixture(scope="module")
def scene():
    """A bumpy ball of some thousand triangles."""
    vertices, faces = ball(30, 0.2)
    return geometry(vertices[faces], "bvh")


@pytest.mark.parametrize("spread", [0, 1e-3, 0.1, 2], ids=["same", "close", "apart", "anywhere"])
@pytest.mark.parametrize("count", [1, 3, 4, 20_001])
def test_groups_meet_what_their_rays_meet(scene, rng, count, spread):
    """To the last bit, however little the rays of a group have in common, and if the last group is not full."""
    other, share = differences(scene, *bundle(rng, count, spread))
    assert other == 0 and (count < 5 or 0.05 < share < 0.9)


def test_groups_along_axes(scene, rng):
    """Rays along axes, up and down in one group: products of 0 and infinity, and rates of both signs."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    d = axes[rng.integers(6, size=8000)]
    other, share = differences(scene, rng.uniform(-1, 1, (8000, 3)) - 2 * d, d)
    assert other == 0 and share > 0.2


def test_not_a_number_does_not_spoil_its_neighbours(scene, rng):
    """It meets nothing; the three others of its group meet what they should."""
    o, d = bundle(rng, 4000, 1e-2)
    expected = queries.closest(scene, Ray(lanes(o), lanes(d)), coherent=True).index.numpy()
    o[::4, 1] = np.nan
    found = queries.closest(scene, Ray(lanes(o), lanes(d)), coherent=True).index.numpy()
    assert (found[::4] == NO_SHAPE).all()
    assert np.array_equal(np.delete(found, np.s_[::4]), np.delete(expected, np.s_[::4]))


def _by_the_first_ray(monkeypatch):
    monkeypatch.setattr(Slabs, "of_group", classmethod(lambda cls, rays, *scene: cls.of(rays[0], *scene)))


def _least_for_greatest(monkeypatch):
    monkeypatch.setattr(slabs_module, "greater", slabs_module.lesser)


@pytest.mark.parametrize("sabotage", [_by_the_first_ray, _least_for_greatest])
def test_boxes_of_a_part_of_the_group_are_noticed(scene, rng, monkeypatch, sabotage):
    """Rays that go apart need boxes of all of them."""
    sabotage(monkeypatch)
    assert differences(scene, *bundle(rng, 20_000, 0.1))[0] > 0
