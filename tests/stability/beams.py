"""Narrow cones of light.

A sphere is seen in a cone whose 1 - cosine vanishes from afar, and whose cosine does from close by. A spot's light
falls off with an angle that an arc cosine cannot tell where it is small. Spheres are seen from 1e-6 radii above their
surface to 1e6 radii away, spots have beams of 0.01 to 10 degrees, and what they shine on is up to 1e6 units away.
"""

import math

import drjit as dr
import numpy as np

from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.rows import Rows
from renderer.lights import sphere, spot
from renderer.scene.schema import Sphere, SpotLight
from tests.stability.case import ULP, Case, mitsuba, relative

COUNT = 50_000
BEAMS = [0.01, 0.1, 1.0, 10.0]  # degrees
BALL = Sphere(type="sphere", center=(0.75, -0.5, 1.25), radius=0.5, emission=(1.0, 1.0, 1.0))


def unit_vectors(rng, count=COUNT):
    """Return even unit vectors (3, count)."""
    w = rng.normal(size=(3, count))
    return w / np.linalg.norm(w, axis=0)


def around_ball(skin):
    """Return points (3, N) float32 outside of the sphere, and the exact squared sines of the cones that they see it in.

    Squared distances are greater by `skin` than the squared radius, at the least.
    """
    rng = np.random.default_rng(1)
    height = BALL.radius * 10.0 ** rng.uniform(-6, 6, COUNT)
    center = np.array(BALL.center)[:, None]
    p = (center + unit_vectors(rng) * (BALL.radius + height)).astype(np.float32)
    squared = ((p - center) ** 2).sum(axis=0)
    above = squared > BALL.radius**2 * (1 + skin)
    return p[:, above], BALL.radius**2 / squared[above]


def cones(pdf_sa, skin=2e-6):
    """Return a callable: errors of a function's densities, relative, times the cosines of the cones' half angles."""

    def measure():
        p, sin_squared = around_ball(skin)
        cosine = np.sqrt(1 - sin_squared)
        with np.errstate(divide="ignore", invalid="ignore"):
            return relative(pdf_sa(p), (1 + cosine) / (2 * np.pi * sin_squared)) * cosine

    return measure


def ours_pdf_sa(p):
    """Return the renderer's densities."""
    row = Rows([sphere.pack(BALL, False)])[0]
    lanes = p.shape[1]
    return sphere.sample(row, Vector3f(*p), None, dr.zeros(Vector2f, lanes), None).pdf_sa.numpy()


def ours_met_pdf_sa(p):
    """Return the renderer's densities for the nearest points of the sphere, met along rays."""
    n = p - np.array(BALL.center)[:, None]
    n /= np.linalg.norm(n, axis=0)
    met = np.array(BALL.center)[:, None] + BALL.radius * n
    met, n = (Vector3f(*v.astype(np.float32)) for v in (met, n))
    return sphere.pdf_sa(Vector3f(*p), met, n, dr.opaque(Float, BALL.radius)).numpy()


def naive_pdf_sa(p):
    """Return the textbook's densities."""
    center, radius = np.array(BALL.center, np.float32)[:, None], np.float32(BALL.radius)
    cosine = np.sqrt(1 - radius * radius / ((p - center) ** 2).sum(axis=0))
    return 1 / (np.float32(2 * np.pi) * (1 - cosine))


def mitsubas_pdf_sa(p):
    """Return Mitsuba's densities."""
    mi = mitsuba()
    scene = mi.load_dict({"type": "scene", "ball": {
        "type": "sphere", "center": BALL.center, "radius": BALL.radius,
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}}})  # fmt: skip
    si = dr.zeros(mi.SurfaceInteraction3f, p.shape[1])
    si.p = mi.Point3f(*p)
    ds, _ = scene.sample_emitter_direction(si, mi.Point2f(0.3, 0.6), False)
    return ds.pdf.numpy()


def beam(degrees):
    """Return a spot with a beam of so many degrees."""
    return SpotLight(type="spot", position=(0.0, 0.0, 0.0), direction=(2.0, 1.0, -2.0), intensity=(1.0, 1.0, 1.0),
                     cutoff=degrees)  # fmt: skip


def lit(degrees):
    """Return points (3, N) float32 in and around a spot's beam, and the exact factors of its light there."""
    rng = np.random.default_rng(2)
    cutoff = math.radians(degrees)
    axis = np.array([2, 1, -2]) / 3
    across = np.cross(axis, unit_vectors(rng).T).T
    across /= np.linalg.norm(across, axis=0)
    angle = cutoff * rng.uniform(0, 1.1, COUNT)
    p = 10.0 ** rng.uniform(-6, 6, COUNT) * (np.cos(angle) * axis[:, None] + np.sin(angle) * across)
    p = p.astype(np.float32)
    w = p.astype(float)
    angle = np.arctan2(np.linalg.norm(np.cross(axis, w.T), axis=1), axis @ w)
    return p, np.clip((cutoff - angle) / ((1 - spot.BEAM) * cutoff), 0, 1)


def falling(factor):
    """Return a callable: errors of the factors of a function, times the beams' widths in radians."""
    return lambda: np.concatenate([
        (factor(degrees, lit(degrees)[0]) - lit(degrees)[1]) * math.radians(degrees) for degrees in BEAMS
    ])  # fmt: skip


def ours_factor(degrees, p):
    """Return the renderer's factors."""
    row = Rows([spot.pack(beam(degrees))])[0]
    return spot.sample(row, Vector3f(*p)).radiance.x.numpy()


def naive_factor(degrees, p):
    """Return the textbook's factors."""
    axis, cutoff = np.array([2, 1, -2], np.float32) / np.float32(3), np.float32(math.radians(degrees))
    cosine = (axis[:, None] * p).sum(axis=0) / np.sqrt((p * p).sum(axis=0))
    angle = np.arccos(np.minimum(cosine, 1))
    return np.clip((cutoff - angle) / ((1 - np.float32(spot.BEAM)) * cutoff), 0, 1)


def mitsubas_factor(degrees, p):
    """Return Mitsuba's factors."""
    mi = mitsuba()
    to_world = mi.ScalarTransform4f().look_at(origin=[0, 0, 0], target=[2, 1, -2], up=[0, 1, 0])
    light = mi.load_dict({"type": "spot", "to_world": to_world, "cutoff_angle": degrees,
                          "beam_width": spot.BEAM * degrees, "intensity": {"type": "rgb", "value": 1.0}})  # fmt: skip
    si = dr.zeros(mi.SurfaceInteraction3f, p.shape[1])
    si.p = mi.Point3f(*p)
    ds, weight = light.sample_direction(si, mi.Point2f(0.5))
    return (weight.x * dr.square(ds.dist)).numpy()


FARTHER = 8e-6  # skin of points that must agree on being outside with what rounding leaves of a point of the sphere
ROUNDINGS = "twelve roundings, of differences twice; where the cosine vanishes it divides what they come to"
CASES = (
    Case("density of a sphere's cone", "relative x cosine", 12 * ULP, ROUNDINGS, cones(ours_pdf_sa),
         cones(naive_pdf_sa), "1 / (2 pi (1 - cosine))", cones(mitsubas_pdf_sa),
         "takes 1 - cosine from the cosine, and is infinite from 1e3 radii on"),
    Case("density of a sphere that a ray met", "relative x cosine", 15 * ULP, ROUNDINGS + ", and three of the middle",
         cones(ours_met_pdf_sa, FARTHER), cones(naive_pdf_sa, FARTHER), "1 / (2 pi (1 - cosine))",
         cones(mitsubas_pdf_sa, FARTHER), "the same"),
    Case("edges of spots of 0.01 to 10 degrees", "radians", 14 * ULP,
         "the axis is rounded once and the direction 2.5 times, over a quarter of the beam", falling(ours_factor),
         falling(naive_factor), "arc cosine", falling(mitsubas_factor)),
)  # fmt: skip
