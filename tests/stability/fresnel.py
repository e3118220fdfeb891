"""Fresnel's equations.

The textbook's sqrt(1 - sin^2 / eta^2) cancels near the critical angle and, where the indices are nearly equal, at
grazing angles; so do the differences in its numerators. Cosines and indices are float32 numbers, and what is asked for
is the exact reflectance of just these.
"""

import numpy as np

from renderer.core.backend import Float, Vector3f
from renderer.core.fresnel import conductor, conductor_terms, dielectric
from tests.stability.case import ULP, Case, mitsuba, relative

ONE = np.float32(1)
GRAZING = np.geomspace(1e-7, 1, 2001)
ANGLES = np.concatenate([GRAZING, np.linspace(0, 1, 8001)[1:]]).astype(np.float32)
GLASSES = np.array([1.31, 1.5, 1.8, 2.4, 1 / 1.31, 1 / 1.5, 1 / 1.8, 1 / 2.4], np.float32)
NEAR = (1 + np.array([1e-3, 1e-4, 1e-5, 1e-6, -1e-6, -1e-5, -1e-4, -1e-3])).astype(np.float32)
METALS = {"gold": (0.143, 3.983), "silver": (0.0496, 4.484), "copper": (0.200, 3.913), "aluminium": (0.638, 5.516),
          "mercury": (2.076, 5.303), "perfect": (1e-3, 50.0)}  # (eta, k)  # fmt: skip
F_ROUNDINGS = 22 * ULP  # e, the two sums with g, their reciprocals and products, squared, and the mean
METAL_ROUNDINGS = 6 * ULP  # four products and quotients; what a carries counts little beside q


def grid(cosines, indices):
    """Return all pairs as two float32 arrays, without those of total reflection."""
    c, eta = (part.ravel() for part in np.meshgrid(cosines, indices, indexing="ij"))
    keep = square(c, eta) > 0
    return c[keep], eta[keep]


def square(c, eta):
    """Return (eta cos_t)^2 of float32 numbers in float64, exact where it is small beside 1."""
    c, eta = c.astype(float), eta.astype(float)
    return np.where(c > 0.7, (c * c - 1) + eta * eta, (eta * eta - 1) + c * c)


def exact(c, eta):
    """Return (F, cos_t) in float64."""
    g = np.sqrt(np.maximum(square(c, eta), 0))
    c, eta = c.astype(float), eta.astype(float)
    e = (eta - 1) * (eta + 1)
    r_s, r_p = e / (c + g) ** 2, e * (eta * eta * c * c - (1 - c * c)) / (eta * eta * c + g) ** 2
    return (r_s**2 + r_p**2) / 2, g / eta


def textbook(c, eta):
    """Return (F, cos_t) as textbooks have them, in float32."""
    with np.errstate(all="ignore"):
        sin2 = (ONE - c * c) / (eta * eta)
        cos_t = np.sqrt(np.maximum(ONE - sin2, 0))
        r_s = (c - eta * cos_t) / (c + eta * cos_t)
        r_p = (eta * c - cos_t) / (eta * c + cos_t)
    return np.where(sin2 >= 1, ONE, (r_s * r_s + r_p * r_p) / 2), cos_t


def ours(c, eta):
    """Return (F, cos_t) of the renderer."""
    return tuple(part.numpy() for part in dielectric(Float(c), Float(eta)))


def theirs(c, eta):
    """Return (F, cos_t) of Mitsuba, whose cosine has the sign of the other side."""
    mi = mitsuba()
    f, cos_t, _, _ = mi.fresnel(mi.Float(c), mi.Float(eta))
    return f.numpy(), np.abs(cos_t.numpy())


def errors(inputs, which=0):
    """Return for each side a function that returns relative errors of F (0) or cos_t (1)."""
    right = exact(*inputs)[which]
    return [lambda side=side: relative(side(*inputs)[which], right) for side in (ours, textbook, theirs)]


def critical():
    """Return cosines up to 64 float32 numbers from the critical angles of 500 indices below 1, and the indices."""
    eta = np.random.default_rng(31).uniform(0.4, 0.99, 500).astype(np.float32)
    at = np.sqrt(1 - eta.astype(float) ** 2).astype(np.float32)
    steps = np.concatenate([-np.arange(1, 65), [0], np.arange(1, 65)]).astype(np.int32)
    c = (at.view(np.int32)[:, None] + steps).view(np.float32)
    return c.ravel(), np.repeat(eta, len(steps))


def decided(side):
    """Return whether total reflection was found where there is none, or the other way round."""
    pairs = critical()
    return (side(*pairs)[1] > 0) != (square(*pairs) > 0)


def beyond_critical():
    """Return the pairs of `critical` without total reflection."""
    c, eta = critical()
    keep = square(c, eta) > 0
    return c[keep], eta[keep]


def metal_inputs():
    """Return cosines, and eta and k beside them."""
    eta, k = np.array(list(METALS.values())).T
    return np.repeat(ANGLES, len(eta)), np.tile(eta, len(ANGLES)), np.tile(k, len(ANGLES))


def absorbed(c, eta, k):
    """Return 1 - F of metals in float64, from transmittances, none of which is a difference of near numbers."""
    c = c.astype(float)
    d, s2 = eta * eta - k * k, 1 - c * c
    n = np.sqrt(d - s2 + 2j * eta * k)
    n = np.where(n.real < 0, -n, n)
    t_s = 4 * c * n.real / np.abs(c + n) ** 2
    index = (eta + 1j * k) ** 2
    t_p = 4 * c * (index * n.conj()).real / np.abs(index * c + n) ** 2
    return (t_s + t_p) / 2


def conductor_ours(c, eta, k):
    """Return F of the renderer."""
    terms = np.array([conductor_terms(a, b) for a, b in zip(eta[:len(METALS)], k[:len(METALS)])])
    d, p = (Float(np.tile(column, len(ANGLES)).astype(np.float32)) for column in terms.T)
    return conductor(Float(c), Vector3f(d), Vector3f(p)).x.numpy()


def conductor_textbook(c, eta, k):
    """Return F by the usual formula with a^2 + b^2 and a, in float32."""
    eta, k = eta.astype(np.float32), k.astype(np.float32)
    c2, s2 = c * c, ONE - c * c
    t0 = eta * eta - k * k - s2
    ab = np.sqrt(t0 * t0 + 4 * eta * eta * k * k)
    a = np.sqrt(np.maximum((ab + t0) / 2, 0))
    r_s = (ab + c2 - 2 * a * c) / (ab + c2 + 2 * a * c)
    r_p = r_s * (c2 * ab + s2 * s2 - 2 * a * c * s2) / (c2 * ab + s2 * s2 + 2 * a * c * s2)
    return (r_s + r_p) / 2


def conductor_theirs(c, eta, k):
    """Return F of Mitsuba."""
    mi = mitsuba()
    return mi.fresnel_conductor(mi.Float(c), mi.Complex2f(mi.Float(eta.astype(np.float32)),
                                                          mi.Float(k.astype(np.float32)))).numpy()


METAL_SIDES = conductor_ours, conductor_textbook, conductor_theirs


def metal_errors():
    """Return for each side a function that returns relative errors of F."""
    inputs = metal_inputs()
    right = 1 - absorbed(*inputs)
    return [lambda side=side: relative(side(*inputs), right)
            for side in METAL_SIDES]


def bounced(side):
    """Return the relative errors of F^100: what a hundred bounces between metal mirrors leave."""
    inputs = metal_inputs()
    kept = np.log1p(-absorbed(*inputs))
    return np.expm1(100 * (np.log(np.maximum(side(*inputs).astype(float), 1e-300)) - kept))


def spread(sides):
    """Return the three callables as the keywords of a Case."""
    return dict(zip(("ours", "naive", "mitsuba"), sides))


TEXTBOOK = "cos_t = sqrt(1 - sin^2 / eta^2), r = (a - b) / (a + b)"
CASES = (
    Case("Fresnel, all angles, glass", "relative", F_ROUNDINGS, "22 roundings", naive_name=TEXTBOOK,
         **spread(errors(grid(ANGLES, GLASSES)))),
    Case("Fresnel, index within 1e-3 to 1e-6 of 1", "relative", F_ROUNDINGS, "22 roundings", naive_name=TEXTBOOK,
         **spread(errors(grid(ANGLES, NEAR)))),
    Case("refracted cosine, index within 1e-3 to 1e-6 of 1", "relative", 4 * ULP, "squares, root and quotient",
         naive_name=TEXTBOOK, **spread(errors(grid(ANGLES, NEAR), 1))),
    Case("Fresnel, up to 64 ulps from the critical angle", "relative", F_ROUNDINGS + 19 * ULP,
         "22 roundings, and 3 / eta^2 <= 19 of eta^2 cos^2 - sin^2, which is eta^4 there",
         naive_name=TEXTBOOK, **spread(errors(beyond_critical()))),
    Case("refracted cosine, up to 64 ulps from the critical angle", "relative", 2.0**-16,
         "the square, above 2^-33 in these inputs, is known to 2^-48", naive_name=TEXTBOOK,
         **spread(errors(beyond_critical(), 1))),
    Case("total reflection decided, up to 64 ulps from the critical angle", "share", 0.0,
         "both squares carry what rounding cuts off", naive_name=TEXTBOOK,
         **spread([lambda side=side: decided(side) for side in (ours, textbook, theirs)])),
    Case("metals, all angles", "relative", METAL_ROUNDINGS, "6 roundings", naive_name="a^2 = (q + Re n^2 - sin^2) / 2",
         **spread(metal_errors())),
    Case("metals, what 100 bounces leave", "relative", 100 * METAL_ROUNDINGS, "100 times 6 roundings",
         naive_name="a^2 = (q + Re n^2 - sin^2) / 2",
         **spread([lambda side=side: bounced(side) for side in METAL_SIDES])),
)
