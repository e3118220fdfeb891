"""Path tracing against closed forms: what light must be, whatever finds it."""

import math

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import Float
from renderer.engine.render import render
from renderer.integrators import path
from renderer.scene.loader import from_dict, override
from renderer.scene.scattering import Look
from tests.support.documents import CAMERA

CLOSE = 4.5  # standard errors that a mean may be off; one in 150,000 right ones is
BLACK = {"bsdf": {"type": "diffuse", "reflectance": [0, 0, 0]}}


def matt(*reflectance):
    """Return a Lambertian material."""
    return {"bsdf": {"type": "diffuse", "reflectance": list(reflectance)}}


def scene(shapes, lights=(), nbounces=2, camera=None, background=(0, 0, 0), samples=64, **keys):
    """Return a loaded path-traced scene of 24 x 16 pixels."""
    world = {"backgroundcolor": list(background), "lightsources": list(lights), "shapes": shapes}
    view = {**CAMERA, "width": 24, "height": 16, **(camera or {})}
    return from_dict({"rendermode": "pathtracer", "nbounces": nbounces, "samples": samples, "roulette": False,
                      "camera": view, "scene": world, **keys})


def picture(loaded, **settings):
    """Return (H, W, 3) linear radiance."""
    channels = render(loaded, **settings).channels()
    return np.stack([channels[c] for c in "RGB"], axis=-1).astype(np.float64)


def agree(values, expected):
    """Whether the mean of independent values is `expected` within their scatter (or rounding)."""
    error = max(np.std(values) / math.sqrt(np.size(values)), 2e-6 * abs(expected))
    return abs(np.mean(values) - expected) < CLOSE * error


def inside(radius=5.0, reflectance=(0.6, 0.6, 0.6), emission=(1.0, 1.0, 1.0)):
    """Return a closed room of six shining walls around the camera."""
    r = radius
    walls = []
    for axis in range(3):
        for side in (-r, r):
            center, u, v = [0, 0, 0], [0, 0, 0], [0, 0, 0]
            center[axis], u[(axis + 1) % 3], v[(axis + 2) % 3] = side, 2 * r, 2 * r
            walls.append({"type": "rectangle", "center": center, "u": u, "v": v, "material": matt(*reflectance),
                          "emission": list(emission)})
    return walls


IN_THE_MIDDLE = {"position": [0.1, 0.2, -0.3], "lookAt": [1, 2, 3]}


@pytest.mark.parametrize("bounces", [0, 1, 2, 5])
def test_closed_shining_room(bounces):
    """In a room whose walls emit 1 and reflect a, everything has the radiance 1 + a + ... + a^bounces."""
    seen = picture(scene(inside(), nbounces=bounces, camera=IN_THE_MIDDLE))
    assert agree(seen[..., 0], sum(0.6**k for k in range(bounces + 1)))


def test_room_of_a_wrong_reflectance_is_noticed():
    """A reflectance that is 1 % off is seen at the samples that these tests take."""
    seen = picture(scene(inside(reflectance=[0.606] * 3), nbounces=2, camera=IN_THE_MIDDLE))
    assert not agree(seen[..., 0], sum(0.6**k for k in range(3)))


@pytest.mark.parametrize("accel", ["none", "bvh"])
def test_roulette_changes_no_mean(accel):
    """Paths that end at random weigh more where they go on."""
    seen = picture(scene(inside(), nbounces=30, camera=IN_THE_MIDDLE, roulette=True, samples=256), accel=accel)
    assert agree(seen[..., 1], (1 - 0.6**31) / 0.4)


def test_white_sphere_in_a_white_furnace_vanishes():
    """What reflects all light looks like the light around it."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": matt(1, 1, 1)}
    seen = picture(scene([ball], nbounces=50, background=(1, 1, 1)))
    assert agree(seen[..., 2], 1)


def test_point_light_falls_off():
    """Under a point light of intensity I, radiance is reflectance / pi I cos / r^2."""
    ground = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": matt(0.5, 0.25, 1)}
    light = {"type": "pointlight", "position": [0, 2, 0], "intensity": [3, 3, 3]}
    camera = {"position": [0, 1, 0], "lookAt": [0, 0, 0], "upVector": [0, 0, 1], "fov": 0.1}
    seen = picture(scene([ground], [light], camera=camera, samples=1)).mean((0, 1))
    np.testing.assert_allclose(seen, np.array([0.5, 0.25, 1]) / math.pi * 3 / 4, rtol=1e-4)


STRATEGIES = {
    "lights alone": (lambda light, pdf_sa: Float(1),
                     lambda path, pdf_sa: dr.select((path.pdf_sa > 0) & (pdf_sa > 0), 0, Float(1))),
    "BSDFs alone": (lambda light, pdf_sa: dr.select(light.delta, Float(1), 0), lambda path, pdf_sa: Float(1)),
}
LAMP = {"type": "arealight", "position": [0.3, 1.6, 0.2], "u": [1.2, 0, 0], "v": [0, 0.1, 1.0], "intensity": [4, 3, 2]}
STILL = [
    {"type": "sphere", "center": [-0.5, -0.4, 0], "radius": 0.5, "material": matt(0.7, 0.5, 0.3)},
    {"type": "plane", "point": [0, -0.9, 0], "normal": [0, 1, 0], "material": matt(0.6, 0.6, 0.6)},
]


@pytest.mark.parametrize("accel", ["none", "bvh"])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_every_strategy_finds_the_same_light(monkeypatch, strategy, accel):
    """Sampling lights alone, BSDFs alone, and both give one mean."""
    loaded = scene(STILL, [LAMP], background=(0.2, 0.3, 0.4), samples=1024)
    both = picture(loaded, accel=accel)
    light_share, weight = STRATEGIES[strategy]
    monkeypatch.setattr(path, "_light_share", light_share)
    monkeypatch.setattr(path, "_weight", weight)
    alone = picture(loaded, seed=1, accel=accel)
    difference = (alone - both).mean((0, 1)) / both.mean((0, 1))
    assert np.abs(difference).max() < 0.01, difference


def test_a_lost_weight_is_noticed(monkeypatch):
    """With both strategies at full weight, light is counted twice."""
    loaded = scene(STILL, [LAMP], samples=256)
    right = picture(loaded)
    monkeypatch.setattr(path, "_light_share", lambda light, pdf_sa: Float(1))
    monkeypatch.setattr(path, "_weight", lambda path, pdf_sa: Float(1))
    assert picture(loaded).mean() > 1.2 * right.mean()


@pytest.mark.parametrize("nbounces", [1, 3])
def test_both_drivers_give_the_same_picture(nbounces):
    """The way through a hierarchy finds what tests of all shapes find: the same samples, up to rounding."""
    box = {"type": "box", "min": [0.3, -0.9, -0.2], "max": [0.9, -0.1, 0.5], "material": matt(0.4, 0.7, 0.4)}
    loaded = scene([*STILL, box],
                   [LAMP, {"type": "pointlight", "position": [-1, 1, -1], "intensity": [1, 2, 1]}], nbounces=nbounces)
    one, other = picture(loaded, accel="none"), picture(loaded, accel="bvh")
    assert np.median(np.abs(one - other)) < 1e-6
    assert abs(one.mean() - other.mean()) < 2e-3 * one.mean()


def test_albedo_shows_what_bsdfs_reflect():
    """The debug mode tells materials apart by their BSDF where they have one."""
    colours = [0.7, 0.5, 0.3], [0.6, 0.6, 0.6]
    loaded = override(scene(STILL), mode="albedo")
    channels = render(loaded).channels()
    seen = np.stack([channels[f"Albedo.{c}"] for c in "RGB"], axis=-1).reshape(-1, 3)
    assert {tuple(colour) for colour in seen.astype(float).round(5).tolist()} == {(0.0, 0.0, 0.0), *map(tuple, colours)}


@pytest.mark.parametrize("accel", ["none", "bvh"])
@pytest.mark.parametrize("part", ["direct light", "throughput"])
def test_what_is_not_a_number_is_noticed(monkeypatch, part, accel):
    """It makes its sample one that is left out and told, wherever it comes from."""
    if part == "direct light":
        monkeypatch.setattr(path, "_light_share", lambda light, pdf_sa: Float(math.nan))
    else:
        right = Look.sample

        def wrong(self, wi, u, u2):
            found = right(self, wi, u, u2)
            found.weight = found.weight * Float(math.nan)
            return found

        monkeypatch.setattr(Look, "sample", wrong)
    rendering = render(scene(STILL, [LAMP], background=(0.2, 0.3, 0.4), samples=16), accel=accel)
    assert rendering.lost.count > 24 * 16 * 16 / 4 and rendering.lost.examples[0][0] == "nan"
