"""Camera rays: Mitsuba's own camera sends the same, what is in focus is sharp, and a closed lens is a pinhole."""

import dataclasses

import drjit as dr
import numpy as np
import pytest

from renderer.cameras import KINDS, kind_of
from renderer.core.backend import Vector2f
from renderer.engine.render import render
from renderer.scene.loader import override
from renderer.scene.schema import Camera
from renderer.scene.tables import compile_camera
from tests.support.scenes import MATT, loaded

RAYS = 2000
VIEW = Camera(width=120, height=80, position=(1.0, 2.0, -5.0), lookAt=(0.3, 0.5, 1.0), upVector=(0.2, 1.0, 0.1), fov=50)
LENS = dataclasses.replace(VIEW, type="thinlens", apertureRadius=0.3, focusDistance=4.0)
PLAN = dataclasses.replace(VIEW, type="orthographic")
VIEWS = {"pinhole": VIEW, "thinlens": LENS, "focused_on_lookAt": dataclasses.replace(LENS, focusDistance=None),
         "orthographic": PLAN, "low_plan": dataclasses.replace(PLAN, viewHeight=0.7)}


def numbers(seed=0):
    """Return positions on the film in [0, 1) and on the lens in [0, 1), (2, RAYS) each."""
    return np.random.default_rng(seed).random((2, 2, RAYS), dtype=np.float32)


def rays(camera, film, lens):
    """Return our origins and directions, (3, RAYS) each."""
    kind, row = compile_camera(camera)
    position = Vector2f(film[0] * camera.width, film[1] * camera.height)
    o, d = kind.ray(row, position, Vector2f(lens) if kind.has_lens else None)
    return np.broadcast_to(o.numpy(), (3, RAYS)), d.numpy()


def unit(v):
    """Return a vector of length 1."""
    return np.asarray(v) / np.linalg.norm(v)


@pytest.mark.oracle
@pytest.mark.parametrize("camera", VIEWS.values(), ids=VIEWS)
def test_rays_are_mitsubas(camera):
    """Origin and direction for the same numbers; the matrix is written down anew, with x to the left."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    film, lens = numbers()
    forward = unit(np.subtract(camera.lookAt, camera.position))
    right = unit(np.cross(camera.upVector, forward))
    distance, scale = np.linalg.norm(np.subtract(camera.lookAt, camera.position)), 1.0
    settings = {"type": "perspective", "fov": camera.fov, "fov_axis": "y"}
    if camera.type == "thinlens":
        focus = camera.focusDistance or distance
        settings |= {"type": "thinlens", "aperture_radius": camera.apertureRadius, "focus_distance": float(focus)}
    if camera.type == "orthographic":  # Mitsuba's is 2 units wide
        height = camera.viewHeight or 2 * distance * np.tan(np.radians(camera.fov / 2))
        settings, scale = {"type": "orthographic"}, height * camera.width / camera.height / 2
    matrix = np.eye(4)
    matrix[:3] = np.stack([-scale * right, scale * np.cross(forward, right), forward, camera.position], 1)
    sensor = mi.load_dict({**settings, "to_world": mi.ScalarTransform4f(matrix), "near_clip": 1e-3, "far_clip": 1e4,
                           "film": {"type": "hdrfilm", "width": camera.width, "height": camera.height}})  # fmt: skip
    theirs, _ = sensor.sample_ray(0.0, 0.0, mi.Point2f(film), mi.Point2f(lens))
    o, d = rays(camera, film, lens)
    # theirs start on the near plane
    passed = np.sum((theirs.o.numpy() - o) * d, 0)
    assert np.abs(theirs.o.numpy() - passed * d - o).max() < 3e-6
    assert np.abs(theirs.d.numpy() - d).max() < 2e-6


def test_plan_shows_what_a_pinhole_does_at_lookat():
    """Without a height of its own: there, both rays through a point of the picture meet; elsewhere they do not."""
    film, lens = numbers(3)
    forward = unit(np.subtract(VIEW.lookAt, VIEW.position))
    (o, d), (eye, straight) = rays(PLAN, film, lens), rays(VIEW, film, lens)
    distance = np.linalg.norm(np.subtract(VIEW.lookAt, VIEW.position))
    assert np.abs(o + d * distance - eye - straight * distance / (forward @ straight)).max() < 1e-5
    assert np.abs(forward @ (o.T - VIEW.position).T).max() < 1e-6 and np.abs(d - forward[:, None]).max() < 1e-7


def test_rays_of_one_point_meet_in_the_plane_in_focus():
    """Wherever they leave the lens, at focusDistance along forward they are where the pinhole's ray is."""
    film, lens = numbers(1)
    forward = unit(np.subtract(LENS.lookAt, LENS.position))
    (o, d), (eye, straight) = rays(LENS, film, lens), rays(VIEW, film, lens)
    here, there = ((o + d * (4.0 - forward @ (o.T - LENS.position).T) / (forward @ d)),
                   eye + straight * 4.0 / (forward @ straight))
    assert np.abs(here - there).max() < 1e-5


def test_lens_is_a_disk_across_the_view():
    """Origins fill a disk of the aperture's radius that stands upright on the direction of view."""
    film, lens = numbers(2)
    forward = unit(np.subtract(LENS.lookAt, LENS.position))
    offset = rays(LENS, film, lens)[0] - np.reshape(LENS.position, (3, 1))
    distance = np.linalg.norm(offset, axis=0)
    assert np.abs(forward @ offset).max() < 1e-6 and 0.297 < distance.max() < 0.30001
    assert np.mean(distance < 0.3 / np.sqrt(2)) == pytest.approx(0.5, abs=0.05)


def test_closed_lens_is_a_pinhole():
    """The same code, not just the same rays; and without numbers a ray leaves the middle of the lens."""
    assert kind_of(dataclasses.replace(LENS, apertureRadius=0.0)) is KINDS["pinhole"]
    assert kind_of(LENS) is KINDS["thinlens"] and kind_of(VIEW) is KINDS["pinhole"]
    assert kind_of(PLAN) is KINDS["orthographic"]
    kind, row = compile_camera(LENS)
    position = Vector2f(numbers()[0] * 80)
    straight = compile_camera(VIEW)
    for ours, theirs in zip(kind.ray(row, position), straight[0].ray(straight[1], position)):
        assert dr.all(ours == theirs, axis=None)


@pytest.mark.parametrize("mode", ["binary", "phong"])
def test_lens_blurs_what_is_out_of_focus(tmp_path, mode):
    """A ball in focus has the pinhole's edge; far off, its edge is a ramp. One sample a pixel sees no lens."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 0.8, "material": MATT}

    def partly(**camera):
        scene = loaded(tmp_path, [ball], rendermode=mode, samples=64, ambientlight=[1, 1, 1], backgroundcolor=[0, 0, 0],
                       camera={"width": 48, "height": 48, **camera})
        picture = render(scene).channels()["R"]
        return np.sum((picture > 0.02 * picture.max()) & (picture < 0.98 * picture.max())), scene

    pinhole, plain = partly()
    sharp, _ = partly(type="thinlens", apertureRadius=0.3, focusDistance=4)
    blurred, lens = partly(type="thinlens", apertureRadius=0.3, focusDistance=1)
    assert sharp < 1.5 * pinhole and blurred > 4 * pinhole
    one, other = (render(override(scene, samples=1)).channels()["R"] for scene in (plain, lens))
    assert np.array_equal(one, other)
