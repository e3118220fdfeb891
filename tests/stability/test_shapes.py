"""What shapes must do on hard rays where the naive formula does no worse, and where an answer is right or wrong."""

import math

import numpy as np
import pytest

from renderer.core import hull
from renderer.core.backend import Float
from renderer.core.numeric import TINY, away_from_zero
from renderer.core.records import Ray
from renderer.scene import schema
from renderer.scene.tables import compile_scene
from tests.stability import cylinders, probe, slabs, spheres
from tests.stability.case import ULP
from tests.support.scenes import loaded

COUNT = 5000
SMALL = (0.0, 1e-45, 1e-38, TINY / 2, TINY, 2 * TINY, 1e-20, 1e-10, 1.0)


@pytest.fixture
def rng():
    """A generator that every test starts from the same state."""
    return np.random.default_rng(50)


@pytest.mark.parametrize("height", [10.0**-k for k in range(1, 7)])
@pytest.mark.parametrize("sphere", [spheres.PLAIN, spheres.GROUND], ids=["plain", "ground"])
def test_rays_from_just_outside_of_a_sphere_end_on_it(rng, sphere, height):
    """c is nearly 0: the distance is short of digits, the point is not."""
    n = probe.unit(rng.normal(size=(COUNT, 3)))
    o = (sphere.center + sphere.radius * (1 + height) * n.astype(float)).astype(np.float32)
    d = probe.unit(rng.normal(size=(COUNT, 3)))
    found = probe.ours(sphere, o, d)
    off = spheres.off(sphere, probe.at(o, d, found.t)) / spheres.scale(sphere, o)
    assert found.hit.sum() > COUNT / 20
    assert off[found.hit].max() < 4


def test_points_and_normals_of_the_ground_are_exact_to_rounding():
    """The coursework's sphere of radius 25.1, from above and along it; a roundoff of its coordinates is 3e-6."""
    o, d = spheres.over_ground()
    found = probe.ours(spheres.GROUND, o, d)
    q = found.p - spheres.GROUND.center
    assert found.hit.all()
    assert spheres.settled((spheres.GROUND, o, d))(probe.ours).max() < 2
    assert np.abs(found.n - q / np.linalg.norm(q, axis=-1, keepdims=True)).max() < 4 * ULP


def test_a_horizon_a_million_radii_wide_is_met_from_a_unit_above():
    """Rays down end on the sphere, rays up do not, and those along it see at most the rounding of the height."""
    earth = probe.sphere((0, -1e6, 0), 1e6)
    rng = np.random.default_rng(3)
    o = np.tile(np.float32([0, 1, 0]), (COUNT, 1))
    d = probe.unit(rng.normal(size=(COUNT, 3)))
    found, dip = probe.ours(earth, o, d), math.sqrt(2 / 1e6)
    assert (found.hit[d[:, 1] < -1.1 * dip]).all() and not found.hit[d[:, 1] > -0.9 * dip].any()
    assert spheres.off(earth, found.p[found.hit]).max() < 1e6 * 2 * ULP


def test_rays_along_a_thin_cylinder_end_on_it():
    """Also those that leave by the side, after 1e4 radii within it."""
    shape = cylinders.THIN
    o, d = cylinders.along(shape, 3.0, 1e-5, 3, widest=0.6)
    assert cylinders.met(shape, o, d, 4.3)(probe.ours).max() < 8
    o = (o - 2.5 * cylinders.directions(shape)[0]).astype(np.float32)  # half a unit above the middle: within
    off = cylinders.off(shape, probe.at(o, d, probe.ours(shape, o, d).t))
    assert np.nanmax(off) < 8 * ULP


def test_rays_in_a_face_s_plane_end_on_the_box_or_miss():
    """Either is right, a point off the box and NaN are not."""
    o, d = slabs.parallel(slabs.PLAIN, 7, on_face=True)
    found = probe.ours(slabs.PLAIN, o, d)
    assert 0.05 < found.hit.mean() < 0.5
    assert slabs.off(slabs.PLAIN, found.p[found.hit]).max() < 4 * ULP
    assert not np.isnan(found.t).any()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("value", SMALL)
def test_nothing_is_moved_to_zero(sign, value):
    """Which x + 1e-30 would do to -1e-30; the sign stays, that of -0 too."""
    moved = away_from_zero(Float(np.float32([sign * value]))).numpy()[0]
    assert moved != 0 and math.copysign(1, moved) == sign
    assert value <= abs(moved) <= 1.0001 * (value + TINY)


@pytest.mark.parametrize("accel", ["none", "bvh", "grid"])
@pytest.mark.parametrize("value", [part for value in SMALL[:-2] for part in (value, -value)])
def test_rays_along_an_axis_meet_what_is_there(tmp_path, rng, accel, value):
    """Boxes in a row, through every structure; no component across is small in a wrong way."""
    row = [{"type": "box", "min": [3 * k, -0.5, -0.25], "max": [3 * k + 1, 0.5, 0.25]} for k in range(8)]
    scene = compile_scene(loaded(tmp_path, row), accel)
    o = np.column_stack([np.full(COUNT, -2), rng.uniform(-0.49, 0.49, COUNT), rng.uniform(-0.24, 0.24, COUNT)])
    d = np.tile(np.float32([1, value, value]), (COUNT, 1))
    hit = scene.intersect(Ray(probe.vectors(o), probe.vectors(d)))
    np.testing.assert_array_equal(hit.t.numpy(), 2)


def test_volumes_have_a_point_of_their_own_only_far_away():
    """Near the origin nothing is subtracted, also where another kernel would be compiled for it."""
    kind, near, far = probe.KINDS["convex"], slabs.wedge()[0], slabs.gem(slabs.PLACES[0])
    assert kind.columns([near]) == 20
    assert hull.anchor(hull.unit_halfspaces(near.halfspaces, None), None) is None
    assert kind.columns([near, far]) % 4 == 3
    assert kind.pack(near, kind.columns([near, far]))[-3:] == [0, 0, 0]
    assert np.allclose(kind.pack(far, kind.columns([far]))[-3:], slabs.PLACES[0], atol=1)


def test_half_spaces_far_away_are_met_as_the_hull_of_their_corners(rng):
    """A cube at 1e6 by its faces, beside one at the origin: exact in both."""
    places = ((0, 0, 0), (1e6, -1e6, 5e5))
    faces = [(*(sign * row), 0.5) for row in np.eye(3) for sign in (1, -1)]
    cubes = tuple(schema.Convex(halfspaces=tuple((*n, d + float(np.dot(n, place))) for *n, d in faces))
                  for place in places)
    for place in places:
        o = (np.array(place) + 3 * probe.unit(rng.normal(size=(COUNT, 3)))).astype(np.float32)
        d = probe.unit(place + rng.uniform(-0.49, 0.49, o.shape) - o)
        found = probe.ours(cubes, o, d)
        outside = np.abs(probe.at(o, d, found.t) - place).max(-1) - 0.5
        assert np.abs(outside).max() < 8 * 3 * ULP
        assert np.abs(np.abs(found.p - place).max(-1) - 0.5).max() <= max(np.abs(place).max(), 1) * ULP
