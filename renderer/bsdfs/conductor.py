"""Smooth metal: the mirror direction, by the Fresnel equations of the complex index."""

import drjit as dr

from renderer.bsdfs.base import BsdfKind, BsdfSample, constant, nothing, register
from renderer.core.backend import Float, Vector3f
from renderer.core.fresnel import conductor, conductor_terms

REFLECTANCE, DIFFERENCE, PRODUCT = 0, 3, 6  # the factor, and the terms of the index


def pack(bsdf, outside):
    """Return the factor, black where a texture gives it, and the terms of the index relative to the outside."""
    terms = [conductor_terms(eta / outside, k / outside) for eta, k in zip(bsdf.eta, bsdf.k)]
    return [*constant(bsdf.reflectance), *(difference for difference, _ in terms), *(product for _, product in terms)]


def sample(p, wi, u, u2, has):
    """Return the mirror direction."""
    valid = wi.z > 0
    weight = p.vector(REFLECTANCE) * conductor(wi.z, p.vector(DIFFERENCE), p.vector(PRODUCT))
    return BsdfSample(Vector3f(-wi.x, -wi.y, wi.z), dr.select(valid, weight, 0), Float(0), valid, Float(1))


def albedo(p):
    """Return the reflectance at normal incidence."""
    return p.vector(REFLECTANCE) * conductor(Float(1), p.vector(DIFFERENCE), p.vector(PRODUCT))


register(BsdfKind(
    "conductor", pack, sample, nothing, albedo, smooth=lambda bsdf: False, textured={"reflectance": (REFLECTANCE, 3)}
))  # fmt: skip
