"""Shining spheres of path-traced scenes: directions spread evenly over the cone in which a point sees one.

Light goes outwards: from inside, or on its surface, a sphere is dark. 1 - cosine of the cone's half angle is computed
from sin^2 = r^2 / d^2 as sin^2 / (1 + cos), because the difference vanishes for far spheres [Pharr2023, sec. 6.2.4].
"""

import math

import drjit as dr

from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.frame import Frame
from renderer.core.numeric import EPSILON, greater, lesser, safe_sqrt
from renderer.core.warp import cone_pdf_sa, square_to_cone
from renderer.lights.base import LEAST_COSINE, DirectSample, short_of

CENTER, RADIUS, RADIANCE = 0, 3, 4
WIDTH = 7
SKIN = 1 + 32 * EPSILON  # of d^2 / r^2: points so near to the surface lie on it


def pack(shape, twosided):
    """Return the record of a shining sphere."""
    return [*shape.center, shape.radius, *shape.emission]


def features(records):
    """Return nothing: spheres differ in values only."""
    return None


def estimate(shape, twosided, luminance):
    """Return the values of the light's Estimate: pi times radiance on the surface."""
    square = shape.radius**2
    return {"center": shape.center, "strength": math.pi * square * luminance, "least": square}


def cone(distance_squared, radius):
    """Return 1 - cosine of the half angle in which a sphere is seen, and whether the point lies outside of it."""
    outside = distance_squared > dr.square(radius) * SKIN
    sin_squared = lesser(dr.square(radius) / distance_squared, Float(1))
    return sin_squared / (1 + safe_sqrt(1 - sin_squared)), outside


def pdf_sa(o, p, n, radius):
    """Return the density with which `sample` for the point o chooses the direction of p on a sphere, n its normal."""
    one_minus_cos, outside = cone(dr.squared_norm(p - n * radius - o), radius)
    return dr.select(outside, cone_pdf_sa(one_minus_cos), 0)


def sample(row, p, u, u2, has):
    """Return a direction within the lane's sphere as a DirectSample."""
    to_center, radius = row.vector(CENTER) - p, row[RADIUS]
    squared = dr.squared_norm(to_center)
    one_minus_cos, outside = cone(squared, radius)
    distance = dr.sqrt(squared)
    local = square_to_cone(u2, one_minus_cos)
    wo = Frame.of(to_center * dr.rcp(greater(distance, radius))).to_world(local)
    # half the chord: r^2 minus the squared distance of the line from the centre
    sin_squared = dr.fma(local.x, local.x, local.y * local.y)
    half = safe_sqrt(dr.square(radius) - squared * sin_squared)
    cosine = greater(half / radius, Float(LEAST_COSINE))
    seen = distance * local.z - half
    return DirectSample(
        wo,
        lesser(short_of(seen, p, cosine), seen),
        dr.select(outside, row.vector(RADIANCE), Vector3f(0)),
        dr.select(outside, cone_pdf_sa(one_minus_cos), 1 / (2 * math.pi)),
        Bool(False),
    )
