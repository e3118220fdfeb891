"""What is right or wrong at the ends of ranges, and no error of a number."""

import dataclasses

import numpy as np
import pytest

from renderer.core import warp
from renderer.core.backend import Float, Vector2f
from renderer.engine.filters import FILTERS, RADIUS
from tests.stability.cameras import HEIGHT, NARROW, WIDTH, ours
from tests.stability.maps import STEP, numbers


@pytest.mark.parametrize("along", range(2))
def test_neighbouring_pixels_of_a_narrow_view_differ(along):
    """8000 x 6000 pixels through 0.1 degrees: no two have one direction, and steps have the right sign."""
    start = np.stack(np.meshgrid(np.arange(0, WIDTH, 97), np.arange(0, HEIGHT, 89))).reshape(2, -1) + 0.5
    step = np.eye(2)[along][:, None]
    for camera in NARROW:
        camera = dataclasses.replace(camera, width=WIDTH, height=HEIGHT)
        here, there, far = (ours(camera, (start + k * step).astype(np.float32)).astype(float) for k in (0, 1, 100))
        assert (((there - here) * (far - here)).sum(axis=0) > 0).all()


def test_disk_never_reaches_its_rim():
    """Nor its middle more than once: every pair of numbers stands for the middle of its cell."""
    p = np.asarray(warp.square_to_disk(Vector2f(numbers())).numpy(), float)
    assert np.linalg.norm(p, axis=0).max() < 1 + 2 * STEP and np.abs(p).max() < 1
    x, y = warp.square_to_disk(Vector2f([0.5, 0.5 - STEP], [0.5, 0.5 - STEP])).numpy()
    assert x[0] == -x[1] and y[0] == -y[1] and x[0] > 0


@pytest.mark.parametrize("size", [2.0**-126, 1e-30, 1e-12, 1.0, 2.0])
def test_cones_have_a_density(size):
    """Finite and positive, and their directions have length 1 and lie above the cone's rim."""
    w = np.asarray(warp.square_to_cone(Vector2f(numbers()), Float(size)).numpy(), float)
    assert np.abs(np.linalg.norm(w, axis=0) - 1).max() < 6e-7 and (w[2] >= 1 - size - 2 * STEP).all()
    assert 0 < warp.cone_pdf_sa(Float(size)).numpy()[0] < np.inf


@pytest.mark.parametrize("name, radius", [("box", 0.5), ("tent", 1.0), ("gaussian", RADIUS), ("mitchell", RADIUS)])
def test_samples_stay_under_their_filter(name, radius):
    """Also those of the least and greatest numbers, and they are spread to both sides alike."""
    offset = FILTERS[name]().offset(Vector2f(numbers())).position.numpy() - np.float32(0.5)
    assert np.isfinite(offset).all() and np.abs(offset).max() <= radius
    assert offset.min() < -0.9 * radius and offset.max() > 0.9 * radius
