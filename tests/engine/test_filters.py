"""Reconstruction filters: their formulas are Mitsuba's, their samples are distributed like them, edges are right."""

import math

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import Vector2f
from renderer.engine import filters
from renderer.engine.filters import FILTERS
from renderer.engine.render import render
from renderer.scene.loader import override
from tests.support.scenes import loaded

FUNCTIONS = {"box": lambda x: float(abs(x) <= 0.5), "tent": filters.tent, "gaussian": filters.gaussian,
             "mitchell": filters.mitchell}  # fmt: skip
# Mitsuba's Gaussian is a polynomial that agrees with the function to four digits
TOLERANCE = {"tent": 1e-6, "gaussian": 5e-4, "mitchell": 1e-6}
RADII = {"box": 0.5, "tent": 1.0, "gaussian": 2.0, "mitchell": 2.0}
every_filter = pytest.mark.parametrize("name", FILTERS)


@pytest.mark.oracle
@pytest.mark.parametrize("name", TOLERANCE)
def test_filter_is_mitsubas(name):
    """At its defaults, radius included."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    theirs = mi.load_dict({"type": name})
    x = np.linspace(-2.1, 2.1, 997)
    assert theirs.radius() == RADII[name]
    assert np.abs(theirs.eval(mi.Float(x)).numpy() - [FUNCTIONS[name](v) for v in x]).max() < TOLERANCE[name]


def test_mitchell_changes_its_sign_where_the_code_says():
    """At 8 / 7, and nowhere else before its end."""
    root = filters.MITCHELL_ROOT
    assert filters.mitchell(root) == pytest.approx(0, abs=1e-12)
    assert filters.mitchell(root - 1e-3) > 0
    assert all(filters.mitchell(x) < 0 for x in np.linspace(root + 1e-3, 1.99, 50))


@every_filter
def test_offsets_are_distributed_like_the_filter(name):
    """Counts in cells against integrals of |f|; signs are those of f; x and y alike."""
    side, function = 2**10, FUNCTIONS[name]
    u = (np.stack(np.meshgrid(np.arange(side), np.arange(side))).reshape(2, -1) + 0.5) / side
    offset = FILTERS[name]().offset(Vector2f(u.astype(np.float32)))
    x, y = offset.position.numpy() - 0.5
    cells = np.linspace(-2, 2, 33)
    fine = np.abs([[function(v) for v in np.linspace(a, b, 65)[:-1] + (b - a) / 128] for a, b in zip(cells, cells[1:])])
    expected = fine.mean(1) / fine.mean(1).sum()
    found = np.histogram2d(x, y, bins=[cells, cells])[0] / side**2
    assert np.abs(found - np.outer(expected, expected)).max() < 0.02 * expected.max() ** 2
    sign = np.sign([function(v) for v in x[:: side + 7]]) * np.sign([function(v) for v in y[:: side + 7]])
    if name == "mitchell":
        near = np.minimum.reduce([abs(abs(v[:: side + 7]) - filters.MITCHELL_ROOT) for v in (x, y)]) < 1e-4
        assert np.array_equal(offset.negative.numpy()[:: side + 7][~near], (sign < 0)[~near])
    else:
        assert offset.negative is None and sign.min() >= 0


@every_filter
def test_offsets_follow_their_numbers(name):
    """Monotonic, so that evenly spread numbers give evenly spread samples; ends of the interval stay in the support."""
    u = np.concatenate([[0.0, 2.0**-24], np.linspace(0.001, 0.999, 5000), [1 - 2.0**-24]]).astype(np.float32)
    x = FILTERS[name]().offset(Vector2f(u, np.full(len(u), 0.5, np.float32))).position.x.numpy() - 0.5
    assert np.diff(x).min() >= 0 and abs(x[0] + RADII[name]) < 2e-3 and x[-1] <= RADII[name]
    assert np.isfinite(x).all()


@every_filter
def test_tails_hold_what_the_filter_holds(name):
    """Of 10^7 evenly spread samples as many lie in the last parts of the radius as the filter's integral has there."""
    radius, count = RADII[name], 10_000_000
    u = (np.arange(count, dtype=np.float64) + 0.5) / count
    x = FILTERS[name]().offset(Vector2f(u.astype(np.float32), np.full(count, 0.5, np.float32))).position.x.numpy() - 0.5
    places = np.linspace(-radius, radius, 200_001)[:-1] + radius / 200_000
    weight = np.abs([FUNCTIONS[name](v) for v in places])
    for share in (0.95, 0.9, 0.8, 0.7):
        exact = weight[places > share * radius].sum() / weight.sum()
        assert np.isclose((x > share * radius).mean(), exact, rtol=0.02, atol=3e-7), share


def edge_profile(name, places):
    """Return the integral of the filter, normalised, up to each place."""
    x = np.linspace(-2, 2, 40_001)[:-1] + 5e-5
    density = np.array([FUNCTIONS[name](v) for v in x])
    return np.interp(places, x + 5e-5, np.cumsum(density) / density.sum())


@every_filter
def test_edge_is_convolved_with_the_filter(tmp_path, name):
    """A vertical edge in the middle of a pixel, in many rows: columns are the filter's integral up to the edge."""
    # at distance 4 and fov 40, a column is 8 tan(20 deg) / 12 wide; the edge lies 0.25 columns off the picture's middle
    column = 8 * math.tan(math.radians(20)) / 12
    wall = {"type": "rectangle", "center": [9 + 0.25 * column, 0, 0], "u": [18, 0, 0], "v": [0, 18, 0]}
    scene = loaded(tmp_path, [wall], rendermode="binary", filter=name, samples=4096, camera={"width": 12, "height": 12})
    picture = render(scene).channels()["R"]
    # x runs to the right; the edge is at column 6.25
    expected = edge_profile(name, np.arange(12) + 0.5 - 6.25)
    assert np.abs(picture - expected).max() < 0.01
    assert np.abs(picture.mean(0) - expected).max() < 0.003
    if name == "mitchell":
        assert picture.mean(0).min() < -0.001 and picture.mean(0).max() > 1.01


@pytest.mark.parametrize("samples", [1, 2, 3, 4, 16])
def test_signed_filter_keeps_what_is_even(tmp_path, samples):
    """Of a wall all over the picture, from 8 samples on, negative weights neither brighten nor speckle any."""
    wall = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}
    size = {"width": 64, "height": 64}
    scene = loaded(tmp_path, [wall], rendermode="binary", filter="mitchell", samples=samples, camera=size)
    picture = render(scene).channels()["R"]
    assert np.abs(picture - 1).max() < (1e-6 if samples in (1, 16) else 2.01)
    assert np.median(np.abs(picture - 1)) < 1e-6


def test_filters_differ_and_box_is_what_was(tmp_path):
    """The scene's filter reaches the picture; one sample of a phong picture goes through the middle for each filter."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    scenes = [loaded(tmp_path, [ball], filter=name, samples=4) for name in FILTERS]
    pictures = [render(scene).channels()["R"] for scene in scenes]
    assert all(not np.array_equal(a, b) for k, a in enumerate(pictures) for b in pictures[:k])
    single = [render(override(scene, samples=1)).channels()["R"] for scene in scenes]
    assert all(np.array_equal(single[0], other) for other in single[1:])


@pytest.mark.parametrize("name", ["gaussian", "mitchell"])
def test_filtered_picture_does_not_depend_on_threads(tmp_path, name):
    """No atomic sums."""
    scene = loaded(tmp_path, [{"type": "sphere", "center": [0, 0, 0], "radius": 1}], filter=name, samples=8)
    before, pictures = dr.thread_count(), []
    try:
        for threads in (1, 3):
            dr.set_thread_count(threads)
            pictures.append(render(scene).channels()["R"])
    finally:
        dr.set_thread_count(before)
    assert np.array_equal(*pictures)
