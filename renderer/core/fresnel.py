"""Reflection and refraction at a smooth interface."""

import drjit as dr

from renderer.core.backend import Float
from renderer.core.numeric import safe_sqrt


def reflect(d, n, cos_i):
    """Return the mirror direction of d at the normal n that faces it; cos_i = -d.n."""
    return dr.normalize(dr.fma(n, 2 * cos_i, d))


def dielectric(cos_i, eta):
    """Return (F, cos_t): unpolarised Fresnel reflectance and the cosine of the refracted ray; F = 1 at total reflection.

    `eta` is the index behind the surface over the one in front of it, cos_i > 0 lies in front.
    Source: [Born1999, sec. 1.5.2].
    """
    sin2_t = (1 - dr.square(cos_i)) / dr.square(eta)
    cos_t = safe_sqrt(1 - sin2_t)
    r_s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    r_p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    reflectance = 0.5 * (dr.square(r_s) + dr.square(r_p))
    return dr.select(sin2_t < 1, reflectance, Float(1)), cos_t


def refract(d, n, cos_i, cos_t, eta):
    """Return the direction behind the surface, by Snell's law; arguments as above."""
    inverse = dr.rcp(eta)
    return dr.normalize(d * inverse + n * (cos_i * inverse - cos_t))
