"""Places of samples under reconstruction filters.

Samples are drawn with the density of a filter, by the inverse of its sums. Where the filter vanishes, at its rim, that
inverse is infinitely steep: a table of even steps is wrong there by tenths of a pixel. Random numbers are 100,000 and,
at both ends, those from 2^-24 on. The yardstick is the inverse of sums over a million pieces in double precision.
"""

import functools

import numpy as np

from renderer.core.backend import Vector2f
from renderer.engine.filters import FILTERS, RADIUS
from tests.stability.case import Case

KNOTS = 512
PIECES = 1_000_000
NAMES = "gaussian", "mitchell"


@functools.cache
def sums(name):
    """Return (PIECES + 1,) places from 0 to the filter's radius, and the share of its half that lies before each."""
    x = np.linspace(0, RADIUS, PIECES + 1)
    middle = 0.5 * (x[1:] + x[:-1])
    if name == "gaussian":
        density = np.maximum(np.exp(-2 * middle**2) - np.exp(-2 * RADIUS**2), 0)
    else:
        inner = np.polyval((7, -12, 0, 16 / 3), middle)
        outer = np.polyval((-7 / 3, 12, -20, 32 / 3), middle)
        density = abs(np.where(middle < 1, inner, outer))
    total = np.concatenate([[0], np.cumsum(density)])
    return x, total / total[-1]


def numbers():
    """Return random numbers (N,) float32."""
    rng = np.random.default_rng(1)
    ends = (10.0 ** rng.uniform(-7.2, -1, 50_000) * 2**24).round()
    steps = np.concatenate([rng.integers(0, 2**24, 50_000), ends, 2**24 - 1 - ends])
    return (steps * 2.0**-24).astype(np.float32)


def exact(name, u):
    """Return the exact places, from the middle of the pixel."""
    x, share = sums(name)
    wanted = abs(2 * u.astype(float) - 1)
    # the rest of the sum, not the sum, is interpolated, and by its root, which is about linear at the rim
    rest = np.sqrt(np.maximum(1 - share, 0))[::-1]
    return np.interp(np.sqrt(1 - wanted), rest, x[::-1]) * np.where(u < 0.5, -1, 1)


def errors(place):
    """Return a callable: errors of the places by a function, of both filters."""
    return lambda: np.concatenate([place(name, numbers()) - exact(name, numbers()) for name in NAMES])


def ours(name, u):
    """Return the renderer's places."""
    return FILTERS[name]().offset(Vector2f(u, u)).position.x.numpy() - np.float32(0.5)


def naive(name, u):
    """Return the places by a table of even steps."""
    x, share = sums(name)
    table = np.interp(np.linspace(0, 1, KNOTS + 1), share, x).astype(np.float32)
    place = np.abs(2 * u - 1) * np.float32(KNOTS)
    knot = np.minimum(place.astype(int), KNOTS - 1)
    return (table[knot] + (place - knot) * (table[knot + 1] - table[knot])) * np.where(u < 0.5, -1, 1)


CASES = (
    Case("places under the Gaussian and Mitchell's filter", "pixels", 0.02,
         "measured x 2, at the place where Mitchell's changes its sign and its density vanishes", errors(ours),
         errors(naive), f"a table of {KNOTS} even steps", None, "adds each sample to all pixels around instead"),
)  # fmt: skip
