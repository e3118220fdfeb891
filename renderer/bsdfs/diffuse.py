"""Lambertian surface: reflectance / pi in all directions."""

import math

import drjit as dr

from renderer.bsdfs.base import BsdfKind, BsdfSample, constant, register
from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.numeric import greater
from renderer.core.warp import cosine_hemisphere_pdf_sa, square_to_cosine_hemisphere

REFLECTANCE = 0


def pack(bsdf, outside):
    """Return the reflectance, black where a texture gives it."""
    return [*constant(bsdf.reflectance)]


def sample(p, wi, u, u2, has):
    """Return a direction with the density cosine / pi, whose weight is the reflectance."""
    wo = square_to_cosine_hemisphere(u2)
    valid = (wi.z > 0) & (wo.z > 0)
    pdf_sa = dr.select(valid, cosine_hemisphere_pdf_sa(wo), 0)
    return BsdfSample(wo, dr.select(valid, p.vector(REFLECTANCE), Vector3f(0)), pdf_sa, Bool(False), Float(1))


def evaluate(p, wi, wo, has):
    """Return the value times cosine, and cosine / pi."""
    cosine = dr.select(wi.z > 0, greater(wo.z, Float(0)), 0) * (1 / math.pi)
    return p.vector(REFLECTANCE) * cosine, cosine


def albedo(p):
    """Return the reflectance."""
    return p.vector(REFLECTANCE)


register(BsdfKind("diffuse", pack, sample, evaluate, albedo, textured={"reflectance": (REFLECTANCE, 3)}))
