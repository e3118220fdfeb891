"""Rough glass: microfacets that reflect and refract by the Fresnel equations [Walter2007].

With n = 1 for reflection and n = eta (behind over in front) for refraction, v = wi + n wo points along the facet's
normal h, and |wi.h + n wo.h| = |v|. For both, the density is P D(h) G1(wi) / wi.z (wi.h) n^2 |wo.h| / |v|^2, with P = F
or 1 - F [Walter2007, eq. 14, 17], and the value is that times G1(wo), of refraction also times 1 / eta^2 for the
change of radiance [Veach1997, sec. 5.2]. Light that is scattered twice on the microfacets is lost.
An alpha below ALPHA_MIN that is no texture gives `dielectric`.
"""

import drjit as dr

from renderer.bsdfs import glass, microfacet
from renderer.bsdfs.base import BsdfKind, BsdfSample, nothing, register, turned
from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.fresnel import dielectric
from renderer.core.numeric import TINY

ALPHA = 8  # column, behind those of glass
# An index nearer to 1 counts as this far: v would vanish, and with less a direction changes by less than 1e-3 alpha.
ETA_MIN = 1e-3


def pack(bsdf, outside):
    """Return the factors, the index relative to the outside, and the distribution."""
    eta, (alpha, is_beckmann) = bsdf.ior / outside, microfacet.pack(bsdf)
    if abs(eta - 1) < ETA_MIN and alpha != microfacet.SMOOTH:
        eta = 1 + ETA_MIN
    return [*glass.pack(bsdf, eta), alpha, is_beckmann]


def features(bsdf):
    """Return which code an instance needs."""
    return (*microfacet.features(bsdf), *glass.features(bsdf))


def sample(p, wi, u, u2, has):
    """Return a reflection or refraction at a normal that wi sees; of smooth lanes, at the surface's own normal."""
    front = turned(wi, wi)
    eta, inverse = glass.seen_from(wi, p)
    is_rough, is_smooth = microfacet.rough(has), microfacet.smooth_lanes(p, ALPHA, has)
    h = microfacet.distribution(p, ALPHA, has).sample(front, u2) if is_rough else Vector3f(0, 0, 1)
    if is_rough:
        h = h * dr.rsqrt(dr.squared_norm(h) + TINY)
        if is_smooth is not False:
            h = dr.select(is_smooth, Vector3f(0, 0, 1), h)
    cos_i = dr.dot(front, h)
    reflectance, cos_t = dielectric(cos_i, eta)
    mirrored = u < reflectance
    along, scale = dr.select(mirrored, 2 * cos_i, dr.fma(cos_i, inverse, -cos_t)), dr.select(mirrored, 1, inverse)
    wo = dr.fma(h, along, front * -scale)
    valid = (front.z > 0) & (cos_i > 0) & (mirrored == (wo.z > 0))
    weight = dr.select(mirrored, 1, dr.square(inverse))
    pdf_sa = Float(0)
    if is_rough:
        value, density = _evaluate(p, front, wo, eta, inverse, has)
        share, pdf_sa = dr.select(density > 0, value / density, 0), density
        if is_smooth is not False:
            share, pdf_sa = dr.select(is_smooth, weight, share), dr.select(is_smooth, 0, pdf_sa)
        weight = share
    weight = glass.tinted(weight, mirrored, p, has)
    return BsdfSample(turned(wo, wi), dr.select(valid, Vector3f(weight), 0), dr.select(valid, pdf_sa, 0),
                      valid & Bool(is_smooth), dr.select(mirrored, 1, eta))  # fmt: skip


def evaluate(p, wi, wo, has):
    """Return value and density of reflection or refraction, by the sides of the directions."""
    if not microfacet.rough(has):
        return nothing(p, wi, wo, has)
    wo, (eta, inverse) = turned(wo, wi), glass.seen_from(wi, p)
    value, pdf_sa = _evaluate(p, turned(wi, wi), wo, eta, inverse, has)
    is_smooth = microfacet.smooth_lanes(p, ALPHA, has)
    if is_smooth is not False:
        value, pdf_sa = dr.select(is_smooth, 0, value), dr.select(is_smooth, 0, pdf_sa)
    return Vector3f(glass.tinted(value, wo.z > 0, p, has)), pdf_sa


def _evaluate(p, wi, wo, eta, inverse, has):
    """Return value (without tints) and density for wi.z > 0; eta and its inverse as seen from wi."""
    distribution = microfacet.distribution(p, ALPHA, has)
    mirrored = wo.z > 0
    n = dr.select(mirrored, 1, eta)
    v = dr.fma(wo, n, wi)
    h = dr.mulsign(v, v.z)
    inverse2 = dr.rcp(dr.squared_norm(v) + TINY)
    length = dr.sqrt(inverse2)
    dot_i, dot_o = dr.dot(wi, h) * length, dr.dot(wo, h) * length
    reflectance = dielectric(dr.select(dot_i > 0, dot_i, 0), eta)[0]
    # facets that are seen from behind by one of the two; grazing directions
    valid = (wi.z > 0) & (dot_i > 0) & (dot_o * wo.z > 0)
    density = distribution.density(h) * distribution.visibility(wi) * dot_i * abs(dot_o) * dr.square(n) * inverse2
    pdf_sa = dr.select(valid, density * dr.select(mirrored, reflectance, 1 - reflectance), 0)
    cos_o = abs(wo.z)
    masking = distribution.visibility(Vector3f(wo.x, wo.y, cos_o)) * cos_o
    return dr.select(valid, pdf_sa * masking * dr.select(mirrored, 1, dr.square(inverse)), 0), pdf_sa


register(BsdfKind(
    "roughdielectric", pack, sample, evaluate, glass.albedo, features,
    smooth=lambda bsdf: microfacet.pack(bsdf)[0] != microfacet.SMOOTH, transmits=True,
    textured={"alpha": (ALPHA, 1)},
))  # fmt: skip
