"""Smooth glass: mirrored and refracted direction, picked with the probabilities of the Fresnel equations.

Radiance that enters a medium of index eta is 1 / eta^2 of what it is behind it, hence the weight of refraction.
"""

import drjit as dr

from renderer.bsdfs.base import BsdfKind, BsdfSample, nothing, register, seen_from
from renderer.core.backend import Float, Vector3f
from renderer.core.fresnel import dielectric

REFLECTANCE, TRANSMITTANCE, ETA, INVERSE = 0, 3, 6, 7  # the index, and its inverse
TINTED = "tinted"
WHITE = (1.0, 1.0, 1.0)


def pack(bsdf, outside):
    """Return the factors and the index relative to the outside."""
    eta = bsdf.ior / outside
    return [*bsdf.reflectance, *bsdf.transmittance, eta, 1 / eta]


def features(bsdf):
    """Return TINTED where the factors are not 1."""
    return () if tuple(bsdf.reflectance) == WHITE == tuple(bsdf.transmittance) else (TINTED,)


def sample(p, wi, u, u2, has):
    """Return the mirrored or refracted direction."""
    outside, cos_i, (eta, inverse) = wi.z > 0, abs(wi.z), seen_from(wi, p[ETA], p[INVERSE])
    reflectance, cos_t = dielectric(cos_i, eta)
    mirrored = u < reflectance
    scale = dr.select(mirrored, -1, -inverse)
    wo = Vector3f(wi.x * scale, wi.y * scale, dr.select(mirrored, wi.z, dr.select(outside, -cos_t, cos_t)))
    weight = dr.select(mirrored, 1, dr.square(inverse))
    if TINTED in has:
        weight = weight * dr.select(mirrored, p.vector(REFLECTANCE), p.vector(TRANSMITTANCE))
    valid = wi.z != 0
    return BsdfSample(wo, dr.select(valid, Vector3f(weight), 0), Float(0), valid, dr.select(mirrored, 1, eta))


def albedo(p):
    """Return the factor of what is refracted."""
    return p.vector(TRANSMITTANCE)


register(BsdfKind(
    "dielectric", pack, sample, nothing, albedo, features, smooth=lambda bsdf: False, transmits=True
))  # fmt: skip
