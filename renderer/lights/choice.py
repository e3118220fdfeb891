"""Which of several lights a point samples: with a probability that follows what the light may bring there.

Each light has an estimate of the irradiance that it brings: strength / max(d^2, least) with the squared distance d^2
from its middle, where strength is intensity or radiance times area, and `least` bounds it near the light; nothing
behind lights that shine forwards only, or outside of a cone; and a constant for lights infinitely far away. The
estimates of a few lights are computed for every point; the probability of a light is its share of their sum.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float, UInt32
from renderer.core.numeric import TINY, greater
from renderer.core.rows import Rows

CENTER, STRENGTH, LEAST, AXIS, GATE, CONSTANT = 0, 3, 4, 5, 8, 9  # columns
NO_GATE = -2.0  # below every cosine


@dataclass(frozen=True)
class Estimate:
    """What a light may bring to a point; see the module docstring. Host."""

    center: tuple = (0.0, 0.0, 0.0)
    strength: float = 0.0  # luminance times scene units^2
    least: float = 0.0  # scene units^2
    axis: tuple = (0.0, 0.0, 1.0)  # unit
    gate: float = NO_GATE  # cosine to the axis, seen from the centre, up to which there is no light
    constant: float = 0.0  # luminance


@dataclass
class Chosen:
    """The light of each lane: the last one whose mask is true, else the first."""

    masks: list  # of the lights from the second on
    probability: Float  # 0 where there is no light
    u: Float  # what is left of the random number, even in [0, 1)

    def row(self, rows, first):
        """Return the record of each lane's light among a group's, which are numbered from `first` on."""
        return rows.chosen(self.masks[first : first + rows.count - 1])

    def within(self, first, count):
        """Return where the lane's light is one of a group's, or of a later group's."""
        here = self.masks[first - 1]
        for mask in self.masks[first : first + count - 1]:
            here = here | mask
        return here


class FewLights:
    """A choice among lights whose estimates are all computed for each point."""

    def __init__(self, estimates):
        self.count = len(estimates)
        self._rows = Rows([[*e.center, e.strength, e.least, *e.axis, e.gate, e.constant] for e in estimates])
        self._estimates = estimates

    def choose(self, p, u):
        """Return the Chosen light of each point."""
        if self.count == 1:
            return Chosen([], Float(1), u)
        weights = [self._weight(k, p) for k in range(self.count)]
        total = sum(weights[1:], start=weights[0])
        target, before = u * total, Float(0)
        weight, start, masks = weights[0], Float(0), []
        for previous, this in zip(weights, weights[1:]):
            before = before + previous
            beyond = (target >= before) & (this > 0)
            weight, start = dr.select(beyond, this, weight), dr.select(beyond, before, start)
            masks.append(beyond)
        some = weight > 0
        left = (target - start) / dr.select(some, weight, 1)
        return Chosen(masks, dr.select(some, weight / total, 0), dr.select(left < 1, left, 0))

    def probability(self, p, masks):
        """Return the probability with which p chooses a light, where `masks[k]` is true for light k (None: nowhere)."""
        if self.count == 1:
            return Float(1)
        weights = [self._weight(k, p) for k in range(self.count)]
        total, weight = sum(weights[1:], start=weights[0]), Float(0)
        for mask, own in zip(masks, weights):
            if mask is not None:
                weight = dr.select(mask, own, weight)
        return weight / greater(total, Float(TINY))

    def _weight(self, k, p):
        """Return the estimate of one light at a point."""
        row, estimate = self._rows[k], self._estimates[k]
        if not estimate.strength:
            return row[CONSTANT]
        offset = p - row.vector(CENTER)
        squared = dr.squared_norm(offset)
        weight = row[STRENGTH] * dr.rcp(greater(squared, row[LEAST]))
        if estimate.gate == NO_GATE:
            return weight
        along = dr.dot(offset, row.vector(AXIS))
        return dr.select(along > row[GATE] * dr.sqrt(squared), weight, 0)
