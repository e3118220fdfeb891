"""Rays that leave a closed convex mesh, at any angle: outwards they meet nothing, inwards they meet the far side."""

import numpy as np
import pytest

from renderer.core.records import NO_SHAPE, Ray
from renderer.scene import triangles
from renderer.scene.geometry import leave
from tests.support.soups import ball, geometry, unit, vectors

ROWS, RAYS = 40, 60_000
# scale of the ball and where its middle is; far from the origin its facets' angles must stay above their rounding
PLACES = [(1.0, 0.0), (1e-4, 0.0), (1e4, 0.0), (1.0, 20.0), (1e3, 1e4)]


def departures(place, inwards):
    """Return how many rays leave a ball from triangles that they met from outside, and how many of those meet it again.

    Directions are between upright and 1e-3 above the triangle; those inwards at least 0.1 below all of its neighbours.
    """
    rng = np.random.default_rng(7)
    scale, offset = place
    v, faces = ball(ROWS)
    scene = geometry(np.float32(scale * v + offset)[faces], "bvh")
    o = np.float32(offset + 3 * scale * unit(rng.normal(size=(RAYS, 3))))
    target = offset + 0.9 * scale * unit(rng.normal(size=(RAYS, 3)))
    ray = Ray(vectors(o), vectors(unit(target - o)))
    hit = scene.intersect(ray)
    assert hit.valid.numpy().all()
    surface = scene.surface(ray, hit, with_uv=False)
    n = surface.n_geo.numpy().T.astype(float)
    along = unit(np.cross(n, rng.normal(size=n.shape)))
    up = 10.0 ** rng.uniform(-1 if inwards else -3, 0, (RAYS, 1))
    leaving = leave(surface, hit.index, vectors(unit(along + (-up if inwards else up) * n)))
    return (scene.intersect(leaving).index.numpy() != NO_SHAPE).sum()


@pytest.mark.parametrize("place", PLACES)
def test_what_leaves_outwards_meets_nothing(place):
    """Neither its own triangle nor a neighbour, though its point is known to rounding only."""
    assert departures(place, inwards=False) == 0


@pytest.mark.parametrize("place", PLACES)
def test_what_leaves_inwards_meets_the_far_side(place):
    """As glass needs it."""
    assert departures(place, inwards=True) == RAYS


@pytest.mark.parametrize("place", PLACES)
def test_points_must_be_moved_off_the_surface(monkeypatch, place):
    """Left where rounding put them, some lie below their neighbours, which rays close to the surface meet."""
    monkeypatch.setattr(triangles, "POINT_ROUNDOFFS", 0.0)
    monkeypatch.setattr(triangles, "EDGE_ROUNDOFFS", 0.0)
    assert departures(place, inwards=False) > 0
