"""Maps from the unit square to densities, each next to its density.

Densities are per steradian (`_sa`) or per unit area (`_area`).
"""

import math

import drjit as dr

from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.elementary import sincos_eighth, sincos_turns
from renderer.core.numeric import away_from_zero, greater, safe_sqrt

HALF_A_STEP = 2.0**-24  # of 2 u - 1, where u has 24 bits


def square_to_disk(u2):
    """Return a point of the unit disk, uniform (density 1 / pi): the concentric map [Shirley1997].

    Random numbers stand for the middles of the 2^24 steps between 0 and 1, so that no point lies on the rim.
    """
    return _concentric(u2)[0]


def _concentric(u2):
    """Return a point of the unit disk and its signed distance from the middle."""
    x, y = (dr.fma(u, 2, HALF_A_STEP - 1) for u in u2)
    wide = abs(x) > abs(y)
    r = dr.select(wide, x, y)
    # in the wedges around y the angle is a quarter less this one, which exchanges sine and cosine
    sin_phi, cos_phi = sincos_eighth(dr.select(wide, y, x) / away_from_zero(r))
    a, b = r * cos_phi, r * sin_phi
    return Vector2f(dr.select(wide, a, b), dr.select(wide, b, a)), r


def square_to_cosine_hemisphere(u2):
    """Return a direction around +z with the density cosine / pi [Malley: Pharr2023, sec. A.5.3].

    The cosine comes from the distance r, of which it has no rounding: 1 - x^2 - y^2 would lose it near the horizon. It
    is 3e-4 at the least.
    """
    p, r = _concentric(u2)
    return Vector3f(p.x, p.y, dr.sqrt(dr.fma(-r, r, 1)))


def cosine_hemisphere_pdf_sa(w):
    """Return the density of `square_to_cosine_hemisphere`; 0 below."""
    return greater(w.z, Float(0)) * (1 / math.pi)


def square_to_triangle(u2):
    """Return barycentric coordinates (b1, b2), uniform over a triangle of any shape [Heitz2019]."""
    low = u2.x < u2.y
    b1 = dr.select(low, u2.x * 0.5, u2.x - u2.y * 0.5)
    b2 = dr.select(low, u2.y - u2.x * 0.5, u2.y * 0.5)
    return Vector2f(b1, b2)


def square_to_cone(u2, one_minus_cos):
    """Return a direction within a cone around +z, uniform; `one_minus_cos` is 1 - cosine of its half angle.

    z = 1 - x is built from x = u one_minus_cos, because narrow cones lose 1 - z to rounding.
    """
    x = u2.x * one_minus_cos
    sin = safe_sqrt(x * (2 - x))
    sin_phi, cos_phi = sincos_turns(u2.y)
    return Vector3f(sin * cos_phi, sin * sin_phi, 1 - x)


def cone_pdf_sa(one_minus_cos):
    """Return the density of `square_to_cone` inside the cone."""
    return dr.rcp(2 * math.pi * one_minus_cos)
