"""Reflection and refraction at a smooth interface."""

import drjit as dr

from renderer.core.backend import Float, Vector3f
from renderer.core.numeric import TINY, away_from_zero, safe_sqrt


def reflect(d, n, cos_i):
    """Return the mirror direction of d at the normal n that faces it; cos_i = -d.n."""
    return dr.normalize(dr.fma(n, 2 * cos_i, d))


def dielectric(cos_i, eta):
    """Return (F, cos_t): unpolarised Fresnel reflectance, 1 at total reflection, and the cosine of the refracted ray.

    `eta` is the index behind the surface over the one in front of it, cos_i >= 0 lies in front. In terms of
    g = eta cos_t, because g = cos_i exactly at eta = 1, which 1 - sin^2 is not at grazing angles.
    Source: [Born1999, sec. 1.5.2].
    """
    eta2 = dr.square(eta)
    g2 = dr.square(cos_i) + (eta2 - 1)
    g = safe_sqrt(g2)
    r_s = (cos_i - g) / away_from_zero(cos_i + g)
    r_p = (eta2 * cos_i - g) / away_from_zero(eta2 * cos_i + g)
    reflectance = 0.5 * (dr.square(r_s) + dr.square(r_p))
    return dr.select(g2 >= 0, reflectance, Float(1)), g / eta


def refract(d, n, cos_i, cos_t, eta):
    """Return the direction behind the surface, by Snell's law; arguments as above."""
    inverse = dr.rcp(eta)
    return dr.normalize(d * inverse + n * (cos_i * inverse - cos_t))


def conductor_terms(eta, k):
    """Return eta^2 - k^2 and 4 eta^2 k^2, all that the reflectance of a metal of index eta + i k depends on; host."""
    return eta * eta - k * k, 4 * eta * eta * k * k


def conductor(cos_i, difference, product):
    """Return the unpolarised Fresnel reflectance of a metal, of colour vectors of `conductor_terms`.

    With q = |n^2 - sin^2|, a = Re sqrt(n^2 - sin^2), c = cos_i, s = sin_i:
    r_s = (q + c^2 - 2 a c) / (q + c^2 + 2 a c), r_p = r_s (q c^2 + s^4 - 2 a c s^2) / (q c^2 + s^4 + 2 a c s^2),
    and (r_s + r_p) / 2 needs one division. Source: [Born1999, sec. 14.4.2].
    """
    cos2 = dr.square(cos_i)
    sin2 = 1 - cos2
    real = difference - sin2
    q = dr.sqrt(dr.square(real) + product)
    twice_ac = 2 * cos_i * Vector3f(*(safe_sqrt(0.5 * part) for part in q + real))
    even_s, even_p = q + cos2, q * cos2 + (dr.square(sin2) + TINY)
    return (even_s - twice_ac) * even_p / ((even_s + twice_ac) * (even_p + twice_ac * sin2))


def diffuse_reflectance(eta):
    """Return the reflectance of an interface for light from all directions in front, by fits; host.

    For eta < 1 (the index behind over the one in front) the fit of [Egan1973], else that of [DEon2011].
    """
    if eta < 1:
        return -1.4399 * eta**2 + 0.7099 * eta + 0.6681 + 0.0636 / eta
    x = 1 / eta
    return 0.919317 - 3.4793 * x + 6.75335 * x**2 - 7.80989 * x**3 + 4.98554 * x**4 - 1.36881 * x**5
