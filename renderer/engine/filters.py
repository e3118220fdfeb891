"""Reconstruction filters, by drawing each pixel's samples where its filter has weight [Ernst2006].

A pixel's samples are distributed over the filter's support with the density |f| / integral of |f|, and count with the
sign of f. Pixels share no sample, so there are no atomic additions: the same bytes come from any number of threads. The
filters are products of one function of x and y each, and these are Mitsuba's: tent of radius 1, Gaussian of standard
deviation 0.5 lowered to 0 at radius 2, cubic with B = C = 1/3 and radius 2 [Mitchell1988].
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float, UInt32, Vector2f
from renderer.core.numeric import lesser

DEVIATION, RADIUS = 0.5, 2.0  # pixels
KNOTS = 512  # of an inverse distribution; the last piece stands for 1 / KNOTS^2 of the samples
STEPS = 32 * KNOTS  # of the sum over one half of a filter


def tent(x):
    """Return the tent of radius 1."""
    return max(0.0, 1 - abs(x))


def gaussian(x):
    """Return the Gaussian, lowered to 0 at its radius."""
    lowest = math.exp(-0.5 * (RADIUS / DEVIATION) ** 2)
    return max(0.0, math.exp(-0.5 * (x / DEVIATION) ** 2) - lowest)


def mitchell(x):
    """Return the cubic with B = C = 1/3 [Mitchell1988, eq. 8]."""
    x = abs(x)
    if x >= RADIUS:
        return 0.0
    if x < 1:
        return (7 * x**3 - 12 * x**2 + 16 / 3) / 6
    return (-7 / 3 * x**3 + 12 * x**2 - 20 * x + 32 / 3) / 6


MITCHELL_ROOT = 8 / 7  # -7 x^3 + 36 x^2 - 60 x + 32 = -(x - 2)^2 (7 x - 8)


def inverse_distribution(function, radius):
    """Return KNOTS + 1 places from 0 to `radius`; beyond knot k lies (1 - k / KNOTS)^2 of the integral of |function|.

    Filters vanish at their radius, so that places are about linear in k there, where equal shares would be far apart.
    """
    width = radius / STEPS
    total, sums = 0.0, []
    for k in range(STEPS):
        total += abs(function((k + 0.5) * width))
        sums.append(total)
    places, k = [0.0], 0
    for knot in range(1, KNOTS):
        wanted = total * (1 - (1 - knot / KNOTS) ** 2)
        while sums[k] < wanted:
            k += 1
        inside = abs(function((k + 0.5) * width))
        places.append((k + 1 - (sums[k] - wanted) / inside) * width)
    return [*places, radius]


@dataclass
class Offset:
    """Where a sample lies, from the top left corner of its pixel, and whether it counts negatively."""

    position: Vector2f
    negative: object = None  # mask; None for filters that are nowhere negative


class Box:
    """All points of the pixel count alike."""

    signed = False

    def offset(self, u2):
        """Return the Offset for a pair of numbers in [0, 1)."""
        return Offset(u2)


class Tent(Box):
    """See `tent`."""

    def offset(self, u2):
        """Return the Offset for a pair of numbers in [0, 1): the inverse distribution is a square root."""
        return Offset(Vector2f(*(0.5 + dr.select(u < 0.5, dr.sqrt(2 * u) - 1, 1 - dr.sqrt(2 - 2 * u)) for u in u2)))


class Tabulated(Box):
    """A filter of radius RADIUS whose inverse distribution is a table, with straight lines between its knots."""

    def __init__(self, function, root=RADIUS):
        places = inverse_distribution(function, RADIUS)
        # place and width of a piece side by side: one gather of both
        self._table = Float([value for a, b in zip(places, places[1:]) for value in (a, b - a)])
        dr.eval(self._table)
        self._root, self.signed = root, root < RADIUS

    def offset(self, u2):
        """Return the Offset for a pair of numbers in [0, 1)."""
        x, y = (self._signed_place(u) for u in u2)
        negative = (abs(x) > self._root) != (abs(y) > self._root) if self.signed else None
        return Offset(Vector2f(x + 0.5, y + 0.5), negative)

    def _signed_place(self, u):
        """Return a place in (-RADIUS, RADIUS), monotonic in u, so that evenly spread numbers give such places."""
        place = (1 - dr.sqrt(1 - abs(dr.fma(u, 2, -1)))) * KNOTS
        knot = lesser(UInt32(place), UInt32(KNOTS - 1))
        piece = dr.gather(Vector2f, self._table, knot)
        return dr.mulsign(dr.fma(place - Float(knot), piece.y, piece.x), u - 0.5)


FILTERS = {
    "box": Box, "tent": Tent, "gaussian": lambda: Tabulated(gaussian),
    "mitchell": lambda: Tabulated(mitchell, MITCHELL_ROOT),
}
