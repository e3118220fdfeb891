"""The coursework's material made physical: Lambertian base, normalised Blinn-Phong lobe, a share of mirror or glass.

f = (1 - rho) (kd Cd / pi + ks Cs N (n.h)^e) + rho times mirror, blurred mirror (GGX, F = 1) or smooth glass, with
N = (e + 2) (e + 4) / (8 pi (2^(-e/2) + e)): the lobe's albedo is 1 at normal incidence and falls with the angle.
kd and ks are divided by max(1, kd max Cd + ks max Cs), so that no energy is made; of textures, where they are met.
rho is picked with probability rho, the lobe, where it is strong, with its share of the weights, by half vectors of
density (e + 1) / (2 pi) (n.h)^e.
Both sides look alike but for glass, whose inside is at wi.z < 0.
"""

import math

import drjit as dr

from renderer.bsdfs import microfacet
from renderer.bsdfs.base import BsdfKind, BsdfSample, register, turned
from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.elementary import exp2, exp2_both, log2, log2_below_1, sincos_turns
from renderer.core.fresnel import dielectric
from renderer.core.numeric import TINY, away_from_zero, greater

# Diffuse colour; its factor kd (1 - rho) / pi; colour of the lobe with all its factors; e / 2 and 2 / (e + 1), as
# squares of cosines ask for; rho; rho and the probability of the lobe; factors of the densities of base and lobe; index
# and inverse; 1 for glass; alpha of mirrors
COLOUR, KD, LOBE, HALF_EXPONENT, TWICE_INVERSE, RHO, RHO_OR_LOBE, DIFFUSE_PDF, LOBE_PDF = 0, 3, 4, 7, 8, 9, 10, 11, 12
ETA, INVERSE_ETA, IS_GLASS, ALPHA, KD_MADE, KS_MADE = 13, 14, 15, 16, 17, 18  # the last two: energy made if above 1
DIFFUSE, HIGHLIGHT, MIRROR, BLURRED, GLASS = "diffuse", "highlight", "mirror", "blurred", "glass"  # features
LOBE_DRAWN = "lobe drawn"  # feature: the highlight is so strong that directions are drawn from it
LIMITED = "limited"  # feature: kd and ks are divided by what depends on the texture


def pack(material, outside):
    """Return the columns of a Material without `bsdf`; the diffuse colour is black where a texture gives it."""
    m, e, rho, has = material, material.specularexponent, _share(material), features(material)
    brightest, limited = _brightest(m), LIMITED in has
    limit = 1.0 if limited else 1 / max(1.0, m.kd * brightest + m.ks * max(m.specularcolor))
    lobe = m.ks * sum(m.specularcolor) / 3
    base = m.kd * (sum(m.diffusecolor) / 3 if m.texture is None else brightest / 2)
    chosen = (1 - rho) * lobe / (lobe + base) if LOBE_DRAWN in has else 0.0
    rest = 1 - rho - chosen if base > 0 else 0.0
    eta = m.refractiveindex / outside if GLASS in has else 1.0
    return [
        *(m.diffusecolor if m.texture is None else (0.0, 0.0, 0.0)), m.kd * limit * (1 - rho) / math.pi,
        *(colour * m.ks * limit * (1 - rho) * _peak(e) for colour in m.specularcolor), e / 2, 2 / (e + 1),
        rho, rho + chosen, rest / math.pi, chosen * (e + 1) / (4 * math.pi),
        eta, 1 / eta, float(GLASS in has), m.roughness if BLURRED in has else microfacet.SMOOTH,
        m.kd if limited else 0.0, m.ks * max(m.specularcolor) if limited else 0.0,
    ]  # fmt: skip


def features(material):
    """Return which of the parts an instance has."""
    m, rho = material, _share(material)
    diffuse = rho < 1 and m.kd * _brightest(m) > 0
    highlight = rho < 1 and m.ks * max(m.specularcolor) > 0
    mirror = rho > 0 and not m.isrefractive
    is_blurred = mirror and m.roughness >= microfacet.ALPHA_MIN
    # where it is weaker than the base even at its peak, drawing from it costs more than the noise that it would save
    drawn = highlight and m.ks * max(m.specularcolor) * _peak(m.specularexponent) * math.pi > m.kd * _brightest(m)
    limited = diffuse and m.texture is not None and m.kd * _brightest(m) + m.ks * max(m.specularcolor) > 1
    parts = {DIFFUSE: diffuse, HIGHLIGHT: highlight, LOBE_DRAWN: drawn, LIMITED: limited, BLURRED: is_blurred,
             MIRROR: mirror and not is_blurred, GLASS: rho > 0 and m.isrefractive}  # fmt: skip
    return tuple(name for name, there in parts.items() if there)


def smooth(material):
    """Return whether there is more than mirror and glass."""
    return bool({DIFFUSE, HIGHLIGHT, BLURRED}.intersection(features(material)))


def sample(p, wi, u, u2, has):
    """Return a direction of one of the parts; the density is that of all parts that are not delta."""
    front = turned(wi, wi)
    if not {DIFFUSE, HIGHLIGHT, BLURRED}.intersection(has):
        ideal = _delta(p, wi, u, has)
        ideal.delta = (front.z > 0) & (u < p[RHO])
        ideal.weight = dr.select(ideal.delta, ideal.weight, 0)
        return ideal
    wo, lobe = _not_delta(p, front, u, u2, has)
    delta = Bool(False)
    value, pdf_sa = _evaluate(p, front, wo, lobe, has)
    valid = (front.z > 0) & (wo.z > 0) & (pdf_sa > 0)
    weight, eta = value * dr.rcp(dr.select(valid, pdf_sa, 1)), Float(1)
    wo = turned(wo, wi)
    if MIRROR in has or GLASS in has:
        delta = u < p[RHO]
        if BLURRED in has:
            delta = delta & (p[ALPHA] < 0)
        ideal = _delta(p, wi, u, has)
        wo, eta = dr.select(delta, ideal.wo, wo), dr.select(delta, ideal.eta, eta)
        weight, pdf_sa = dr.select(delta, ideal.weight, weight), dr.select(delta, 0, pdf_sa)
        valid = dr.select(delta, front.z > 0, valid)
    return BsdfSample(wo, dr.select(valid, weight, 0), dr.select(valid, pdf_sa, 0), delta & valid, eta)


def evaluate(p, wi, wo, has):
    """Return value and density of all parts that are not delta; 0 unless both directions are on the same side."""
    wo, wi = turned(wo, wi), turned(wi, wi)
    value, pdf_sa = _evaluate(p, wi, wo, _lobe(p, wi, wo) if HIGHLIGHT in has else None, has)
    valid = (wi.z > 0) & (wo.z > 0)
    return dr.select(valid, value, 0), dr.select(valid, pdf_sa, 0)


def albedo(p):
    """Return the diffuse colour."""
    return p.vector(COLOUR)


def _peak(e):
    """Return N, the value of the lobe at h = n."""
    return (e + 2) * (e + 4) / (8 * math.pi * (2 ** (-e / 2) + e))


def _share(material):
    """Return rho, the share of mirror or glass."""
    return material.reflectivity if material.isreflective or material.isrefractive else 0.0


def _brightest(material):
    """Return the greatest diffuse component that can be."""
    if material.texture is None:
        return max(material.diffusecolor)
    return 1.0 if isinstance(material.texture, str) else max(*material.texture.color1, *material.texture.color2)


def _lobe(p, wi, wo):
    """Return (n.h)^e, and 1 / |wi + wo|, for directions above the surface."""
    h = wi + wo
    across2, up2 = dr.square(h.x) + dr.square(h.y), dr.square(h.z)
    inverse = dr.rsqrt(across2 + up2 + TINY)
    inverse2 = dr.square(inverse)
    return exp2(log2_below_1(up2 * inverse2, across2 * inverse2) * p[HALF_EXPONENT]), inverse


def _not_delta(p, wi, u, u2, has):
    """Return a direction of base, lobe or blurred mirror, and what `_lobe` says of it (None without highlight).

    All parts have the azimuth's sine and cosine in common. What the lobe says of its own direction is known before the
    direction is, from (n.h)^(e + 1) = 1 - u: asked of either direction afterwards, it would have to be waited for.
    """
    sin_phi, cos_phi = sincos_turns(u2.x)
    rest = 1 - u2.y
    cos, sin = dr.sqrt(rest), dr.sqrt(u2.y)  # of a cosine-weighted hemisphere
    wo, lobe = Vector3f(sin * cos_phi, sin * sin_phi, cos), None
    if LOBE_DRAWN in has:
        cos2, sin2 = exp2_both(log2(rest) * p[TWICE_INVERSE])
        sin, cos_h = dr.sqrt(sin2), dr.sqrt(cos2)
        h = Vector3f(sin * cos_phi, sin * sin_phi, cos_h)
        cos_d = dr.dot(wi, h)
        # half vectors that wi sees from behind lead below the surface; their numbers only have to be finite
        lobe = rest / cos_h, 0.5 / away_from_zero(greater(cos_d, Float(0)))
        if DIFFUSE in has:
            chosen = u < p[RHO_OR_LOBE]
            lobe = tuple(dr.select(chosen, there, here) for there, here in zip(lobe, _lobe(p, wi, wo)))
            wo = dr.select(chosen, dr.fma(h, 2 * cos_d, -wi), wo)
        else:
            wo = dr.fma(h, 2 * cos_d, -wi)
    if BLURRED in has:
        blurred = (u < p[RHO]) & (p[ALPHA] > 0)
        wo = dr.select(blurred, microfacet.reflect(wi, _ggx(p).sample(wi, u2)), wo)
    if HIGHLIGHT in has and (LOBE_DRAWN not in has or BLURRED in has):
        lobe = _lobe(p, wi, wo)
    return wo, lobe


def _evaluate(p, wi, wo, lobe, has):
    """Return value and density of what is not delta, for directions above the surface; `lobe` is as of `_lobe`."""
    value, pdf_sa = Vector3f(0), Float(0)
    cosine = wo.z / _limit(p) if LIMITED in has else wo.z
    if DIFFUSE in has:
        value, pdf_sa = p.vector(COLOUR) * (p[KD] * cosine), p[DIFFUSE_PDF] * wo.z
    if HIGHLIGHT in has:
        power, inverse = lobe
        value = value + p.vector(LOBE) * (power * cosine)
        if LOBE_DRAWN in has:
            pdf_sa = pdf_sa + p[LOBE_PDF] * power * inverse
    if BLURRED in has:
        ggx = _ggx(p)
        density = dr.select(p[ALPHA] > 0, p[RHO] * ggx.density(wi + wo) * ggx.visibility(wi) * 0.25, 0)
        value = value + density * ggx.visibility(wo) * wo.z
        pdf_sa = pdf_sa + density
    return value, pdf_sa


def _limit(p):
    """Return by what kd and ks are divided."""
    colour = p.vector(COLOUR)
    return greater(dr.fma(p[KD_MADE], greater(greater(colour.x, colour.y), colour.z), p[KS_MADE]), Float(1))


def _ggx(p):
    """Return the distribution of the blurred mirror's normals."""
    alpha = abs(p[ALPHA])  # 1 in lanes without
    return microfacet.Ggx(alpha, alpha)


def _delta(p, wi, u, has):
    """Return the mirrored or refracted direction, in the frame that is not turned."""
    wo, weight, eta = Vector3f(-wi.x, -wi.y, wi.z), Float(1), Float(1)
    if GLASS in has:
        outside = wi.z > 0
        index, inverse = dr.select(outside, p[ETA], p[INVERSE_ETA]), dr.select(outside, p[INVERSE_ETA], p[ETA])
        reflectance, cos_t = dielectric(abs(wi.z), index)
        through = u >= reflectance * p[RHO]
        if MIRROR in has:
            through = through & (p[IS_GLASS] > 0)
        refracted = Vector3f(-wi.x * inverse, -wi.y * inverse, dr.select(outside, -cos_t, cos_t))
        wo = dr.select(through, refracted, wo)
        weight, eta = dr.select(through, dr.square(inverse), 1), dr.select(through, index, 1)
    return BsdfSample(wo, Vector3f(weight), Float(0), Bool(True), eta)


register(BsdfKind(
    "coursework", pack, sample, evaluate, albedo, features, smooth, transmits=True, textured={"texture": (COLOUR, 3)}
))  # fmt: skip
