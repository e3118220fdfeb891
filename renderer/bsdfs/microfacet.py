"""Microfacet distributions, and what the rough kinds share.

Half vectors may have any length: what is even in them is divided by their squared length once, and nothing is
normalised. `visibility(v)` is Smith's masking G1(v) over v.z, in which form it appears everywhere:
reflection by normals h that v = wi sees has the density D(h) visibility(wi) / 4 per steradian of wo, and the weight
F visibility(wo) wo.z. Masking is separable, G = G1(wi) G1(wo) [Walter2007].
"""

import math

import drjit as dr

from renderer.core.backend import Float, Vector3f
from renderer.core.elementary import exp2, sincos_turns
from renderer.core.numeric import TINY, away_from_zero, greater, lesser

ALPHA_MIN = 1e-4  # below it a surface counts as smooth; narrower lobes are lost in the rounding of half vectors
SMOOTH = -1.0  # the alpha of smooth instances, beside those whose textured alpha may be 0
GGX, BECKMANN, DELTA = "ggx", "beckmann", "smooth"  # features
BECKMANN_CUT = 50.0  # exponents; e^-50 is below what float32 can add
BECKMANN_U_MIN = 1e-6  # keeps the numerical inversion away from slopes of infinity, as Mitsuba does


def pack(bsdf):
    """Return [alpha, whether Beckmann]; host."""
    constant = isinstance(bsdf.alpha, (int, float))
    alpha = (SMOOTH if bsdf.alpha < ALPHA_MIN else bsdf.alpha) if constant else 0.0
    return [alpha, float(bsdf.distribution == BECKMANN)]


def features(bsdf):
    """Return which code an instance needs; host."""
    return (DELTA if pack(bsdf)[0] == SMOOTH else bsdf.distribution,)


def rough(has):
    """Return whether any instance is rough; host."""
    return GGX in has or BECKMANN in has


def smooth_lanes(p, alpha_column, has):
    """Return the lanes of smooth instances: a host boolean where that is all or none."""
    if DELTA not in has or not rough(has):
        return DELTA in has
    return p[alpha_column] < 0


def distribution(p, alpha_column, has):
    """Return the distribution of each lane; its kind stands in the next column where the scene has both."""
    alpha = greater(p[alpha_column], Float(ALPHA_MIN))
    if BECKMANN not in has:
        return Ggx(alpha, alpha)
    if GGX not in has:
        return Beckmann(alpha)
    return Either(p[alpha_column + 1] > 0, Beckmann(alpha), Ggx(alpha, alpha))


def reflect(wi, h):
    """Return the mirror direction of wi at a normal of any length."""
    return dr.fma(h, 2 * dr.dot(wi, h) / away_from_zero(dr.squared_norm(h)), -wi)


class Ggx:
    """The distribution of [Walter2007], of widths ax along x and ay along y; one object twice where they are equal."""

    def __init__(self, ax, ay):
        self._ax, self._ay = ax, ay

    def _length(self, v):
        """Return the length of a unit vector after it is stretched by the widths."""
        if self._ax is self._ay:
            return dr.sqrt(dr.square(self._ax) * (dr.square(v.x) + dr.square(v.y)) + dr.square(v.z))
        return dr.sqrt(dr.square(self._ax * v.x) + dr.square(self._ay * v.y) + dr.square(v.z))

    def density(self, h):
        """Return D, per steradian of normals and per unit cosine; the constant is 1 / pi."""
        ax, ay = self._ax, self._ay
        if ax is ay:
            width, q = ax, dr.square(h.x) + dr.square(h.y) + dr.square(ax * h.z)
            return dr.square(dr.squared_norm(h) * width / away_from_zero(q)) * (1 / math.pi)
        q = dr.square(h.x) * ay / ax + dr.square(h.y) * ax / ay + ax * ay * dr.square(h.z)
        return dr.square(dr.squared_norm(h) / away_from_zero(q)) * (ax * ay / math.pi)

    def visibility(self, v):
        """Return G1 / v.z = 2 / (v.z + stretched length)."""
        return 2 / (v.z + self._length(v))

    def sample(self, wi, u2):
        """Return a normal that wi sees, by spherical caps [Dupuy2023]; D visibility(wi) (wi.h) is its density.

        The square of the cap's sine has no difference but the exact 1 - u, so that the tail of normals far from z
        keeps its length: 1 - z^2 is x^2 + y^2.
        """
        scale = dr.rcp(self._length(wi))
        x, y, z = self._ax * wi.x * scale, self._ay * wi.y * scale, abs(wi.z) * scale
        height = (1 - u2.y) * (1 + z)  # of the cap's point over -z
        sin = dr.sqrt(u2.y * dr.fma(1 + z, height, dr.square(x) + dr.square(y)))
        sin_phi, cos_phi = sincos_turns(u2.x)
        return Vector3f(self._ax * dr.fma(sin, cos_phi, x), self._ay * dr.fma(sin, sin_phi, y), height)


class Beckmann:
    """The distribution of Gaussian slopes, with the rational fit of its masking [Walter2007, sec. 5.2]."""

    def __init__(self, alpha):
        self._alpha = alpha

    def density(self, h):
        """Return D = exp(-tan^2 / alpha^2) / (pi alpha^2 cos^4)."""
        tan2 = (dr.square(h.x) + dr.square(h.y)) / dr.square(h.z)
        inverse = dr.rcp(dr.square(self._alpha))
        exponent = tan2 * inverse
        result = exp2(exponent * -math.log2(math.e)) * dr.square(1 + tan2) * (inverse / math.pi)
        return dr.select(exponent < BECKMANN_CUT, result, 0)  # also 0 for the infinity or NaN of h.z = 0

    def visibility(self, v):
        """Return G1 / v.z; the fit is 3e-3 off the exact G1 [Heitz2014], and sampling is as exact as the fit."""
        slope2 = dr.square(self._alpha) * (dr.square(v.x) + dr.square(v.y))
        a = v.z * dr.rsqrt(slope2 + TINY)
        fit = a * (3.535 + 2.181 * a) / (1 + a * (2.276 + 2.577 * a))
        return dr.select(a < 1.6, fit, 1) / v.z

    def sample(self, wi, u2):
        """Return a normal that wi sees: the slopes' distribution is inverted by Newton's method [Jakob2014].

        Slopes along wi are sought in the domain of erf, those across are Gaussian.
        """
        stretched = Vector3f(self._alpha * wi.x, self._alpha * wi.y, abs(wi.z))  # finite also where wi.z < 0
        sin2 = dr.square(stretched.x) + dr.square(stretched.y)
        over_sin = dr.rsqrt(sin2 + TINY)
        cot, tan = stretched.z * over_sin, dr.sqrt(sin2) / away_from_zero(stretched.z)
        along = _beckmann_slope(cot, tan, greater(lesser(u2.x, Float(1 - BECKMANN_U_MIN)), Float(BECKMANN_U_MIN)))
        across = dr.erfinv(dr.fma(greater(lesser(u2.y, Float(1 - BECKMANN_U_MIN)), Float(BECKMANN_U_MIN)), 2, -1))
        upright = sin2 < TINY  # no direction to turn to
        cos_phi = dr.select(upright, 1, stretched.x * over_sin)
        sin_phi = dr.select(upright, 0, stretched.y * over_sin)
        return Vector3f(
            self._alpha * (sin_phi * across - cos_phi * along), -self._alpha * (sin_phi * along + cos_phi * across), 1
        )


def _beckmann_slope(cot, tan, u):
    """Return the slope along wi of visible normals of width 1, for the cotangent and tangent of wi's angle."""
    top = dr.erf(cot)
    scale = tan * (1 / math.sqrt(math.pi))
    x = top - (top + 1) * dr.erf(dr.sqrt(-dr.log(u)))  # exact at a grazing wi, which is the least linear case
    u = u * (1 + top + scale * exp2(dr.square(cot) * -math.log2(math.e)))
    for _ in range(3):
        slope = dr.erfinv(x)
        x -= (1 + x + scale * exp2(dr.square(slope) * -math.log2(math.e)) - u) / (1 - slope * tan)
    return dr.erfinv(x)


class Either:
    """One of two distributions in each lane."""

    def __init__(self, first, a, b):
        self._first, self._a, self._b = first, a, b

    def density(self, h):
        """Return D."""
        return dr.select(self._first, self._a.density(h), self._b.density(h))

    def visibility(self, v):
        """Return G1 / v.z."""
        return dr.select(self._first, self._a.visibility(v), self._b.visibility(v))

    def sample(self, wi, u2):
        """Return a normal that wi sees."""
        return dr.select(self._first, self._a.sample(wi, u2), self._b.sample(wi, u2))
