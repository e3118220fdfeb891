"""Weights of multiple importance sampling.

Densities per steradian span the whole of float32: a lamp that covers the sky has 1e-1, one of a micrometre a kilometre
away 1e18, the tail of a sharp highlight 1e-30. Their squares do not fit. Inputs are pairs of powers of ten from -37.9
to 38, half of them within three powers of each other; the sums have also 0, infinity, the greatest number and some that
are not normal with one another. The renderer takes what is below 2^-126 for that, so that pairs of which one is, and
the other hardly larger, are left out, as is infinity twice.
"""

import numpy as np

from renderer.core.backend import Float
from renderer.integrators.mis import power_heuristic
from tests.stability.case import ULP, Case, mitsuba

COUNT = 200_000
LEAST = 1e-30  # errors of weights below are relative to this: they count as nothing
NORMAL = 2.0**-126
SPECIAL = [0, 2.0**-149, 2.0**-127, 2.0**-126, 1e-30, 1e-19, 1, 1e19, 1e30, float.fromhex("0x1.fffffep127"), np.inf]


def densities(special):
    """Return pairs of densities, (2, N) float32."""
    rng = np.random.default_rng(1)
    exponent = rng.uniform(-37.9, 38, (2, COUNT))
    near = COUNT // 2
    exponent[1, :near] = np.clip(exponent[0, :near] + rng.uniform(-3, 3, near), -37.9, 38)
    pairs = (10.0**exponent).astype(np.float32)
    pairs[:, :100] = pairs[0, :100]  # equal ones
    if special:
        corners = np.meshgrid(*[np.array(SPECIAL, np.float32)] * 2)
        corners = np.stack(corners).reshape(2, -1)
        told = ((corners.min(axis=0) >= NORMAL) | (corners.max(axis=0) >= LEAST)) & (corners.min(axis=0) < np.inf)
        pairs = np.concatenate([pairs, corners[:, told]], axis=1)
    return pairs


def exact(a, b):
    """Return the weights of the first of two densities, both positive, in double precision."""
    return 1 / (1 + (b.astype(float) / a.astype(float)) ** 2)


def naive(a, b):
    """Return the textbook's weights."""
    with np.errstate(all="ignore"):
        return a**2 / (a**2 + b**2)


def ours(a, b):
    """Return the renderer's weights."""
    return power_heuristic(Float(a), Float(b)).numpy()


def mitsubas(a, b):
    """Return the weights of Mitsuba's integrators in Python."""
    mi = mitsuba()
    from mitsuba.ad.integrators.common import mis_weight  # only in a variant

    return mis_weight(mi.Float(a), mi.Float(b)).numpy()


def errors(weight):
    """Return a callable: relative errors of the weights by a function."""

    def measure():
        a, b = densities(False)
        wanted = exact(a, b)
        return (weight(a, b).astype(float) - wanted) / np.maximum(wanted, LEAST)

    return measure


def gaps(weight):
    """Return a callable: by how much the weights of both strategies, by a function, miss a sum of 1."""

    def measure():
        a, b = densities(True)
        return weight(a, b).astype(float) + weight(b, a) - 1

    return measure


CASES = (
    Case("MIS weights", "relative", 6 * ULP,
         "quotient, square, sum and reciprocal round once each, the first counts twice, and the reciprocal up to two",
         errors(ours), errors(naive), "a^2 / (a^2 + b^2)", errors(mitsubas)),
    Case("MIS weights of both strategies add up to 1", "1", 4.5 * ULP,
         "three roundings of the squared quotient move a weight by 3/4 of one at most, sum and reciprocal both by 3",
         gaps(ours), gaps(naive), "a^2 / (a^2 + b^2)", gaps(mitsubas), "sets what is not finite to 0 on both sides"),
)  # fmt: skip
