"""What lights bring to a surface, against closed forms."""

import math

import numpy as np
import pytest

from tests.lights.room import Room, environment_file

LIGHT = np.array([1.0, 2.0, 3.0])
SIGMAS = 5
ROUNDING = 2e-5


def check(room, p, n, expected):
    """Demand an irradiance within five standard errors and rounding, and a standard error that tells something."""
    mean, error = room.irradiance(p, n)
    expected = np.asarray(expected) * LIGHT
    assert (error < 0.01 * expected.max()).all()
    assert (abs(mean - expected) < SIGMAS * error + ROUNDING * expected.max()).all()


def corner_form_factor(x, y):
    """Return E / (pi L) under the corner of a rectangle x by y at distance 1, parallel to the surface."""
    a, b = math.hypot(1, x), math.hypot(1, y)
    return (x / a * math.atan(y / a) + y / b * math.atan(x / b)) / (2 * math.pi)


@pytest.mark.parametrize("x, y", [(1.0, 1.0), (0.1, 3.0), (20.0, 0.5)])
def test_rectangle(tmp_path, x, y):
    """The form factor under a corner."""
    shape = {"type": "rectangle", "center": [x / 2, 1, y / 2], "u": [x, 0, 0], "v": [0, 0, y], "emission": [*LIGHT]}
    check(Room(tmp_path, [shape]), [0, 0, 0], [0, 1, 0], math.pi * corner_form_factor(x, y))


@pytest.mark.parametrize("radius", [0.1, 1.0, 5.0])
def test_disk(tmp_path, radius):
    """Below its middle E = pi L r^2 / (r^2 + h^2)."""
    shape = {"type": "disk", "center": [0.5, 3, 0], "normal": [0, -1, 0], "radius": radius, "emission": [*LIGHT]}
    check(Room(tmp_path, [shape]), [0.5, 1, 0], [0, 1, 0], math.pi * radius**2 / (radius**2 + 4))


def test_triangles_make_a_rectangle(tmp_path):
    """Two halves bring what the whole does."""
    corners = [0, 1, 0], [2, 1, 0], [2, 1, 3], [0, 1, 3]
    halves = [{"type": "triangle", "v0": corners[0], "v1": corners[a], "v2": corners[b], "emission": [*LIGHT]}
              for a, b in ((1, 2), (2, 3))]  # fmt: skip
    check(Room(tmp_path, halves), [0, 0, 0], [0, 1, 0], math.pi * corner_form_factor(2, 3))


@pytest.mark.parametrize("distance, radius", [(2.0, 1.0), (1000.0, 0.5), (1.001, 1.0), (30.0, 1e-3)])
def test_sphere(tmp_path, distance, radius):
    """E = pi L (r / d)^2 cos, as long as the whole sphere is above the horizon."""
    angle = 0.0 if distance < 1.5 else math.radians(50)
    center = [distance * math.sin(angle), distance * math.cos(angle), 0]
    shape = {"type": "sphere", "center": center, "radius": radius, "emission": [*LIGHT]}
    check(Room(tmp_path, [shape]), [0, 0, 0], [0, 1, 0], math.pi * (radius / distance) ** 2 * math.cos(angle))


def test_mesh(tmp_path):
    """A box as a mesh brings what its face that is seen does."""
    corners = [f"v {x} {y} {z}\n" for x in (0, 2) for y in (1, 4) for z in (0, 3)]
    faces = ["f 1 2 4 3\n", "f 5 7 8 6\n", "f 1 5 6 2\n", "f 3 4 8 7\n", "f 1 3 7 5\n", "f 2 6 8 4\n"]
    (tmp_path / "box.obj").write_text("".join(corners + faces))
    shape = {"type": "mesh", "filename": "box.obj", "emission": [*LIGHT]}
    check(Room(tmp_path, [shape]), [0, 0, 0], [0, 1, 0], math.pi * corner_form_factor(2, 3))


def test_points_fall_off_with_the_square(tmp_path):
    """I cos / d^2; a spot's factor falls linearly from beamwidth to cutoff."""
    point = {"type": "pointlight", "position": [3, 4, 0], "intensity": [*LIGHT]}
    assert np.allclose(Room(tmp_path, [], [point]).irradiance([0, 0, 0], [0, 1, 0], 16)[0], LIGHT * 0.8 / 25, rtol=1e-5)
    for angle_deg, factor in ((10, 1), (30, 0.5), (39, 0.05), (41, 0)):
        a = math.radians(angle_deg)
        spot = point | {"type": "spot", "position": [2 * math.sin(a), 2 * math.cos(a), 0], "direction": [0, -1, 0],
                        "cutoff": 40, "beamwidth": 20}  # fmt: skip
        mean = Room(tmp_path, [], [spot]).irradiance([0, 0, 0], [0, 1, 0], 16)[0]
        assert np.allclose(mean, LIGHT * factor * math.cos(a) / 4, rtol=1e-3, atol=1e-5)


def test_beam_as_wide_as_the_cutoff_has_an_edge(tmp_path):
    """Full up to the cutoff, and nothing beyond it."""
    for angle_deg, factor in ((29.9, 1), (30.1, 0)):
        a = math.radians(angle_deg)
        spot = {"type": "spot", "position": [math.sin(a), math.cos(a), 0], "direction": [0, -1, 0],
                "intensity": [1, 1, 1], "cutoff": 30, "beamwidth": 30}  # fmt: skip
        assert np.allclose(Room(tmp_path, [], [spot]).sample([0, 0, 0], 16).radiance.numpy(), factor, atol=1e-5)


def test_directional_light_knows_no_distance(tmp_path):
    """Its intensity is the irradiance of what faces it."""
    light = {"type": "directional", "direction": [1, -1, 0], "intensity": [*LIGHT]}
    for p in ([0, 0, 0], [1e5, -7, 3]):
        mean = Room(tmp_path, [], [light]).irradiance(p, [0, 1, 0], 16)[0]
        assert np.allclose(mean, LIGHT * math.sqrt(0.5), rtol=1e-6)


@pytest.mark.parametrize("size", [(2, 1), (16, 32), (33, 7)])
def test_constant_environment(tmp_path, size):
    """E = pi L, whatever the size of the image; sums over few rows are off where sin(theta) bends."""
    light = environment_file(tmp_path, np.ones((*size, 3)), intensity=[*LIGHT])
    check(Room(tmp_path, [], [light]), [0, 0, 0], [0.6, 0.8, 0], math.pi)


def test_all_kinds_together_add_up(tmp_path):
    """Choosing among lights of all kinds changes no sum; nine of them are chosen by tables."""
    disk = {"type": "disk", "center": [0, 2, 0], "normal": [0, -1, 0], "radius": 1, "emission": [*LIGHT]}
    sphere = {"type": "sphere", "center": [3, 0, 4], "radius": 0.5, "emission": [*LIGHT]}
    point = {"type": "pointlight", "position": [3, 4, 0], "intensity": [*LIGHT]}
    sun = {"type": "directional", "direction": [1, -1, 0], "intensity": [*LIGHT]}
    sky = environment_file(tmp_path, np.full((9, 16, 3), 0.3), intensity=[*LIGHT])
    n = [0.2, 0.9, math.sqrt(1 - 0.85)]
    one = [disk, sphere], [point, sun, sky]
    ball_share = 0.01 * math.pi * np.dot(n, [0.6, 0, 0.8])
    expected = (np.dot(n, [0, 1, 0]) * math.pi / 5 + ball_share + np.dot(n, [0.6, 0.8, 0]) / 25
                + math.sqrt(0.5) * np.dot(n, [-1, 1, 0]) + 0.3 * math.pi)  # fmt: skip
    check(Room(tmp_path, *one), [0, 0, 0], n, expected)
    again = [sphere | {"center": [-3, 0, 4 + k], "radius": 0.1} for k in range(8)]
    more = sum(math.pi * 0.01 * np.dot(n, [-3, 0, 4 + k]) / (9 + (4 + k) ** 2) ** 1.5 for k in range(8))
    check(Room(tmp_path, one[0] + again, one[1]), [0, 0, 0], n, expected + more)
