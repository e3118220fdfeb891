"""Smooth plastic: a dielectric coat over a Lambertian base.

The coat mirrors F(wi). What enters is scattered by the base, and reflected between base and coat until it leaves:
f = kd / (1 - F_in) (1 - F(wi)) (1 - F(wo)) / (pi eta^2), with F_in the coat's mean reflectance from inside. The base's
colour is not shifted by what passes it more than once (`nonlinear` off in Mitsuba, whose model this is).
"""

import math

import drjit as dr

from renderer.bsdfs.base import BsdfKind, BsdfSample, register
from renderer.core.backend import Float, Vector3f
from renderer.core.fresnel import dielectric, diffuse_reflectance
from renderer.core.numeric import greater
from renderer.core.warp import square_to_cosine_hemisphere

REFLECTANCE, ETA, SCALE, SPECULAR = 0, 3, 4, 5  # SCALE: 1 / (pi eta^2 (1 - F_in)); weight of the coat in picking it
TEXTURE_MEAN = 0.5  # what a texture counts in picking; only the noise depends on it


def pack(bsdf, outside):
    """Return reflectance, black where a texture gives it, index relative to the outside, and what follows from them."""
    constant = isinstance(bsdf.reflectance, tuple)
    mean = sum(bsdf.reflectance) / 3 if constant else TEXTURE_MEAN
    eta = bsdf.ior / outside
    scale = 1 / (math.pi * eta**2 * (1 - diffuse_reflectance(1 / eta)))
    return [*(bsdf.reflectance if constant else (0.0, 0.0, 0.0)), eta, scale, 1 / (1 + mean)]


def sample(p, wi, u, u2, has):
    """Return the mirror direction, or one with the density cosine / pi."""
    reflectance, specular = _picking(p, wi)
    mirrored = u < specular
    wo = square_to_cosine_hemisphere(u2)
    outgoing = 1 - dielectric(wo.z, p[ETA])[0]
    rest = 1 - specular
    weight = p.vector(REFLECTANCE) * ((1 - reflectance) * outgoing * p[SCALE] * math.pi / rest)
    weight = dr.select(mirrored, Vector3f(reflectance / specular), weight)
    wo = dr.select(mirrored, Vector3f(-wi.x, -wi.y, wi.z), wo)
    valid = (wi.z > 0) & (wo.z > 0)
    pdf_sa = dr.select(valid & ~mirrored, rest * wo.z * (1 / math.pi), 0)
    return BsdfSample(wo, dr.select(valid, weight, 0), pdf_sa, valid & mirrored, Float(1))


def evaluate(p, wi, wo, has):
    """Return value and density of the base."""
    reflectance, specular = _picking(p, wi)
    outgoing = 1 - dielectric(greater(wo.z, Float(0)), p[ETA])[0]
    cosine = dr.select((wi.z > 0) & (wo.z > 0), wo.z, 0)
    value = p.vector(REFLECTANCE) * ((1 - reflectance) * outgoing * p[SCALE] * cosine)
    return value, (1 - specular) * cosine * (1 / math.pi)


def albedo(p):
    """Return the reflectance of the base."""
    return p.vector(REFLECTANCE)


def _picking(p, wi):
    """Return the coat's reflectance, and the probability of picking it."""
    reflectance = dielectric(greater(wi.z, Float(0)), p[ETA])[0]
    coat, base = reflectance * p[SPECULAR], (1 - reflectance) * (1 - p[SPECULAR])
    return reflectance, coat / (coat + base)


register(BsdfKind("plastic", pack, sample, evaluate, albedo, textured={"reflectance": (REFLECTANCE, 3)}))
