"""Maps from the unit square.

Random numbers are multiples of 2^-24 from 0 to 1 - 2^-24. At these ends, and at the seams between, maps fall out of
their domain, onto the horizon where the density is 0, or into 0 / 0. Narrow cones lose their width to rounding.
Inputs: all pairs of 60 numbers around 0, 1/4, 1/2, 3/4 and 1, and 100,000 others.
"""

import numpy as np

from renderer.core import warp
from renderer.core.backend import Float, Vector2f
from tests.stability.case import ULP, Case, mitsuba, relative

STEP = 2.0**-24
MIDDLE = 0.5 * STEP  # the renderer's maps of the disk and hemisphere take a number for the middle of its step

LEAST_COSINE = 1e-4  # errors of smaller ones are relative to this


def numbers():
    """Return pairs of random numbers, (2, N) float32."""
    ends = np.concatenate([[0], 0.25 * np.arange(1, 4) * 2**24, [2**24]])[:, None] + np.arange(-10, 11)
    ends = np.unique(ends[(ends >= 0) & (ends < 2**24)])
    others = np.random.default_rng(1).integers(0, 2**24, (2, 100_000))
    pairs = np.stack(np.meshgrid(ends, ends)).reshape(2, -1)
    return (np.concatenate([pairs, others], axis=1) * STEP).astype(np.float32)


def concentric(u):
    """Return points of the disk [Shirley1997] and their signed distances from the middle, in the precision of u."""
    x, y = 2 * u - 1
    wide = abs(x) > abs(y)
    r = np.where(wide, x, y)
    with np.errstate(all="ignore"):
        phi = np.where(wide, np.pi / 4 * (y / x), np.pi / 2 - np.pi / 4 * (x / y)).astype(u.dtype)
    return r * np.stack([np.cos(phi), np.sin(phi)]), r


def exact_disk(u):
    """Return the same of float64 numbers, 0 in the middle."""
    p, r = concentric(u)
    return np.where(r == 0, 0, p), r


def disk(mapping, shift=0.0):
    """Return a callable: how far the points of a function are from the exact ones."""

    def measure():
        u = numbers()
        return np.linalg.norm(np.asarray(mapping(u), float) - exact_disk(u.astype(float) + shift)[0], axis=0)

    return measure


def horizon(mapping, shift=0.0):
    """Return a callable: relative errors of the cosines of a function's directions."""

    def measure():
        u = numbers()
        _, r = exact_disk(u.astype(float) + shift)
        return relative(mapping(u)[2], np.sqrt((1 - r) * (1 + r)), LEAST_COSINE)

    return measure


def outside(mapping):
    """Return a callable: which directions of a function are not of length 1, not above the horizon, or of density 0."""

    def measure():
        w = np.asarray(mapping(numbers()), float)
        pdf_sa = warp.cosine_hemisphere_pdf_sa(warp.Vector3f(*map(Float, w.astype(np.float32)))).numpy()
        with np.errstate(invalid="ignore"):
            good = (abs(np.linalg.norm(w, axis=0) - 1) < 4 * ULP) & (w[2] > 0) & (pdf_sa > 0)
        return ~good

    return measure


def naive_hemisphere(u):
    """Return the textbook's directions: a point of the disk, lifted."""
    x, y = concentric(u)[0]
    with np.errstate(invalid="ignore"):
        return np.stack([x, y, np.sqrt(1 - x * x - y * y)])


def ours(mapping):
    """Return a map of the renderer as a function of numpy arrays."""
    return lambda u: mapping(Vector2f(u)).numpy()


def mitsubas(name):
    """Return a map of Mitsuba as a function of numpy arrays."""

    def mapping(u):
        mi = mitsuba()
        return getattr(mi.warp, name)(mi.Point2f(u)).numpy()

    return mapping


def beyond(mapping):
    """Return a callable: which points of a function lie out of the triangle, by barycentric coordinates in float32."""

    def measure():
        b1, b2 = np.asarray(mapping(numbers()), np.float32)
        return (b1 < 0) | (b2 < 0) | (np.float32(1) - b1 - b2 < 0)

    return measure


def root_triangle(u):
    """Return the textbook's barycentric coordinates, from a square root."""
    root = np.sqrt(u[0])
    return np.stack([1 - root, u[1] * root])


def cones():
    """Return pairs of random numbers for cones, and 1 - cosine of their half angles from 1e-12 to 2, float32."""
    u = numbers()
    rng = np.random.default_rng(2)
    return u, np.minimum(10.0 ** rng.uniform(-12, 0.35, u.shape[1]), 2).astype(np.float32)


def cone_angles(mapping, share=lambda u: u[0]):
    """Return a callable: errors of the angles to the axis of a function's directions, relative to the exact ones.

    `share` tells which part of the cone's height a pair of numbers stands for.
    """

    def measure():
        u, one_minus_cos = cones()
        x, y, z = np.asarray(mapping(u, one_minus_cos), float)
        sine = np.sqrt(0.5 * share(u.astype(float)) * one_minus_cos)  # of half the angle
        return relative(np.arctan2(np.hypot(x, y), z), 2 * np.arcsin(sine), STEP**2)

    return measure


def cone_densities(pdf_sa):
    """Return a callable: relative errors of a function's densities."""

    def measure():
        one_minus_cos = cones()[1]
        with np.errstate(divide="ignore"):
            return relative(pdf_sa(one_minus_cos), 1 / (2 * np.pi * one_minus_cos.astype(float)))

    return measure


def naive_cone(u, one_minus_cos):
    """Return the textbook's directions, from the cosine of the half angle."""
    cos = 1 - u[0] * one_minus_cos
    sin, phi = np.sqrt(1 - cos * cos), np.float32(2 * np.pi) * u[1]
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), cos])


def mitsubas_cone(u, one_minus_cos):
    """Return Mitsuba's directions."""
    mi = mitsuba()
    return mi.warp.square_to_uniform_cone(mi.Point2f(u), mi.Float(1 - one_minus_cos)).numpy()


def mitsubas_cone_pdf_sa(one_minus_cos):
    """Return Mitsuba's densities."""
    mi = mitsuba()
    return mi.warp.square_to_uniform_cone_pdf(mi.Vector3f(0, 0, 1), mi.Float(1 - one_minus_cos)).numpy()


CASES = (
    Case("points of the disk", "1", 4 * ULP,
         "cosine and sine are good to 1e-7 and, with the quotient and the product, round twice more",
         disk(ours(warp.square_to_disk), MIDDLE), disk(lambda u: concentric(u)[0]),
         "Shirley and Chiu's, which divides by 0 in the middle", disk(mitsubas("square_to_uniform_disk_concentric"))),
    Case("cosines of cosine-weighted directions", "relative", 1.5 * ULP,
         "1 - r^2 is rounded once, which the root halves, and the root once",
         horizon(ours(warp.square_to_cosine_hemisphere), MIDDLE), horizon(naive_hemisphere),
         "sqrt(1 - x^2 - y^2)", horizon(mitsubas("square_to_cosine_hemisphere"))),
    Case("directions not unit, not above the horizon or of density 0", "share", 0, "none is",
         outside(ours(warp.square_to_cosine_hemisphere)), outside(naive_hemisphere), "sqrt(1 - x^2 - y^2)",
         outside(mitsubas("square_to_cosine_hemisphere"))),
    Case("points beyond the edges of the triangle", "share", 0, "none is",
         beyond(ours(warp.square_to_triangle)), beyond(root_triangle), "(1 - sqrt(u), v sqrt(u))",
         beyond(mitsubas("square_to_uniform_triangle"))),
    Case("angles in narrow cones", "relative", 8.5 * ULP,
         "1 - cosine and the sine of it round 3.5 times in all, and those of the azimuth are good to 3e-7",
         cone_angles(lambda u, size: warp.square_to_cone(Vector2f(u), Float(size)).numpy()), cone_angles(naive_cone),
         "sqrt(1 - cosine^2)", cone_angles(mitsubas_cone, lambda u: exact_disk(u)[1] ** 2),
         "is told the cosine, which has lost narrow cones"),
    Case("densities in narrow cones", "relative", 3 * ULP, "2 pi, product and reciprocal round once each",
         cone_densities(lambda size: warp.cone_pdf_sa(Float(size)).numpy()),
         cone_densities(lambda size: 1 / (np.float32(2 * np.pi) * (1 - (1 - size)))), "1 / (2 pi (1 - cosine))",
         cone_densities(mitsubas_cone_pdf_sa), "is told the cosine, which has lost narrow cones"),
)  # fmt: skip
