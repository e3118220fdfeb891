"""Bounds hold every hit of their shape, are no larger than they must be, and are rounded outwards for the device."""

import numpy as np
import pytest

from renderer.core.numeric import EPSILON
from renderer.core.records import Ray
from renderer.scene.structures import _bounds
from renderer.scene.tables import compile_scene
from renderer.shapes import KINDS
from tests.shapes.test_contract import vectors
from tests.support.distances import signed_distance
from tests.support.scenes import SHAPES, loaded

BOUNDED = [pytest.param(shape, id=f"{kind}{number}") for kind, settings in SHAPES.items() if kind != "plane"
           for number, shape in enumerate(settings)]  # fmt: skip
TURNED = [
    {"type": "cylinder", "center": [3, -2, 7], "axis": [1, 1, 1], "radius": 2.0, "height": 0.05},
    {"type": "cylinder", "center": [0, 0, 0], "axis": [1e-9, 1, 0], "radius": 1e-3, "height": 5.0},
    {"type": "convex", "vertices": [[0, 0, 0], [1, 2, 3], [-2, 0.5, 1], [0.3, -1, 2], [0.1, 0.2, 1]]},
]
BOUNDED += [pytest.param(shape, id=f"turned{number}") for number, shape in enumerate(TURNED)]
UNBOUNDED = [
    {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]},
    {"type": "convex", "halfspaces": [[0, 1, 0, 1]]},
    {"type": "convex", "halfspaces": [[0, 1, 0, 1], [0, -1, 0, 1], [1, 0, 0, 1], [-1, 0, 0, 1]]},
    {"type": "convex", "halfspaces": [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]]},
]


def described(tmp_path, shape):
    """Return the loaded scene of one shape, and its description."""
    scene = loaded(tmp_path, [shape])
    ((_, description),) = scene.shapes
    return scene, description


def corners(description):
    """Return the corners of a shape's bounds as arrays of doubles."""
    return map(np.array, KINDS[description.type].bounds(description))


def on_device(description):
    """Return the corners of the box that the hierarchy is built over, as doubles."""
    return (np.array(corner, np.float64).ravel() for corner in _bounds(KINDS[description.type], [description]))


def points_inside(shape, lo, hi, rng):
    """Return points of a shape: of random points in a larger box, those inside; a sheet's own corners and means."""
    if shape["type"] == "triangle":
        return rng.dirichlet((1, 1, 1), 1000) @ np.array([shape["v0"], shape["v1"], shape["v2"]])
    if shape["type"] == "rectangle":
        return rng.uniform(-0.5, 0.5, (1000, 2)) @ np.array([shape["u"], shape["v"]]) + shape["center"]
    if shape["type"] == "disk":
        across = np.cross(rng.normal(size=(1000, 3)), shape["normal"])
        return across / np.linalg.norm(across, axis=1, keepdims=True) * shape["radius"] + shape["center"]
    grown = 0.2 * (hi - lo)
    p = rng.uniform(lo - grown, hi + grown, (200_000, 3))
    return p[signed_distance(shape, p) <= 0]


def gaps(shape, lo, hi):
    """Return how far the shape is from each of a box's six sides, over the box's size; negative if it sticks out."""
    middle, half = (lo + hi) / 2, (hi - lo) / 2
    u, v = (part.ravel() for part in np.meshgrid(*[np.linspace(-1, 1, 101)] * 2))
    p = np.empty((len(u), 3))
    for axis in range(3):
        for side in (-1, 1):
            p[:, axis], p[:, axis - 1], p[:, axis - 2] = side, u, v
            yield signed_distance(shape, middle + half * p).min() / half.max()


@pytest.mark.parametrize("shape", BOUNDED)
def test_bounds_hold_all_points(tmp_path, rng, shape):
    """Judged by the formulas of distances; nothing sticks out, and on every side something comes near."""
    _, description = described(tmp_path, shape)
    lo, hi = corners(description)
    p = points_inside(shape, lo, hi, rng)
    size = (hi - lo).max()
    assert len(p) > 500
    assert (p >= lo - 1e-12 * size).all() and (p <= hi + 1e-12 * size).all()


@pytest.mark.parametrize("shape", BOUNDED)
def test_bounds_are_tight(tmp_path, shape):
    """A shape touches all six sides of its box, and crosses none."""
    _, description = described(tmp_path, shape)
    lo, hi = corners(description)
    assert min(gaps(shape, lo, hi)) >= -1e-9 and max(gaps(shape, lo, hi)) < 0.02
@pytest.mark.parametrize("shape", BOUNDED)
def test_hits_lie_within_bounds(tmp_path, rng, shape):
    """What the kernel takes for a hit lies in the box, but for the rounding of the hit itself."""
    scene, description = described(tmp_path, shape)
    compiled = compile_scene(scene, "none")
    lo, hi = corners(description)
    o = (lo + hi) / 2 + 2 * np.linalg.norm(hi - lo) * rng.normal(size=(20_000, 3))
    d = rng.uniform(lo, hi, o.shape) - o
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    ray = Ray(vectors(o), vectors(d))
    hit = compiled.intersect(ray)
    valid = hit.valid.numpy()
    p = compiled.surface(ray, hit, with_uv=False).p.numpy().T[valid].astype(np.float64)
    lo, hi = on_device(description)
    assert valid.sum() > 50
    roundoff = 8 * EPSILON * max(np.abs(lo).max(), np.abs(hi).max())
    assert (p >= lo - roundoff).all() and (p <= hi + roundoff).all()


@pytest.mark.parametrize("shape", BOUNDED)
def test_boxes_on_the_device_are_rounded_outwards(tmp_path, rng, shape):
    """They hold the exact ones, and what float32 makes of the shape's own numbers."""
    _, description = described(tmp_path, shape)
    (lo, hi), (low, high) = corners(description), on_device(description)
    assert (low <= lo).all() and (hi <= high).all()
    assert (low <= np.float32(lo)).all() and (np.float32(hi) <= high).all()
    most = 4 * EPSILON * np.maximum(np.abs(lo), np.abs(hi)).max()
    assert (lo - low).max() <= most and (high - hi).max() <= most


@pytest.mark.parametrize("shift", [0.1, 1 / 3, 1e6 / 7, 1e-6 / 7])
def test_numbers_that_are_no_floats_are_rounded_outwards(tmp_path, shift):
    """Also where rounding to the nearest goes inwards, on both sides of zero."""
    for sign in (1, -1):
        middle = sign * shift * np.array([3, 5, 7])
        box = {"type": "box", "min": (middle - shift).tolist(), "max": (middle + shift).tolist()}
        _, description = described(tmp_path, box)
        (lo, hi), (low, high) = corners(description), on_device(description)
        assert (low <= lo).all() and (hi <= high).all()


@pytest.mark.parametrize("shape", UNBOUNDED)
def test_what_reaches_to_infinity_has_no_bounds(tmp_path, shape):
    """And is tested by every ray: no leaf holds it."""
    scene, description = described(tmp_path, shape)
    kind = KINDS[description.type]
    assert kind.bounds is None or kind.bounds(description) is None
    assert compile_scene(scene, "bvh").structure is None


@pytest.mark.parametrize("shape", [example for example in BOUNDED if KINDS[example.values[0]["type"]].solid])
@pytest.mark.parametrize("side", range(6))
def test_a_wrong_side_is_noticed(tmp_path, shape, side):
    """The yardstick sees a side that is a twentieth too far inside or outside."""
    _, description = described(tmp_path, shape)
    for share in (0.05, -0.05):
        box = [*corners(description)]
        box[side % 2][side // 2] += share * (box[1] - box[0]).max() * (1 - 2 * (side % 2))
        if (box[0] < box[1]).all():
            assert min(gaps(shape, *box)) < -1e-4 or max(gaps(shape, *box)) > 0.02
