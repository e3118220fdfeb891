"""Rough metal: microfacets that reflect by the Fresnel equations of the complex index [Walter2007].

f cos = F D G1(wi) G1(wo) / (4 wi.z), sampled by the normals that wi sees, so that the weight is F G1(wo).
Light that is reflected twice on the microfacets is lost. An alpha below ALPHA_MIN that is no texture gives `conductor`.
"""

import drjit as dr

from renderer.bsdfs import microfacet
from renderer.bsdfs.base import BsdfKind, BsdfSample, constant, nothing, register
from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.fresnel import conductor, conductor_terms
from renderer.core.numeric import TINY

REFLECTANCE, DIFFERENCE, PRODUCT, ALPHA = 0, 3, 6, 9  # the factor, and the terms of the index


def pack(bsdf, outside):
    """Return the factor, black where a texture gives it, the terms of the index, and the distribution."""
    terms = [conductor_terms(eta / outside, k / outside) for eta, k in zip(bsdf.eta, bsdf.k)]
    differences, products = zip(*terms)
    return [*constant(bsdf.reflectance), *differences, *products, *microfacet.pack(bsdf)]


def sample(p, wi, u, u2, has):
    """Return the reflection at a normal that wi sees; of smooth lanes, the mirror direction."""
    mirrored, is_smooth = Vector3f(-wi.x, -wi.y, wi.z), microfacet.smooth_lanes(p, ALPHA, has)
    if not microfacet.rough(has):
        weight = dr.select(wi.z > 0, _reflectance(p, wi.z), 0)
        return BsdfSample(mirrored, weight, Float(0), wi.z > 0, Float(1))
    distribution = microfacet.distribution(p, ALPHA, has)
    h = distribution.sample(wi, u2)
    wo = microfacet.reflect(wi, h)
    if is_smooth is not False:
        h, wo = dr.select(is_smooth, Vector3f(0, 0, 1), h), dr.select(is_smooth, mirrored, wo)
    valid = (wi.z > 0) & (wo.z > 0)
    pdf_sa = distribution.density(h) * distribution.visibility(wi) * 0.25
    share = distribution.visibility(wo) * wo.z
    if is_smooth is not False:
        pdf_sa, share = dr.select(is_smooth, 0, pdf_sa), dr.select(is_smooth, 1, share)
    weight = _reflectance(p, dr.dot(wi, h) * dr.rsqrt(dr.squared_norm(h))) * share
    return BsdfSample(
        wo, dr.select(valid, weight, 0), dr.select(valid, pdf_sa, 0), valid & Bool(is_smooth), Float(1)
    )


def evaluate(p, wi, wo, has):
    """Return F D G / (4 wi.z) and D G1(wi) / (4 wi.z)."""
    if not microfacet.rough(has):
        return nothing(p, wi, wo, has)
    distribution, h = microfacet.distribution(p, ALPHA, has), wi + wo
    valid = (wi.z > 0) & (wo.z > 0)
    is_smooth = microfacet.smooth_lanes(p, ALPHA, has)
    if is_smooth is not False:
        valid = valid & ~is_smooth
    pdf_sa = dr.select(valid, distribution.density(h) * distribution.visibility(wi) * 0.25, 0)
    share = dr.select(valid, distribution.visibility(wo) * wo.z, 0)
    return _reflectance(p, 0.5 * dr.sqrt(dr.squared_norm(h) + TINY)) * (pdf_sa * share), pdf_sa


def albedo(p):
    """Return the reflectance at normal incidence."""
    return _reflectance(p, Float(1))


def _reflectance(p, cos_i):
    """Return the factor times the Fresnel reflectance."""
    return p.vector(REFLECTANCE) * conductor(cos_i, p.vector(DIFFERENCE), p.vector(PRODUCT))


register(BsdfKind(
    "roughconductor", pack, sample, evaluate, albedo, features=microfacet.features,
    smooth=lambda bsdf: microfacet.pack(bsdf)[0] != microfacet.SMOOTH,
    textured={"reflectance": (REFLECTANCE, 3), "alpha": (ALPHA, 1)},
))  # fmt: skip
