"""Microfacets: GGX and Beckmann down to roughness 1e-4, at grazing angles.

A lobe of width 1e-4 is lost where the cosine of its normals is looked at: float32 has one number for all of them.
Slopes tell them apart. At grazing angles the masking goes to 0 as the cosine that it is divided by.
"""

import functools

import numpy as np
from scipy.special import erf, erfinv

from renderer.bsdfs.microfacet import BECKMANN_U_MIN, Beckmann, Ggx
from renderer.core.backend import Float, Vector2f, Vector3f
from tests.stability.case import ULP, Case, mitsuba, relative

ALPHAS = 1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0
COUNT = 20_000  # inputs for each of ALPHAS
DECADES = 14.0  # Beckmann's exponents that count
ONE, PI = np.float32(1), np.float32(np.pi)


def lanes(v):
    """Return vectors (N, 3) as lanes."""
    return Vector3f(*np.ascontiguousarray(v.T, np.float32))


def unit(v):
    """Return float64 vectors (N, 3) of length 1."""
    return v / np.linalg.norm(v, axis=1, keepdims=True)


@functools.cache
def inputs():
    """Return float32 alpha (N), normals, directions of all cosines down to 1e-7 (N, 3), and pairs of numbers."""
    draw = np.random.default_rng(51)
    alpha = np.repeat(ALPHAS, COUNT).astype(np.float32)
    count = len(alpha)
    slope = np.minimum(alpha * np.sqrt(1 / draw.uniform(1e-6, 1, count) - 1), 1e3)
    phi = draw.uniform(0, 2 * np.pi, count)
    h = unit(np.c_[slope * np.cos(phi), slope * np.sin(phi), np.ones(count)])
    z = 10 ** draw.uniform(-7, 0, count)
    phi = draw.uniform(0, 2 * np.pi, count)
    sin = np.sqrt((1 - z) * (1 + z))
    v = np.c_[sin * np.cos(phi), sin * np.sin(phi), z]
    u = draw.integers(0, 2**24, (count, 2)) / 2**24
    ends = np.array([0, 2.0**-24, 2.0**-12, 0.5, 1 - 2.0**-12, 1 - 2.0**-24])
    u[::10, 0], u[::7, 1] = draw.choice(ends, len(u[::10])), draw.choice(ends, len(u[::7]))
    return alpha, h.astype(np.float32), v.astype(np.float32), u.astype(np.float32)


def slopes2(h):
    """Return the squared tangent of normals."""
    h = h.astype(float)
    return (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2


def density(kind, alpha, h):
    """Return D in float64."""
    alpha, tan2 = alpha.astype(float), slopes2(h)
    ratio = tan2 / alpha**2
    shape = 1 / (1 + ratio) ** 2 if kind is Ggx else np.exp(-ratio)
    return shape * (1 + tan2) ** 2 / (np.pi * alpha**2)


def made(kind, alpha):
    """Return the renderer's distribution."""
    alpha = Float(alpha)
    return Ggx(alpha, alpha) if kind is Ggx else Beckmann(alpha)


def density_textbook(kind, alpha, h):
    """Return D by the cosine of the normal, in float32."""
    a2, cos2 = alpha * alpha, h[:, 2] * h[:, 2]
    if kind is Ggx:
        with np.errstate(all="ignore"):
            return a2 / (PI * (cos2 * (a2 - ONE) + ONE) ** 2)
    return np.exp(-(ONE - cos2) / (cos2 * a2)) / (PI * a2 * cos2 * cos2)


def distribution(mi, kind, alpha):
    """Return Mitsuba's distribution of one alpha."""
    name = mi.MicrofacetType.GGX if kind is Ggx else mi.MicrofacetType.Beckmann
    return mi.MicrofacetDistribution(name, float(alpha), True)


def asked(kind, ask):
    """Return Mitsuba's answers: ask(distribution, its share of the inputs) for each alpha."""
    mi, parts = mitsuba(), []
    for k, alpha in enumerate(ALPHAS):
        share = [part[k * COUNT:(k + 1) * COUNT] for part in inputs()[1:]]
        parts.append(ask(mi, distribution(mi, kind, alpha), *share))
    return np.concatenate(parts)


def vectors(mi, v):
    """Return vectors (N, 3) as Mitsuba's lanes."""
    return mi.Vector3f(*(mi.Float(part) for part in np.ascontiguousarray(v.T, np.float32)))


def density_errors(kind):
    """Return three callables: relative errors of D, of Beckmann's where its exponent counts."""
    alpha, h, _, _ = inputs()
    counts = (slopes2(h) < DECADES * alpha.astype(float) ** 2) | (kind is Ggx)
    right = density(kind, alpha, h)

    def judge(side):
        return lambda: relative(side(), right)[counts]

    return (judge(lambda: made(kind, alpha).density(lanes(h)).numpy()),
            judge(lambda: density_textbook(kind, alpha, h)),
            judge(lambda: asked(kind, lambda mi, d, h, v, u: d.eval(vectors(mi, h)).numpy())))


def shadowing():
    """Return three callables: relative errors of GGX's G1(v) / v.z, v.z from 1e-7 to 1, and to 1e-30 in a third."""
    alpha, _, v, _ = inputs()
    v = v.copy()
    v[::3, 2] *= np.float32(1e-23)
    z, across2 = v[:, 2].astype(float), v[:, 0].astype(float) ** 2 + v[:, 1].astype(float) ** 2
    right = 2 / (z + np.sqrt(alpha.astype(float) ** 2 * across2 + z * z))

    def textbook():
        cos2 = v[:, 2] * v[:, 2]
        with np.errstate(all="ignore"):
            return 2 / (ONE + np.sqrt(ONE + alpha * alpha * (ONE - cos2) / cos2)) / v[:, 2]

    def theirs():
        mi, parts = mitsuba(), []
        for k, width in enumerate(ALPHAS):
            part = v[k * COUNT:(k + 1) * COUNT]
            g1 = distribution(mi, Ggx, width).smith_g1(vectors(mi, part), mi.Vector3f(0, 0, 1)).numpy()
            parts.append(g1 / part[:, 2])
        return np.concatenate(parts)

    return tuple(lambda side=side: relative(side(), right)
                 for side in (lambda: made(Ggx, alpha).visibility(lanes(v)).numpy(), textbook, theirs))


def visible(alpha, wi, u):
    """Return visible normals over (alpha, alpha, 1) in float64, and the size of what is added for them."""
    a, wi, u = alpha.astype(float), wi.astype(float), u.astype(float)
    across2 = a * a * (wi[:, 0] ** 2 + wi[:, 1] ** 2)
    length = np.sqrt(across2 + wi[:, 2] ** 2)
    z = wi[:, 2] / length
    height = (1 - u[:, 1]) * (1 + z)
    sin = np.sqrt(u[:, 1] * (height * (1 + z) + across2 / length**2))
    phi = 2 * np.pi * u[:, 0]
    stretched = a[:, None] * wi[:, :2] / length[:, None]
    h = np.c_[sin[:, None] * np.c_[np.cos(phi), np.sin(phi)] + stretched, height]
    return h, sin + np.sqrt(across2) / length


def visible_textbook(alpha, wi, u):
    """Return the same by the routine as published [Dupuy2023], in float32."""
    v = np.c_[alpha[:, None] * wi[:, :2], wi[:, 2]]
    v = v / np.sqrt((v * v).sum(1, keepdims=True))
    phi, z = 2 * PI * u[:, 0], (ONE - u[:, 1]) * (ONE + v[:, 2]) - v[:, 2]
    sin = np.sqrt(np.clip(ONE - z * z, 0, 1))
    return np.c_[sin * np.cos(phi), sin * np.sin(phi), z] + v


def drawn(alpha, wi, u):
    """Return the renderer's visible normals over (alpha, alpha, 1)."""
    h = made(Ggx, alpha).sample(lanes(wi), Vector2f(*np.ascontiguousarray(u.T))).numpy().T.astype(float)
    return np.c_[h[:, :2] / alpha[:, None], h[:, 2]]


def of_normals(side):
    """Return errors of the slopes of visible normals, relative to the terms of which they are sums."""
    alpha, _, wi, u = inputs()
    right, size = visible(alpha, wi, u)
    found = side(alpha, wi, u).astype(float)
    with np.errstate(all="ignore"):
        slopes = found[:, :2] / found[:, 2:] * right[:, 2:]
    return np.linalg.norm(slopes - right[:, :2], axis=1) / size


def of_slopes(side):
    """Return the errors of what share of Beckmann's visible slopes lies below those drawn, against the number u."""
    alpha, _, wi, u = inputs()
    h, a, v = side(alpha, wi, u).astype(float), alpha.astype(float), wi.astype(float)
    across = np.hypot(v[:, 0], v[:, 1])
    along = -(h[:, :2] * v[:, :2]).sum(1) / across / h[:, 2] / a
    tan = a * across / v[:, 2]

    def below(slope):
        return 1 + erf(slope) + tan / np.sqrt(np.pi) * np.exp(-slope * slope)

    return below(along) / below(1 / tan) - np.clip(u[:, 0].astype(float), BECKMANN_U_MIN, 1 - BECKMANN_U_MIN)


def beckmann(alpha, wi, u):
    """Return the renderer's visible normals of Beckmann's distribution."""
    return made(Beckmann, alpha).sample(lanes(wi), Vector2f(*np.ascontiguousarray(u.T))).numpy().T


def beckmann_textbook(alpha, wi, u):
    """Return the same by the published inversion [Jakob2014] with the angle of the stretched wi, in float32."""
    v = np.c_[alpha[:, None] * wi[:, :2], wi[:, 2]]
    v = v / np.sqrt((v * v).sum(1, keepdims=True))
    root_pi, u = np.float32(np.sqrt(np.pi)), np.clip(u, np.float32(BECKMANN_U_MIN), ONE - np.float32(BECKMANN_U_MIN))
    with np.errstate(all="ignore"):
        tan = np.sqrt(np.maximum(ONE - v[:, 2] * v[:, 2], 0)) / v[:, 2]
        top = erf(ONE / tan)
        x = top - (top + ONE) * erf(np.sqrt(-np.log(u[:, 0])))
        share = u[:, 0] * (ONE + top + tan / root_pi * np.exp(-ONE / (tan * tan)))
        for _ in range(3):
            slope = erfinv(x)
            x = x - (ONE + x + tan / root_pi * np.exp(-slope * slope) - share) / (ONE - slope * tan)
        along, across = erfinv(x), erfinv(2 * u[:, 1] - ONE)
    phi = np.arctan2(v[:, 1], v[:, 0])
    cos, sin = np.cos(phi), np.sin(phi)
    return np.c_[alpha * (sin * across - cos * along), -alpha * (sin * along + cos * across), np.ones_like(u[:, 0])]


def spread(sides):
    """Return the callables as the keywords of a Case."""
    return dict(zip(("ours", "naive", "mitsuba"), sides))


CASES = (
    Case("GGX, normals at alpha 1e-4 to 1", "relative", 12 * ULP, "12 roundings", naive_name="D of the cosine",
         **spread(density_errors(Ggx))),
    Case("Beckmann, normals at alpha 1e-4 to 1", "relative", (4 * DECADES + 8) * ULP,
         "an exponent up to 14 with 4 roundings, and 8", naive_name="D of the cosine",
         **spread(density_errors(Beckmann))),
    Case("masking over the cosine, cosines 1e-30 to 1", "relative", 6 * ULP, "6 roundings",
         naive_name="2 / (1 + sqrt(1 + alpha^2 tan^2)) / cos", **spread(shadowing())),
    Case("GGX, visible normals drawn", "of the terms", 8 * ULP, "sine and cosine to 3e-7, 3 roundings",
         lambda: of_normals(drawn), lambda: of_normals(visible_textbook), "sin = sqrt(1 - z^2), as published",
         remark="cannot be asked: its numbers lead to other normals"),
    Case("Beckmann, visible normals drawn", "share", 6e-6, "measured x2, where u is near 1 and erf^-1 steep",
         lambda: of_slopes(beckmann), lambda: of_slopes(beckmann_textbook), "tan by sqrt(1 - z^2) / z, as published",
         remark="cannot be asked: for wi near the normal it turns its slopes to another azimuth"),
)
