"""Smooth glass: mirrored and refracted direction, picked with the probabilities of the Fresnel equations.

Radiance that enters a medium of index eta is 1 / eta^2 of what it is behind it, hence the weight of refraction.
"""

import drjit as dr

from renderer.bsdfs import glass
from renderer.bsdfs.base import BsdfKind, BsdfSample, nothing, register
from renderer.core.backend import Float, Vector3f
from renderer.core.fresnel import dielectric


def pack(bsdf, outside):
    """Return the factors and the index relative to the outside."""
    return glass.pack(bsdf, bsdf.ior / outside)


def sample(p, wi, u, u2, has):
    """Return the mirrored or refracted direction."""
    outside, cos_i, (eta, inverse) = wi.z > 0, abs(wi.z), glass.seen_from(wi, p)
    reflectance, cos_t = dielectric(cos_i, eta)
    mirrored = u < reflectance
    scale = dr.select(mirrored, -1, -inverse)
    wo = Vector3f(wi.x * scale, wi.y * scale, dr.select(mirrored, wi.z, dr.select(outside, -cos_t, cos_t)))
    weight = glass.tinted(dr.select(mirrored, 1, dr.square(inverse)), mirrored, p, has)
    valid = wi.z != 0
    return BsdfSample(wo, dr.select(valid, Vector3f(weight), 0), Float(0), valid, dr.select(mirrored, 1, eta))


register(BsdfKind(
    "dielectric", pack, sample, nothing, glass.albedo, glass.features, smooth=lambda bsdf: False, transmits=True
))  # fmt: skip
