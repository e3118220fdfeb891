"""Smooth plastic: a dielectric coat over a Lambertian base.

The coat mirrors F(wi). What enters is scattered by the base, and reflected between base and coat until it leaves:
f = kd / (1 - F_in) (1 - F(wi)) (1 - F(wo)) / (pi eta^2), with F_in the coat's mean reflectance from inside. The base's
colour is not shifted by what passes it more than once (`nonlinear` off in Mitsuba, whose model this is). By energy,
eta^2 (1 - F_in) is 1 - F_out, with the mean reflectance from outside: a white base loses and makes nothing. Mitsuba
fits F_in; its fit makes 0.1 % of light at index 1.5, 3 % at 2.4 and 25 % at 3, and is above 1 from 4 on.
"""

import math

import drjit as dr

from renderer.bsdfs.base import BsdfKind, BsdfSample, constant, register
from renderer.core.backend import Float, Vector3f
from renderer.core.fresnel import dielectric, diffuse_reflectance
from renderer.core.numeric import greater
from renderer.core.warp import square_to_cosine_hemisphere

# SCALE: 1 / (pi (1 - F_out)); weight of the coat in picking it, what is left for the base; inverse of the former,
# and SCALE pi over the latter
REFLECTANCE, ETA, SCALE, COAT, BASE, COAT_WEIGHT, BASE_WEIGHT = 0, 3, 4, 5, 6, 7, 8
TEXTURE_MEAN = 0.5  # what a texture counts in picking; only the noise depends on it
LEAST_MEAN = 1e-3  # what black counts, so that some part can be picked at any index


def pack(bsdf, outside):
    """Return reflectance, black where a texture gives it, index relative to the outside, and what follows from them."""
    colour = bsdf.reflectance
    mean = max(LEAST_MEAN, sum(colour) / 3) if isinstance(colour, tuple) else TEXTURE_MEAN
    eta, coat, base = bsdf.ior / outside, 1 / (1 + mean), mean / (1 + mean)
    scale = 1 / (math.pi * (1 - diffuse_reflectance(eta)))
    return [*constant(colour), eta, scale, coat, base, 1 / coat, scale * math.pi / base]


def sample(p, wi, u, u2, has):
    """Return the mirror direction, or one with the density cosine / pi."""
    _, coat, base = _picking(p, wi)
    total = coat + base
    mirrored = u * total < coat
    wo = square_to_cosine_hemisphere(u2)
    outgoing = 1 - dielectric(wo.z, p[ETA])[0]
    weight = total * dr.select(mirrored, Vector3f(p[COAT_WEIGHT]), p.vector(REFLECTANCE) * (outgoing * p[BASE_WEIGHT]))
    pdf_sa = base / total * wo.z * (1 / math.pi)
    wo = dr.select(mirrored, Vector3f(-wi.x, -wi.y, wi.z), wo)
    valid = (wi.z > 0) & (wo.z > 0)
    weight, pdf_sa = dr.select(valid, weight, 0), dr.select(valid & ~mirrored, pdf_sa, 0)
    return BsdfSample(wo, weight, pdf_sa, valid & mirrored, Float(1))


def evaluate(p, wi, wo, has):
    """Return value and density of the base."""
    reflectance, coat, base = _picking(p, wi)
    outgoing = 1 - dielectric(greater(wo.z, Float(0)), p[ETA])[0]
    cosine = dr.select((wi.z > 0) & (wo.z > 0), wo.z, 0)
    value = p.vector(REFLECTANCE) * ((1 - reflectance) * outgoing * p[SCALE] * cosine)
    return value, base / (coat + base) * cosine * (1 / math.pi)


def albedo(p):
    """Return the reflectance of the base."""
    return p.vector(REFLECTANCE)


def _picking(p, wi):
    """Return the coat's reflectance, and the weights of coat and base in picking them."""
    reflectance = dielectric(greater(wi.z, Float(0)), p[ETA])[0]
    return reflectance, reflectance * p[COAT], (1 - reflectance) * p[BASE]


register(BsdfKind("plastic", pack, sample, evaluate, albedo, textured={"reflectance": (REFLECTANCE, 3)}))
