"""Closed meshes have no holes: whoever is inside sees a triangle in every direction, and whoever enters comes out."""

from functools import cache

import drjit as dr
import numpy as np
import pytest

from renderer.accel import nodes, slabs, watertight
from renderer.core.backend import Bool, Float, UInt32
from renderer.core.numeric import FAR
from renderer.core.records import NO_SHAPE, Ray
from tests.support.soups import ball, dyadic_ball, geometry, unit, vectors

ROWS = 112  # 100,352 triangles
CHUNK = 250_000
TURN = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
BITS = 10

# name -> where the unit mesh goes, as a function of its vertices (V, 3) in double precision
PLACES = {
    "plain": lambda v: v,
    "far away": lambda v: v + [1e6, -1e6, 1e6],  # coordinates are multiples of 1/16 there: most triangles are needles
    "far away and large": lambda v: 1e3 * v + [1e6, 2e5, -1e6],
    "tiny": lambda v: 1e-6 * v,
    "giant": lambda v: 1e6 * v,
    "stretched": lambda v: v * [1000, 1, 1],
    "stretched and turned": lambda v: v * [1000, 1, 1] @ TURN,
}


@pytest.fixture
def rng():
    """A generator that every test starts from the same state."""
    return np.random.default_rng(20240229)


class Mesh:
    """A closed mesh in its place, with its hierarchy."""

    def __init__(self, place, rows=ROWS, shape=ball):
        v, self.faces = shape(rows) if shape is dyadic_ball else shape(rows, 0.15)
        self.v = np.float32(PLACES[place](v))
        self.middle = PLACES[place](np.zeros((1, 3)))[0]
        self.place = PLACES[place]
        self.scene = geometry(self.v[self.faces], "bvh")

    def inside(self, rng, count):
        """Return float32 points in half of the mesh's size around its middle."""
        return np.float32(self.place(0.5 * rng.uniform(-1, 1, (count, 3)) / np.sqrt(3)))

    def hard_points(self, rng, count):
        """Return corners, points on edges, and points of triangles, a third each, in double precision."""
        at_corner = rng.random((count, 1)) < 0.5
        share = np.where(at_corner, np.eye(3)[rng.integers(3, size=count)], rng.dirichlet((1, 1, 1), count))
        on_edge = rng.random(count) < 1 / 3
        share[on_edge] = rng.dirichlet((1, 1), on_edge.sum()) @ np.eye(3)[:2]
        corners = self.v[self.faces[rng.integers(len(self.faces), size=count)]].astype(np.float64)
        return np.einsum("nk,nkx->nx", share, corners)


def aimed(o, target, rng):
    """Return unit directions from o to targets, a third of them off by one unit in the last place of a component."""
    d = unit(target - o.astype(np.float64))
    moved = rng.random(len(d)) < 1 / 3
    at = np.flatnonzero(moved), rng.integers(3, size=moved.sum())
    d[at] = np.nextafter(d[at], np.float32(rng.choice([-2, 2], len(at[0]))))
    return d


def met(scene, o, d, left=None, beyond=None):
    """Return the triangles that rays meet, but for those in `left`, and only beyond a distance; NO_SHAPE for none."""
    ray = Ray(vectors(o), vectors(d), None if left is None else UInt32(left), None if left is None else Bool(False))
    leaf = scene.leaf_test(ray)

    def farther(words):
        inside, t, index = leaf(words)
        return inside & (t > beyond), t, index

    test = leaf if beyond is None else farther
    _, index = scene.structure.trace(ray, Float(FAR), UInt32(NO_SHAPE), test, Bool(True))
    return index.numpy()


def leaks_inside(mesh, rng, count):
    """Return how many of `count` rays from inside meet nothing: a quarter in any direction, the others aimed."""
    leaks = 0
    for first in range(0, count, CHUNK):
        size = min(CHUNK, count - first)
        o = mesh.inside(rng, size)
        o[: size // 8] = mesh.middle
        any_way = unit(rng.normal(size=(size, 3)))
        d = np.where(rng.random((size, 1)) < 0.25, any_way, aimed(o, mesh.hard_points(rng, size), rng))
        leaks += (met(mesh.scene, o, d) == NO_SHAPE).sum()
    return leaks


def lonely_entries(mesh, rng, count, distance):
    """Return how many of `count` lines meet exactly one triangle, and how many meet any.

    A line through a closed mesh meets at least two. Origins lie `distance` times the mesh's size away.
    """
    lonely = entries = 0
    size = np.ptp(mesh.v, axis=0).max()
    for first in range(0, count, CHUNK):
        n = min(CHUNK, count - first)
        o = np.float32(mesh.middle + distance * size * unit(rng.normal(size=(n, 3))))
        d = aimed(o, mesh.hard_points(rng, n), rng)
        index = met(mesh.scene, o, d)
        hit = index != NO_SHAPE
        entries += hit.sum()
        lonely += (met(mesh.scene, o[hit], d[hit], left=index[hit]) == NO_SHAPE).sum()
    return lonely, entries


@cache
def placed(place):
    """Return the Mesh in a place, built once."""
    return Mesh(place)


# far from the world's origin, and where triangles are long and aslant, boxes overlap: rays take a hundred times longer
LABORIOUS = {"far away", "stretched and turned"}
INSIDE = [(place, 15_000 if place in LABORIOUS else 180_000) for place in PLACES]
INSIDE += [pytest.param(place, 100_000 if place in LABORIOUS else 2_000_000, marks=pytest.mark.slow)
           for place in PLACES]  # fmt: skip


@pytest.mark.parametrize("place, count", INSIDE)
def test_nothing_is_seen_through_a_closed_mesh(rng, place, count):
    """From inside, towards everything and towards corners and edges, and one unit in the last place beside them."""
    assert leaks_inside(placed(place), rng, count) == 0


OUTSIDE = [("plain", 2, 50_000), ("giant", 1e3, 50_000), ("stretched", 1e3, 50_000),
           ("stretched and turned", 2, 10_000), ("tiny", 1e5, 3000), ("far away and large", 1e3, 10_000)]  # fmt: skip
OUTSIDE += [pytest.param(place, distance, 2000 if distance > 1e4 else 300_000, marks=pytest.mark.slow)
            for place in ("plain", "tiny", "giant", "stretched") for distance in (2, 1e3, 1e5)]  # fmt: skip


@pytest.mark.parametrize("place, distance, count", OUTSIDE)
def test_what_enters_comes_out(rng, place, distance, count):
    """Also from so far away that a triangle is smaller than the rounding of its corners there."""
    lonely, entries = lonely_entries(placed(place), rng, count, distance)
    assert lonely == 0
    assert entries > 0.1 * count


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [1, -1])
def test_rays_exactly_through_corners_and_edges(rng, axis, sign):
    """Along axes, from below a corner or below the middle of an edge: all of that is exact in float32."""
    mesh = Mesh("plain", 64, dyadic_ball)
    corners = mesh.v[mesh.faces]
    target = np.concatenate([corners.reshape(-1, 3), (corners + np.roll(corners, 1, 1)).reshape(-1, 3) / 2])
    o = target.copy()
    o[:, axis] = 0
    o = o[np.linalg.norm(o, axis=1) < 0.8]
    assert len(o) > 50_000 and (o * 2.0 ** (BITS + 1) % 1 == 0).all()
    assert (met(mesh.scene, o, np.tile(sign * np.eye(3)[axis], (len(o), 1))) != NO_SHAPE).all()


def test_through_the_middle_from_afar_both_sides_are_met(rng):
    """What a line through the mesh's core meets lies before it and behind it."""
    mesh = placed("plain")
    for distance in (3, 100, 1e4):
        core = 0.5 * unit(rng.normal(size=(50_000, 3)))
        o = np.float32(distance * unit(rng.normal(size=core.shape)))
        d = unit(core - o)
        middle = np.float32(-(o.astype(np.float64) * d).sum(1))
        front = mesh.scene.intersect(Ray(vectors(o), vectors(d)))
        assert (front.t.numpy() < middle).all()
        assert (met(mesh.scene, o, d, beyond=Float(middle)) != NO_SHAPE).all()


# Sabotage: each must leak


def _single_rounding(a, b):
    return dr.fma(a.x, b.y, -(a.y * b.x))


def _strict(a, b, c, at_a, at_b, at_c):
    inside = ((at_a > 0) & (at_b > 0) & (at_c > 0)) | ((at_a < 0) & (at_b < 0) & (at_c < 0))
    return inside, dr.fma(at_a, a.z, dr.fma(at_b, b.z, at_c * c.z)) / (at_a + at_b + at_c)


def _inwards(planes):
    def rounded(*args):
        return [(lower + 1, dr.select(upper > 0, upper - 1, 0)) for lower, upper in planes(*args)]

    return rounded


def test_without_compensation_it_leaks(monkeypatch, rng):
    """Neighbours then disagree on which side of their edge a ray passes."""
    monkeypatch.setattr(watertight, "edge", _single_rounding)
    assert leaks_inside(Mesh("stretched"), rng, 100_000) > 0


def test_with_strict_signs_it_leaks(monkeypatch, rng):
    """A ray through an edge belongs to both neighbours, or to none."""
    monkeypatch.setattr(watertight, "_triangle", _strict)
    mesh = Mesh("plain", 64, dyadic_ball)
    o = mesh.v[np.linalg.norm(mesh.v[:, :2], axis=1) < 0.8] * np.float32([1, 1, 0])
    assert (met(mesh.scene, o, np.tile(np.eye(3)[2], (len(o), 1))) == NO_SHAPE).any()


def test_without_slack_it_leaks(monkeypatch, rng):
    """From afar a hit lies outside of its triangle's box by more than that is widened otherwise."""
    monkeypatch.setattr(slabs, "BOX_ROUNDOFFS", 0.0)
    lonely, _ = lonely_entries(Mesh("plain"), rng, 100_000, 1e3)
    assert lonely > 0


def test_with_planes_rounded_inwards_it_leaks(monkeypatch, rng):
    """Boxes then do not hold their triangles."""
    monkeypatch.setattr(nodes, "_planes", _inwards(nodes._planes))
    assert leaks_inside(Mesh("plain"), rng, 100_000) > 0
