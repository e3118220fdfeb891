"""Reflection and refraction at a smooth interface."""

import math

import drjit as dr

from renderer.core.backend import Float
from renderer.core.numeric import TINY, away_from_zero, lesser, safe_sqrt

NEARLY_1, MOST_INDEX = 1e-4, 1e4  # differences from 1, and indices, within which the closed form keeps six digits


def reflect(d, n, cos_i):
    """Return the mirror direction of d at the normal n that faces it; cos_i = -d.n."""
    return dr.normalize(dr.fma(n, 2 * cos_i, d))


def dielectric(cos_i, eta):
    """Return (F, cos_t): unpolarised Fresnel reflectance, 1 at total reflection, and the cosine of the refracted ray.

    `eta` is the index behind the surface over the one in front of it, cos_i >= 0 lies in front. All is told by
    g = eta cos_t = sqrt(cos_i^2 + e), e = eta^2 - 1. Near the critical angle that sum cancels, and near eta = 1 so does
    e: squares therefore carry what their rounding cuts off [Jeannerod2013]. The numerators cos_i - g and
    eta^2 cos_i - g are taken times their conjugates, -e and e (eta^2 cos_i^2 - sin_i^2), which need no difference of g.
    F is within 1e-6 of itself, total reflection is decided as by exact arithmetic. Source: [Born1999, sec. 1.5.2].
    """
    eta2, cos2 = dr.square(eta), dr.square(cos_i)
    high = eta2 - 1
    low = dr.fma(eta, eta, -eta2) + (eta2 - (high + 1))
    cos2_low = dr.fma(cos_i, cos_i, -cos2)
    e, g2 = high + low, (cos2 + high) + (cos2_low + low)
    g = safe_sqrt(g2)
    over_s, over_p = dr.rcp(away_from_zero(cos_i + g)), dr.rcp(away_from_zero(dr.fma(eta2, cos_i, g)))
    r_s = e * over_s * over_s
    r_p = e * over_p * (dr.fma(eta2, cos2, (cos2 - 1) + cos2_low) * over_p)
    # at total reflection g = 0, and both squares are above 1
    return lesser(0.5 * (dr.square(r_s) + dr.square(r_p)), Float(1)), g / eta


def refract(d, n, cos_i, cos_t, eta):
    """Return the direction behind the surface, by Snell's law; arguments as above."""
    inverse = dr.rcp(eta)
    return dr.normalize(d * inverse + n * (cos_i * inverse - cos_t))


def conductor_terms(eta, k):
    """Return eta^2 - k^2 and 2 eta k, all that the reflectance of a metal of index eta + i k depends on; host."""
    return (eta - k) * (eta + k), 2 * eta * k


def conductor(cos_i, difference, product):
    """Return the unpolarised Fresnel reflectance of a metal, of colour vectors of `conductor_terms`.

    With q = |n^2 - sin^2|, a = Re sqrt(n^2 - sin^2), c = cos_i, s = sin_i:
    r_s = (q + c^2 - 2 a c) / (q + c^2 + 2 a c), r_p = r_s (q c^2 + s^4 - 2 a c s^2) / (q c^2 + s^4 + 2 a c s^2),
    and (r_s + r_p) / 2 needs one division. What a metal absorbs is in proportion to a, which is small beside q: so it
    is not taken from a difference, but from 2 a Im = product. Source: [Born1999, sec. 14.4.2].
    """
    cos2 = dr.square(cos_i)
    sin2 = 1 - cos2
    real = difference - sin2
    q = dr.sqrt(dr.square(real) + dr.square(product))
    larger2 = 0.5 * (q + abs(real))  # the square of the larger of a and the imaginary part
    inverse = dr.rsqrt(larger2 + TINY)
    twice_ac = cos_i * inverse * dr.select(real > 0, 2 * larger2, product)
    even_s, even_p = q + cos2, q * cos2 + (dr.square(sin2) + TINY)
    return (even_s - twice_ac) * even_p / ((even_s + twice_ac) * (even_p + twice_ac * sin2))


def diffuse_reflectance(eta):
    """Return the reflectance of an interface for light from all directions in front; host.

    The integral of F(cos) 2 cos in closed form [Judd1942]; what comes from the denser side follows from energy.
    """
    n = min(max(eta, 1 / eta), MOST_INDEX)
    if n - 1 < NEARLY_1:  # the closed form is a difference of large numbers there
        outer = (n - 1) / 3
    else:
        n2, n4 = n * n, n**4
        outer = 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) ** 2) - 2 * n**3 * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1))
        outer += n2 * (n2 - 1) ** 2 / (n2 + 1) ** 3 * math.log((n - 1) / (n + 1))
        outer += 8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) ** 2) * math.log(n)
    return outer if eta >= 1 else 1 - (1 - outer) / n**2
