"""Whole scenes in a grid: shapes of all kinds, rays that left one, and pictures."""

import json
from dataclasses import replace

import drjit as dr
import numpy as np
import pytest

from renderer.accel.brute_force import BruteForce
from renderer.accel.grid import Grid
from renderer.core.backend import Bool, Float
from renderer.core.records import Ray
from renderer.engine.render import render
from renderer.scene.loader import from_dict
from renderer.scene.tables import compile_scene
from tests.accel.build_inputs import vector
from tests.support.scenes import MATT, document, point_light

RAYS = 100_000
CORNERS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]])


def shapes(count, seed=1):
    """Return shapes of all kinds at random, and a plane, which is in no structure."""
    rng = np.random.default_rng(seed)
    made = [{"type": "plane", "point": [0, -2.5, 0], "normal": [0.1, 1, 0]}]
    for number in range(count):
        centre, size = 4 * rng.random(3) - 2, 0.3 * rng.random()
        made.append([
            {"type": "sphere", "center": list(centre), "radius": size},
            {"type": "cylinder", "center": list(centre), "axis": list(rng.normal(size=3)), "radius": size,
             "height": 0.4},
            {"type": "box", "min": list(centre - size), "max": list(centre + size * rng.random(3))},
            {"type": "convex", "vertices": (centre + size * CORNERS).tolist()},
            {"type": "triangle", **dict(zip(("v0", "v1", "v2"), (centre + size * rng.normal(size=(3, 3))).tolist()))},
        ][number % 5] | {"material": dict(MATT, diffusecolor=list(rng.random(3)))})
    return json.loads(json.dumps(made))  # plain numbers, as in a file


def scenes(count=300):
    """Return the same scene in a grid and in a list, which are asked for the same leaf records."""
    in_grid = compile_scene(from_dict(document(shapes(count))), "grid")
    assert isinstance(in_grid.structure, Grid)
    return in_grid, replace(in_grid, structure=BruteForce(in_grid.structure._leaves))


def random_rays(seed=3):
    """Return rays from in and around the scene; some along an axis."""
    rng = np.random.default_rng(seed)
    o, d = 6 * rng.random((RAYS, 3)) - 3, rng.normal(size=(RAYS, 3))
    d[rng.random((RAYS, 3)) < 0.2] = 0
    d[:, 1] += 1e-3 * (abs(d).sum(1) == 0)
    away = rng.choice([0.0, 0.0, 10.0, 1e3, 1e5], (RAYS, 1))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return vector(o - away * d), vector(d)


def same(first, second):
    """Return whether two hits are equal bit for bit."""
    return all(np.array_equal(np.array(a), np.array(b)) for a, b in ((first.t, second.t), (first.index, second.index)))


def test_all_kinds_are_found():
    """At the same distance as by testing everything; also by rays that leave one of them."""
    in_grid, plain = scenes()
    o, d = random_rays()
    hit, expected = (scene.intersect(Ray(o, d)) for scene in (in_grid, plain))
    assert same(hit, expected)
    assert len(np.unique(np.array(hit.index))) > 250

    rng = np.random.default_rng(5)
    turned = vector(np.array(d).T[rng.permutation(RAYS)])
    p = dr.fma(d, dr.select(hit.valid, hit.t, 0), o)
    ray = Ray(p, turned, hit.index, Bool(rng.random(RAYS) < 0.5))
    dr.eval(ray)
    assert same(in_grid.intersect(ray), plain.intersect(ray))


@pytest.mark.parametrize("share", [0.3, 1.0, 2.0])
def test_shadows_are_the_same(share):
    """Of lights before, at and behind what is in the way."""
    in_grid, plain = scenes()
    ray, active = Ray(*random_rays(7)), Bool(np.random.default_rng(8).random(RAYS) < 0.9)
    hit = plain.intersect(ray)
    distance = dr.select(hit.valid, hit.t * Float(share), 5)
    shadowed, expected = (np.array(scene.occluded(ray, distance, active)) for scene in (in_grid, plain))
    assert np.array_equal(shadowed, expected)
    assert expected.any() == (share > 1)


@pytest.mark.parametrize("mode", ["phong", "shapes", "depth"])
def test_pictures_are_the_same(mode):
    """Byte for byte."""
    light, size = point_light([3, 5, -4], [30, 30, 30]), {"width": 80, "height": 60}
    content = document(shapes(60), [light], size, rendermode=mode)
    pictures = [render(from_dict(content), accel=accel).rgb8() for accel in ("grid", "none", "auto")]
    assert pictures[0] == pictures[1] == pictures[2]
    assert len(set(pictures[0])) > 20


def test_scene_without_bounded_shapes_needs_no_grid():
    """A plane alone, and nothing at all."""
    for some in ([], shapes(0)):
        scene = compile_scene(from_dict(document(some)), "grid")
        assert scene.structure is None
