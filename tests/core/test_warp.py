"""Maps of the unit square: chi-square of their samples against their densities, and what they reach at the corners."""

import math

import drjit as dr
import numpy as np
import pytest

from renderer.core import warp
from renderer.core.backend import Float, Vector2f

CELLS = 20  # along each side of histograms
COUNT = 1_000_000
SIGNIFICANCE = 1e-3


def numbers(count=COUNT, seed=31):
    """Return pairs of random numbers."""
    return Vector2f(np.random.default_rng(seed).random((2, count), np.float32))


def p_value(a, b):
    """Return the p-value of points in [0, 1]^2 being uniform."""
    from scipy import stats

    counts, *_ = np.histogram2d(a, b, CELLS, ((0, 1), (0, 1)))
    assert counts.sum() == len(a), "points outside"
    return stats.chisquare(counts.ravel()).pvalue


def turns(x, y):
    """Return the azimuth in turns, 0 to 1."""
    return np.arctan2(y, x) / (2 * math.pi) % 1


def hemisphere(w):
    """Return what is uniform for cosine-weighted directions: squared sine and azimuth."""
    return np.clip(w[0] ** 2 + w[1] ** 2, 0, 1), turns(w[0], w[1])


def disk(p):
    """Return what is uniform for points of the disk."""
    return np.clip(p[0] ** 2 + p[1] ** 2, 0, 1), turns(p[0], p[1])


def triangle(b):
    """Return what is uniform for points of the triangle: squared distance from b1 + b2 = 0, and the place across."""
    s = (b[0] + b[1]).astype(float)
    return np.clip(s**2, 0, 1), np.clip(b[0] / np.maximum(s, 1e-30), 0, 1)


@pytest.mark.parametrize("mapping, uniform", [
    (warp.square_to_disk, disk), (warp.square_to_cosine_hemisphere, hemisphere), (warp.square_to_triangle, triangle),
])
def test_points_have_their_density(mapping, uniform):
    """Points have the density that the map promises."""
    assert p_value(*uniform(np.asarray(mapping(numbers()).numpy(), float))) > SIGNIFICANCE


@pytest.mark.parametrize("one_minus_cos", [1e-6, 1e-3, 0.5, 2.0])
def test_cone_is_uniform(one_minus_cos):
    """Directions in a cone are uniform: the cosine and the azimuth are, and the density is 1 over the solid angle."""
    w = np.asarray(warp.square_to_cone(numbers(), Float(one_minus_cos)).numpy(), float)
    sin2 = w[0] ** 2 + w[1] ** 2
    height = sin2 / (1 + w[2])  # 1 - cosine without the rounding of 1 - w.z; below the horizon that is harmless
    height = np.where(w[2] < 0, 1 - w[2], height)
    assert p_value(np.clip(height / one_minus_cos, 0, 1), turns(w[0], w[1])) > SIGNIFICANCE
    np.testing.assert_allclose(np.linalg.norm(w, axis=0), 1, atol=1e-6)
    pdf_sa = warp.cone_pdf_sa(Float(one_minus_cos)).numpy()[0]
    assert pdf_sa == pytest.approx(1 / (2 * math.pi * one_minus_cos), rel=1e-5)


def test_wrong_density_is_rejected():
    """The test tells a uniform hemisphere from a cosine-weighted one, and a slight shift."""
    u = np.asarray(numbers().numpy(), float)
    assert p_value(u[0], u[1]) > SIGNIFICANCE
    assert p_value(u[0] ** 1.02, u[1]) < SIGNIFICANCE
    assert p_value(1 - u[0] ** 2, u[1]) < SIGNIFICANCE


EDGES = [0.0, 2.0**-32, 0.25, 0.5, 0.75, 1 - 2.0**-24]


def corners():
    """Return pairs of least, middle and greatest numbers."""
    a, b = np.meshgrid(np.array(EDGES, np.float32), np.array(EDGES, np.float32))
    return Vector2f(a.ravel(), b.ravel())


def test_corners_of_the_square_stay_inside():
    """The least and greatest numbers give finite points inside, and directions that are unit and not below."""
    p = np.asarray(warp.square_to_disk(corners()).numpy(), float)
    assert (np.linalg.norm(p, axis=0) <= 1 + 1e-6).all()
    w = np.asarray(warp.square_to_cosine_hemisphere(corners()).numpy(), float)
    assert (w[2] >= 0).all()
    np.testing.assert_allclose(np.linalg.norm(w, axis=0), 1, atol=1e-6)
    b = np.asarray(warp.square_to_triangle(corners()).numpy(), float)
    assert (b >= 0).all() and (b.sum(0) <= 1 + 1e-7).all()


def test_density_of_the_hemisphere_integrates_to_one():
    """The mean of the density over cosines is 1 / (2 pi), and it is 0 below."""
    z = dr.linspace(Float, -1, 1, 20001)
    pdf_sa = warp.cosine_hemisphere_pdf_sa(warp.Vector3f(0, 0, z)).numpy()
    assert pdf_sa[z.numpy() > 0].mean() == pytest.approx(1 / (2 * math.pi), rel=1e-3)
    assert not pdf_sa[z.numpy() < 0].any()
