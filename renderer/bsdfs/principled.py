"""The artists' material of [Burley2012], with the dielectric Fresnel factor of [Burley2015], without transmission.

A GGX highlight whose Fresnel factor blends dielectric, tinted dielectric and metal; a base with retro-reflection;
sheen; and a clear coat (GTR1). All as Mitsuba has them: masking is separable, and sheen and coat are scaled as there.
Lobes are picked by the weights 1 (highlight), 1 - metallic (base) and clearcoat / 4, with what wi sees of the
highlight's normals. One deviation: where `specular` is 0, metals and tints still shine (Mitsuba turns them off).
"""

import math

import drjit as dr

from renderer.bsdfs import microfacet
from renderer.bsdfs.base import BsdfKind, BsdfSample, constant, register
from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.elementary import exp2, log2, sincos_turns
from renderer.core.fresnel import dielectric
from renderer.core.numeric import TINY, greater

COLOUR, ROUGHNESS, METALLIC, ETA, TINT, TINTED_F0, ASPECT, SHEEN, SHEEN_TINT, COAT, COAT_ALPHA = (
    0, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12)
METAL, TINTED, ANISOTROPIC, SHEENED, SHEEN_TINTED, COATED = (
    "metal", "tinted", "anisotropic", "sheen", "sheentint", "clearcoat")
ALPHA_LEAST = 1e-3
COAT_F0, COAT_MASKING_ALPHA, COAT_STRENGTH = 0.04, 0.25, 0.25
COAT_ALPHAS = 0.1, 0.001  # for gloss 0 and 1
LUMINANCE = 0.212671, 0.715160, 0.072169  # of linear sRGB, as Mitsuba has it
RETRO = 2.0  # retro-reflection for each unit of roughness


def pack(bsdf, outside):
    """Return the parameters, 0 where a texture gives them; the index of the highlight is relative by definition."""
    b, given = bsdf, lambda value: value if isinstance(value, (int, float)) else 0.0
    eta = 2 / (1 - math.sqrt(0.08 * b.specular)) - 1
    low, high = COAT_ALPHAS
    return [
        *constant(b.basecolor), given(b.roughness), given(b.metallic),
        eta, b.speculartint, ((eta - 1) / (eta + 1)) ** 2, math.sqrt(1 - 0.9 * b.anisotropic),
        b.sheen, b.sheentint, b.clearcoat, low + (high - low) * b.clearcoatgloss,
    ]  # fmt: skip


def features(bsdf):
    """Return which parts an instance has."""
    b = bsdf
    parts = {METAL: not isinstance(b.metallic, (int, float)) or b.metallic > 0, TINTED: b.speculartint > 0,
             ANISOTROPIC: b.anisotropic > 0, SHEENED: b.sheen > 0, SHEEN_TINTED: b.sheen > 0 and b.sheentint > 0,
             COATED: b.clearcoat > 0}  # fmt: skip
    return tuple(name for name, there in parts.items() if there)


def sample(p, wi, u, u2, has):
    """Return a direction of one of the lobes; the density is that of all."""
    diffuse, coat = _picking(p, has)
    h = _highlight(p, has).sample(wi, u2)
    sin_phi, cos_phi = sincos_turns(u2.x)
    if COATED in has:
        # sin^2 of the normal from (alpha^2)^(1 - u), where 1 - cos^2 would cancel [Burley2012, eq. B.2]
        alpha2 = dr.square(p[COAT_ALPHA])
        sin2 = (exp2(log2(alpha2) * (1 - u2.y)) - alpha2) / (1 - alpha2)
        sin = dr.sqrt(greater(sin2, Float(0)))
        of_coat = Vector3f(sin * cos_phi, sin * sin_phi, dr.sqrt(greater(1 - sin2, Float(0))))
        h = dr.select(u < diffuse + coat, of_coat, h)
    sin = dr.sqrt(u2.y)
    base = Vector3f(sin * cos_phi, sin * sin_phi, dr.sqrt(1 - u2.y))
    wo = dr.select(u < diffuse, base, microfacet.reflect(wi, h))
    value, pdf_sa = evaluate(p, wi, wo, has)
    valid = pdf_sa > 0
    weight = dr.select(valid, value * dr.rcp(dr.select(valid, pdf_sa, 1)), 0)
    return BsdfSample(wo, weight, pdf_sa, Bool(False), Float(1))


def evaluate(p, wi, wo, has):
    """Return value and density of all lobes."""
    diffuse, coat = _picking(p, has)
    h = wi + wo
    length2 = dr.squared_norm(h) + TINY
    cos_d = 0.5 * dr.sqrt(length2)  # of both directions with h
    schlick_d = _schlick(cos_d)
    highlight = _highlight(p, has)
    of_highlight = highlight.density(h) * highlight.visibility(wi) * 0.25
    pdf_sa = (1 - diffuse - coat) * of_highlight + diffuse * wo.z * (1 / math.pi)
    value = _fresnel(p, cos_d, schlick_d, has) * (of_highlight * highlight.visibility(wo) * wo.z)
    value = value + p.vector(COLOUR) * (_base(p, wi, wo, cos_d, has) * wo.z)
    if SHEENED in has:
        value = value + _sheen_tint(p, has) * (p[SHEEN] * _not_metal(p, has) * schlick_d * wo.z)
    if COATED in has:
        density = _coat_density(p, h, length2)
        pdf_sa = pdf_sa + coat * density * (0.25 / cos_d) * (h.z * 0.5 / cos_d)
        masking = microfacet.Ggx(*[Float(COAT_MASKING_ALPHA)] * 2)
        masked = masking.visibility(wi) * masking.visibility(wo) * wi.z * wo.z
        reflectance = COAT_F0 + (1 - COAT_F0) * schlick_d
        value = value + COAT_STRENGTH * p[COAT] * reflectance * density * masked * wo.z
    valid = (wi.z > 0) & (wo.z > 0)
    return dr.select(valid, value, 0), dr.select(valid, pdf_sa, 0)


def albedo(p):
    """Return the colour of the base."""
    return p.vector(COLOUR)


def _schlick(cos):
    """Return (1 - cos)^5."""
    rest = greater(1 - cos, Float(0))
    return dr.square(dr.square(rest)) * rest


def _not_metal(p, has):
    """Return 1 - metallic."""
    return 1 - p[METALLIC] if METAL in has else Float(1)


def _picking(p, has):
    """Return the probabilities of base and coat."""
    diffuse = _not_metal(p, has)
    if COATED not in has:
        return (diffuse / (1 + diffuse) if METAL in has else Float(0.5)), Float(0)
    coat = COAT_STRENGTH * p[COAT]
    total = dr.rcp(1 + diffuse + coat)
    return diffuse * total, coat * total


def _highlight(p, has):
    """Return the distribution of the highlight's normals."""
    alpha = dr.square(p[ROUGHNESS])
    if ANISOTROPIC not in has:
        alpha = greater(alpha, Float(ALPHA_LEAST))
        return microfacet.Ggx(alpha, alpha)
    aspect, least = p[ASPECT], Float(ALPHA_LEAST)
    return microfacet.Ggx(greater(alpha / aspect, least), greater(alpha * aspect, least))


def _fresnel(p, cos_d, schlick_d, has):
    """Return the highlight's Fresnel factor: dielectric, tinted dielectric and metal by their shares."""
    exact, _ = dielectric(cos_d, p[ETA])
    result = Vector3f(_not_metal(p, has) * ((1 - p[TINT]) * exact if TINTED in has else exact))
    if TINTED in has:
        f0 = _hue(p) * p[TINTED_F0]
        result = result + _not_metal(p, has) * p[TINT] * (f0 + (1 - f0) * schlick_d)
    if METAL in has:
        f0 = p.vector(COLOUR)
        result = result + p[METALLIC] * (f0 + (1 - f0) * schlick_d)
    return result


def _base(p, wi, wo, cos_d, has):
    """Return diffuse and retro-reflection of a white base."""
    at_i, at_o = _schlick(wi.z), _schlick(wo.z)
    retro = RETRO * p[ROUGHNESS] * dr.square(cos_d)
    flat = (1 - 0.5 * at_i) * (1 - 0.5 * at_o)
    return _not_metal(p, has) * (1 / math.pi) * (flat + retro * (at_o + at_i + at_o * at_i * (retro - 1)))


def _hue(p):
    """Return the base's colour over its luminance; white for black."""
    colour = p.vector(COLOUR)
    luminance = dr.dot(colour, Vector3f(*LUMINANCE))
    return dr.select(luminance > 0, colour / dr.select(luminance > 0, luminance, 1), 1)


def _sheen_tint(p, has):
    """Return the sheen's colour."""
    return 1 + p[SHEEN_TINT] * (_hue(p) - 1) if SHEEN_TINTED in has else Vector3f(1)


def _coat_density(p, h, length2):
    """Return GTR1, (alpha^2 - 1) / (2 pi ln(alpha) (sin^2 + alpha^2 cos^2)) of a normal of any length."""
    alpha = p[COAT_ALPHA]
    spread = dr.square(h.x) + dr.square(h.y) + dr.square(alpha * h.z)
    return (dr.square(alpha) - 1) * (0.5 / math.pi) / (math.log(2) * log2(alpha)) * length2 / (spread + TINY)


register(BsdfKind(
    "principled", pack, sample, evaluate, albedo, features,
    textured={"basecolor": (COLOUR, 3), "roughness": (ROUGHNESS, 1), "metallic": (METALLIC, 1)},
))  # fmt: skip
