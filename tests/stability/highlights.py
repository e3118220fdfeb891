"""Highlights of exponent 100,000.

Such a power of a cosine lives where float32 has five cosines between its peak and a half of it. What tells directions
apart there is the sine. Directions are those of float32 numbers; only those where the power is above 1e-6 count.
"""

import functools

import numpy as np

from renderer.bsdfs import coursework
from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.rows import Rows
from renderer.integrators.phong import highlight
from renderer.scene.materials import Material
from tests.stability.case import ULP, Case, relative

EXPONENT = 1e5
COUNT = 100_000
LEAST = 1e-6  # power that counts
DECADES = -np.log(LEAST)  # 14: relative errors of a logarithm count so many times
REACH = np.sqrt(2 * DECADES / EXPONENT)  # largest angle to the peak, 0.017
NO_PLUGIN = "it has no such material"
LOBE = Material(kd=0.0, ks=1.0, specularexponent=EXPONENT)


def unit(v):
    """Return float64 vectors (N, 3) of length 1."""
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def single(v):
    """Return vectors (N, 3) rounded to float32."""
    return np.ascontiguousarray(v, np.float32)


def lanes(v):
    """Return vectors (N, 3) as lanes."""
    return Vector3f(*np.ascontiguousarray(v.T))


@functools.cache
def around(upright):
    """Return float32 n, wi, wo with n up to REACH from half vectors; `upright`: n = z."""
    draw = np.random.default_rng(41)
    n = np.tile([0.0, 0.0, 1.0], (COUNT, 1)) if upright else unit(draw.normal(size=(COUNT, 3)))
    h = unit(n + draw.uniform(0, REACH, (COUNT, 1)) * unit(np.cross(n, draw.normal(size=(COUNT, 3)))))
    wi = unit(draw.normal(size=(COUNT, 3)))
    wi = np.where((wi * h).sum(1, keepdims=True) < 0, -wi, wi)
    wo = 2 * (wi * h).sum(1, keepdims=True) * h - wi
    keep = ((wi * n).sum(1) > 0.05) & ((wo * n).sum(1) > 0.05)
    return tuple(single(v[keep]) for v in (n, wi, wo))


def power(n, wi, wo):
    """Return (n.h)^EXPONENT in float64, by the sine of their angle."""
    n, h = unit(n.astype(float)), unit(wi.astype(float) + wo.astype(float))
    return np.exp(EXPONENT / 2 * np.log1p(-(np.cross(n, h) ** 2).sum(1)))


def textbook(n, wi, wo):
    """Return the power as it is usually written, in float32."""
    h = wi + wo
    h /= np.sqrt((h * h).sum(1, keepdims=True))
    return np.maximum((n * h).sum(1), 0) ** np.float32(EXPONENT)


def of_phong(side):
    """Return relative errors of the highlight of mode phong."""
    inputs = around(False)
    return relative(side(*inputs), power(*inputs))


def phong(n, wi, wo):
    """Return the highlight of mode phong."""
    return highlight(lanes(n), lanes(wi), lanes(wo), Float(EXPONENT)).numpy()


@functools.cache
def has():
    """Return the parameters of the lobe, and what it needs in the kernel."""
    return Rows([coursework.pack(LOBE, 1.0)])[0], frozenset(coursework.features(LOBE))


def peak():
    """Return the lobe's factor, as float32 has it."""
    return float(np.float32(coursework.pack(LOBE, 1.0)[coursework.LOBE]))


def of_lobe(side):
    """Return relative errors of the lobe's value times cosine, for directions in the local frame."""
    n, wi, wo = around(True)
    return relative(side(n, wi, wo), power(n, wi, wo) * peak() * wo[:, 2].astype(float))


def evaluated(n, wi, wo):
    """Return value times cosine of the coursework's material."""
    return coursework.evaluate(has()[0], lanes(wi), lanes(wo), has()[1])[0].x.numpy()


@functools.cache
def numbers():
    """Return float32 directions wi and pairs of random numbers; those that are drawn 1e-6 of the time do not count."""
    draw = np.random.default_rng(42)
    wi = unit(np.c_[draw.uniform(-1, 1, (COUNT, 2)), draw.uniform(0.6, 3, COUNT)])  # cosines from 0.39
    u = draw.integers(0, 2**24, (COUNT, 2)) / 2**24
    u[:, 1] = np.minimum(u[:, 1], 1 - LEAST)
    return single(wi), single(u)


def drawn(wi, u):
    """Return wo and its density, by the renderer."""
    count = len(wi)
    found = coursework.sample(has()[0], lanes(wi), Float(np.full(count, 0.5, np.float32)),
                              Vector2f(*np.ascontiguousarray(u.T)), has()[1])  # fmt: skip
    return found.wo.numpy().T, found.pdf_sa.numpy()


def drawn_textbook(wi, u):
    """Return wo and its density by cos = (1 - u)^(1 / (e + 1)), in float32."""
    one, e = np.float32(1), np.float32(EXPONENT)
    cos, phi = (one - u[:, 1]) ** (one / (e + one)), np.float32(2 * np.pi) * u[:, 0]
    sin = np.sqrt(np.maximum(one - cos * cos, 0))
    h = np.c_[sin * np.cos(phi), sin * np.sin(phi), cos]
    wo = 2 * (wi * h).sum(1, keepdims=True) * h - wi
    return wo, (e + one) / np.float32(2 * np.pi) * cos**e / (4 * (wi * h).sum(1))


def of_direction(side):
    """Return relative errors of (n.h)^(e + 1), which is 1 - u."""
    wi, u = numbers()
    wo = side(wi, u)[0]
    up = np.tile(np.float32([0, 0, 1]), (len(wi), 1))
    return relative(power(up, wi, wo) ** ((EXPONENT + 1) / EXPONENT), 1 - u[:, 1].astype(float))


def of_density(side):
    """Return relative errors of the density, (e + 1) / (2 pi) (n.h)^e / (4 wi.h), by the random number."""
    wi, u = numbers()
    wo, pdf_sa = side(wi, u)
    h = unit(wi.astype(float) + wo.astype(float))
    power = (1 - u[:, 1].astype(float)) ** (EXPONENT / (EXPONENT + 1))
    return relative(pdf_sa, (EXPONENT + 1) / (2 * np.pi) * power / (4 * (wi * h).sum(1)))


CASES = (
    Case("highlight of exponent 1e5, mode phong", "relative", EXPONENT * REACH * 5 * ULP,
         "e sin(angle) <= 1700 times the rounding of h, which is 5", lambda: of_phong(phong),
         lambda: of_phong(textbook), "max(0, n.h)^e", remark=NO_PLUGIN),
    Case("highlight of exponent 1e5, mode pathtracer", "relative", (8 * DECADES + 8) * ULP,
         "14 = -ln 1e-6 times the 8 roundings of sin^2 and its logarithm, and 8", lambda: of_lobe(evaluated),
         lambda: of_lobe(lambda n, wi, wo: textbook(n, wi, wo) * np.float32(peak()) * wo[:, 2]), "(n.h)^e",
         remark=NO_PLUGIN),
    Case("directions drawn from exponent 1e5", "relative", EXPONENT * REACH * 5 * ULP,
         "e sin(angle) <= 1700 times the rounding of wo, which is 5", lambda: of_direction(drawn),
         lambda: of_direction(drawn_textbook), "cos = (1 - u)^(1 / (e + 1))", remark=NO_PLUGIN),
    Case("densities of directions drawn from exponent 1e5", "relative", 20 * ULP,
         "10 roundings of (1 - u) / cos and factors, and 4 of the cosine with wi, which is 0.39 at the least",
         lambda: of_density(drawn), lambda: of_density(drawn_textbook), "the power of the rounded cosine",
         remark=NO_PLUGIN),
)
