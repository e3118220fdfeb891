"""Rough metal and rough glass: values, densities and weights.

Pairs of directions about the lobe's peak, at roughness 1e-4 to 1 and cosines down to 1e-7 (of a third of the metal's,
to 1e-30). The exact value is that of just these float32 directions. For glass, errors are divided by what a rounding of
the cosine with the facet's normal does: 1 + 1 / cos_i, and the inverse of cos_o^2 or of the distance from total
reflection.
"""

import functools

import drjit as dr
import numpy as np

from renderer.bsdfs import KINDS
from renderer.core.backend import Float, Vector2f
from renderer.core.rows import Rows
from renderer.scene.materials import RoughConductor, RoughDielectric
from tests.stability.case import ULP, Case, mitsuba, relative
from tests.stability.microfacets import ALPHAS, COUNT, ONE, PI, inputs, lanes, unit, vectors, visible

PERFECT = {"eta": (0.0, 0.0, 0.0), "k": (1e4, 1e4, 1e4)}
INDICES = 1.5, 1.001, 2.4


def kernel(record):
    """Return the kind of a BSDF, its parameters and what it needs."""
    kind = KINDS[getattr(record, "type", "coursework")]
    return kind, Rows([kind.pack(record, 1.0)])[0], frozenset(kind.features(record))


def evaluated(record, wi, wo):
    """Return (value times cosine, density) of float32 directions (N, 3)."""
    kind, p, has = kernel(record)
    value, pdf_sa = kind.evaluate(p, lanes(wi), lanes(wo), has)
    count = len(wi)
    return (value.x + dr.zeros(Float, count)).numpy(), (pdf_sa + dr.zeros(Float, count)).numpy()


def sampled(record, wi, u, u2):
    """Return (wo, weight, density) of numbers (N) and pairs (N, 2)."""
    kind, p, has = kernel(record)
    found = kind.sample(p, lanes(wi), Float(u), Vector2f(*np.ascontiguousarray(u2.T)), has)
    zero = dr.zeros(Float, len(wi))
    return (found.wo + zero).numpy().T, (found.weight.x + zero).numpy(), (found.pdf_sa + zero).numpy()


def interaction(mi, wi):
    """Return Mitsuba's surface interaction at z = normal."""
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi = vectors(mi, wi)
    return si


def theirs(plugin, wi, wo):
    """Return (value times cosine, density) of a Mitsuba plugin."""
    mi = mitsuba()
    value, pdf_sa = mi.load_dict(plugin).eval_pdf(mi.BSDFContext(), interaction(mi, wi), vectors(mi, wo))
    return value.numpy()[0], pdf_sa.numpy()


@functools.cache
def metal_pairs():
    """Return [(alpha, wi, wo)] about the lobes' peaks, above the surface; a third with cosines down to 1e-30."""
    alpha, _, wi, u = inputs()
    h, _ = visible(alpha, wi, u)
    h = unit(np.c_[h[:, :2] * alpha[:, None], h[:, 2]])
    wo = (2 * (wi * h).sum(1, keepdims=True) * h - wi).astype(np.float32)
    wi = wi.copy()
    wi[::3, 2] *= np.float32(1e-23)
    parts = [(a, wi[k * COUNT:(k + 1) * COUNT], wo[k * COUNT:(k + 1) * COUNT]) for k, a in enumerate(ALPHAS)]
    return [(a, wi[wo[:, 2] > 0], wo[wo[:, 2] > 0]) for a, wi, wo in parts]


def stretched(alpha, w):
    """Return the length of directions whose x and y are multiplied by alpha, in float64."""
    return np.sqrt(alpha**2 * (w[:, 0] ** 2 + w[:, 1] ** 2) + w[:, 2] ** 2)


def metal_exact(alpha, wi, wo):
    """Return (value times cosine, density) in float64."""
    alpha, wi, wo = float(np.float32(alpha)), wi.astype(float), wo.astype(float)
    h = wi + wo
    tan2 = (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2
    d = (1 + tan2) ** 2 / (np.pi * alpha**2 * (1 + tan2 / alpha**2) ** 2)
    pdf_sa = d / (2 * (wi[:, 2] + stretched(alpha, wi)))
    return pdf_sa * 2 * wo[:, 2] / (wo[:, 2] + stretched(alpha, wo)), pdf_sa


def metal_textbook(alpha, wi, wo):
    """Return (value times cosine, density) as F D G / (4 cos cos) is usually written, in float32."""
    with np.errstate(all="ignore"):
        h = wi + wo
        h = h / np.sqrt((h * h).sum(1, keepdims=True))
        a2, cos2 = np.float32(alpha) ** 2, h[:, 2] * h[:, 2]
        d = a2 / (PI * (cos2 * (a2 - ONE) + ONE) ** 2)
        gi, go = (2 / (ONE + np.sqrt(ONE + a2 * (ONE - w[:, 2] ** 2) / w[:, 2] ** 2)) for w in (wi, wo))
        pdf_sa = d * gi / (4 * wi[:, 2])
        return d * gi * go / (4 * wi[:, 2] * wo[:, 2]) * wo[:, 2], pdf_sa


def metal(side):
    """Return the relative errors of value and density for all pairs; side(alpha, wi, wo)."""
    found = [(side(*pairs), metal_exact(*pairs)) for pairs in metal_pairs()]
    return np.concatenate([relative(a, b) for answers, right in found for a, b in zip(answers, right)])


def ours_metal(alpha, wi, wo):
    """Return the renderer's answer."""
    return evaluated(RoughConductor(**PERFECT, reflectance=(1.0, 1.0, 1.0), alpha=alpha), wi, wo)


def their_metal(alpha, wi, wo):
    """Return Mitsuba's answer."""
    return theirs({"type": "roughconductor", "material": "none", "alpha": alpha, "distribution": "ggx"}, wi, wo)


@functools.cache
def glass_samples():
    """Return [(record, wi, wo, weight)]: what rough glass makes of directions from both sides."""
    found = []
    for number, ior in enumerate(INDICES):
        alpha, _, wi, u2 = inputs()
        wi, u = wi.copy(), np.random.default_rng(60 + number).random(len(alpha)).astype(np.float32)
        wi[::2, 2] *= -1
        for k, width in enumerate(ALPHAS):
            here, record = slice(k * COUNT, (k + 1) * COUNT, 3), RoughDielectric(ior=ior, alpha=width)
            wo, weight, _ = sampled(record, wi[here], u[here], u2[here])
            alive = weight > 0
            found.append((record, wi[here][alive], wo[alive], weight[alive]))
    return found


def weights(side):
    """Return the relative errors of weights by the directions drawn; side(record, wi, wo, weight)."""
    return np.concatenate([relative(side(*sample), glass_exact(*sample[:3])[1]) for sample in glass_samples()])


def quotient(record, wi, wo, weight):
    """Return the weight as Walter's equations have it: value over density, each by itself, in float32."""
    alpha, _, turned, _, inverse = (np.asarray(part, np.float32) for part in glass_terms(record, wi, wo))
    with np.errstate(all="ignore"):
        cos2 = turned[:, 2] ** 2
        go = 2 / (ONE + np.sqrt(ONE + alpha**2 * (ONE - cos2) / cos2))
        density = glass_textbook(record, wi, wo)
        return density * go * np.where(turned[:, 2] > 0, ONE, inverse * inverse) / density


def glass_terms(record, wi, wo):
    """Return (alpha, wi, wo turned to wi, index from wi, its inverse) in float64, as float32 has them."""
    kind, _, _ = kernel(record)
    row = np.array(kind.pack(record, 1.0), np.float32).astype(float)
    wi, wo, sign = wi.astype(float), wo.astype(float), np.sign(wi[:, 2].astype(float))
    wi, wo = (np.c_[w[:, :2], w[:, 2] * sign] for w in (wi, wo))
    return row[8], wi, wo, np.where(sign > 0, row[6], row[7]), np.where(sign > 0, row[7], row[6])


def glass_exact(record, wi, wo):
    """Return (density, the weight of the direction, condition) in float64."""
    alpha, wi, wo, eta, inverse = glass_terms(record, wi, wo)
    mirrored = wo[:, 2] > 0
    n = np.where(mirrored, 1, eta)
    v = wi + n[:, None] * wo
    length = np.linalg.norm(v, axis=1)
    h = v * (np.sign(v[:, 2]) / length)[:, None]
    cos_i, cos_o = (wi * h).sum(1), np.abs((wo * h).sum(1))
    g2 = cos_i**2 + (eta - 1) * (eta + 1)
    g = np.sqrt(np.maximum(g2, 0))
    f = np.where(g > 0, ((cos_i - g) / (cos_i + g)) ** 2 + ((eta**2 * cos_i - g) / (eta**2 * cos_i + g)) ** 2, 2) / 2
    tan2 = (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2
    d = (1 + tan2) ** 2 / (np.pi * alpha**2 * (1 + tan2 / alpha**2) ** 2)
    seen = 2 * d / (wi[:, 2] + stretched(alpha, wi)) * cos_i
    pdf_sa = seen * cos_o * (n / length) ** 2 * np.where(mirrored, f, 1 - f)
    masking = 2 * np.abs(wo[:, 2]) / (np.abs(wo[:, 2]) + stretched(alpha, wo))
    sensitive = np.where(mirrored, 1 / np.sqrt(np.abs(g2)), 1 / cos_o**2)
    return pdf_sa, masking * np.where(mirrored, 1, inverse**2), 1 + 1 / cos_i + sensitive


def glass_textbook(record, wi, wo):
    """Return the density by the equations of [Walter2007] as they stand, in float32."""
    alpha, wi, wo, eta, _ = (np.asarray(part, np.float32) for part in glass_terms(record, wi, wo))
    with np.errstate(all="ignore"):
        mirrored = wo[:, 2] > 0
        h = wi + np.where(mirrored, ONE, eta)[:, None] * wo
        h = h / np.sqrt((h * h).sum(1, keepdims=True))
        h = h * np.sign(h[:, 2:])
        cos_i, cos_o = (wi * h).sum(1), (wo * h).sum(1)
        cos_t = np.sqrt(np.maximum(ONE - (ONE - cos_i * cos_i) / (eta * eta), 0))
        f = (((cos_i - eta * cos_t) / (cos_i + eta * cos_t)) ** 2
             + ((eta * cos_i - cos_t) / (eta * cos_i + cos_t)) ** 2) / 2
        a2, cos2 = alpha * alpha, h[:, 2] * h[:, 2]
        d = a2 / (PI * (cos2 * (a2 - ONE) + ONE) ** 2)
        g1 = 2 / (ONE + np.sqrt(ONE + a2 * (ONE - wi[:, 2] ** 2) / wi[:, 2] ** 2))
        seen = d * g1 * cos_i / wi[:, 2]
        return np.where(mirrored, f * seen / (4 * cos_o),
                        (ONE - f) * seen * eta * eta * np.abs(cos_o) / (cos_i + eta * cos_o) ** 2)


def glass(side):
    """Return errors of densities over their condition; side(record, wi, wo)."""
    errors = []
    for record, wi, wo, _ in glass_samples():
        right, _, condition = glass_exact(record, wi, wo)
        errors.append(relative(side(record, wi, wo), right) / condition)
    return np.concatenate(errors)


def their_glass(record, wi, wo):
    """Return Mitsuba's density."""
    return theirs({"type": "roughdielectric", "int_ior": record.ior, "ext_ior": 1.0, "alpha": record.alpha,
                   "distribution": "ggx"}, wi, wo)[1]  # fmt: skip


@functools.cache
def their_samples():
    """Return [(record, wi, wo, weight)]: what Mitsuba makes of the same directions."""
    mi, found = mitsuba(), []
    draw = np.random.default_rng(70)
    for record, wi, wo, _ in glass_samples():
        plugin = mi.load_dict({"type": "roughdielectric", "int_ior": record.ior, "ext_ior": 1.0, "alpha": record.alpha,
                               "distribution": "ggx"})  # fmt: skip
        u = draw.random((3, len(wi)), np.float32)
        bs, weight = plugin.sample(mi.BSDFContext(), interaction(mi, wi), mi.Float(u[0]), mi.Point2f(u[1:]))
        alive = weight.numpy()[0] > 0
        found.append((record, wi[alive], bs.wo.numpy().T[alive], weight.numpy()[0][alive]))
    return found


def their_weights():
    """Return the relative errors of Mitsuba's weights by the directions it drew."""
    return np.concatenate([relative(weight, glass_exact(record, wi, wo)[1])
                           for record, wi, wo, weight in their_samples()])


CASES = (
    Case("rough metal at the peak, alpha 1e-4 to 1, cosines 1e-30 to 1", "relative", 16 * ULP,
         "D 8 roundings, each masking 3, and 2", lambda: metal(ours_metal), lambda: metal(metal_textbook),
         "F D G / (4 cos cos), D of the cosine", lambda: metal(their_metal)),
    Case("rough glass at the peak, alpha 1e-4 to 1, density", "over condition", 16 * ULP,
         "as of metal, and the two cosines", lambda: glass(lambda *pair: evaluated(*pair)[1]),
         lambda: glass(glass_textbook), "Walter's equations as they stand", lambda: glass(their_glass)),
    Case("rough glass, weights of what is drawn", "relative", 8 * ULP, "masking 3 roundings, the density's two uses 4",
         lambda: weights(lambda record, wi, wo, weight: weight), lambda: weights(quotient),
         "value over density, each by Walter's equations", their_weights),
)
