"""Which of several lights a point samples: with a probability that follows what the light may bring there.

Each light has an estimate of the irradiance that it brings: strength / max(d^2, least) with the squared distance d^2
from its middle, where strength is intensity or radiance times area, and `least` bounds it near the light; nothing
behind lights that shine forwards only, or outside of a cone; and a constant for lights infinitely far away. The
estimates of a few lights are computed for every point; the probability of a light is its share of their sum. For many
lights they are computed for the cells of a grid, and each cell has a table to choose from [Walker1977]. Of a thousand
lights that brings a quarter of the variance of a choice by power, and a seventh of that of an even one, in equal time.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.numeric import TINY, greater, lesser
from renderer.core.rows import Rows

CENTER, STRENGTH, LEAST, AXIS, GATE, CONSTANT = 0, 3, 4, 5, 8, 9  # columns
NO_GATE = -2.0  # below every cosine
FEW = 8  # lights whose estimates are computed for every point
MOST_CELLS = 4096  # of the grid
MOST_PLACES = 2**21  # of the tables of all cells together, at 12 bytes
BY_POWER = 0.1  # share of a cell's table that follows power alone


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
    u: Float  # what is left of two random numbers, even in [0, 1)
    v: Float

    def row(self, rows, first):
        """Return the record of each lane's light among a group's, which are numbered from `first` on."""
        return rows.chosen(self.masks[first : first + rows.count - 1])

    def within(self, first, count):
        """Return where the lane's light is one of a group's, or perhaps another's that comes before or after."""
        if first == 0:
            return Bool(True)
        here = self.masks[first - 1]
        for mask in self.masks[first : first + count - 1]:
            here = here | mask
        return here


@dataclass
class ChosenNumber:
    """The light of each lane by its number; otherwise like Chosen."""

    number: UInt32
    probability: Float
    u: Float
    v: Float

    def row(self, rows, first):
        """Return the record of each lane's light among a group's, which are numbered from `first` on."""
        return rows.row(self.number - first, self.within(first, rows.count))

    def within(self, first, count):
        """Return where the lane's light is one of a group's."""
        return (self.number >= first) & (self.number < first + count)


class FewLights:
    """A choice among lights whose estimates are all computed for each point."""

    def __init__(self, estimates):
        self.count = len(estimates)
        self._rows = Rows([[*e.center, e.strength, e.least, *e.axis, e.gate, e.constant] for e in estimates])
        self._estimates = estimates

    def choose(self, p, u, v):
        """Return the Chosen light of each point."""
        if self.count == 1:
            return Chosen([], Float(1), u, v)
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
        return Chosen(masks, dr.select(some, weight / total, 0), dr.select(left < 1, left, 0), v)

    def probability(self, p, light):
        """Return the probability with which p chooses each lane's Light."""
        if self.count == 1:
            return Float(1)
        weights = [self._weight(k, p) for k in range(self.count)]
        total, weight = sum(weights[1:], start=weights[0]), Float(0)
        for number, mask in light.masks.items():
            weight = dr.select(mask, weights[number], weight)
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


class ManyLights:
    """A choice among lights by tables of a grid's cells; points outside of the grid take its nearest cell.

    A share of each table follows the power of the lights alone, so that no light that a cell's estimate misses, as one
    may that shines through a gap, is chosen far too rarely.
    """

    def __init__(self, estimates, lowest, highest):
        """Make tables for a box (corners on the host) and Estimates."""
        import numpy as np

        from renderer.core.backend import from_host
        from renderer.core.distribution import AliasTables

        self.count = len(estimates)
        places = 1 << (self.count - 1).bit_length()
        size = np.maximum(np.subtract(highest, lowest), TINY)
        cells = _cells(size, min(MOST_CELLS, max(MOST_PLACES // places, 1)))
        middles = np.stack(np.meshgrid(*(l + s * (np.arange(n) + 0.5) / n for l, s, n in zip(lowest, size, cells)),
                                       indexing="ij"), axis=-1).reshape(-1, 3)  # fmt: skip
        weights = _cell_weights(estimates, middles, 0.5 * np.linalg.norm(size / cells))
        self._alias, _, (self._bits,) = AliasTables.of([weights])
        probabilities = weights / weights.sum(axis=1, keepdims=True)
        self._probabilities = from_host(Float, probabilities.astype(np.float32).ravel())
        self._lowest = Vector3f(*(dr.opaque(Float, float(x)) for x in lowest))
        self._scale = Vector3f(*(dr.opaque(Float, float(n / s)) for n, s in zip(cells, size)))
        self._cells = [dr.opaque(UInt32, int(n)) for n in cells]

    def choose(self, p, u, v):
        """Return the ChosenNumber of each point."""
        cell = self._cell(p)
        number, v = self._alias.choose(u, v, cell << self._bits, self._bits)
        probability = dr.gather(Float, self._probabilities, cell * self.count + number)
        left = u * 2.0**self._bits
        return ChosenNumber(number, probability, left - dr.floor(left), v)

    def probability(self, p, light):
        """Return the probability with which p chooses each lane's Light."""
        return dr.gather(Float, self._probabilities, self._cell(p) * self.count + light.number)

    def _cell(self, p):
        """Return the number of the cell of each point."""
        place = (p - self._lowest) * self._scale
        x, y, z = (UInt32(lesser(greater(at, Float(0)), Float(n) - 0.5)) for at, n in zip(place, self._cells))
        return (x * self._cells[1] + y) * self._cells[2] + z


def _cells(size, most):
    """Return the numbers of about cubic cells along the sides of a box, at most `most` together."""
    import numpy as np

    edge = (np.prod(np.maximum(size, size.max() * 1e-3)) / most) ** (1 / 3)
    cells = np.maximum(np.floor(size / edge), 1).astype(int)
    while np.prod(cells) > most:
        cells[np.argmax(cells)] -= 1
    return cells


def _cell_weights(estimates, middles, radius):
    """Return (cells, lights) weights of Estimates for cells with these middles (C, 3), which reach up to `radius`."""
    import numpy as np

    centers, axes = (np.array([getattr(e, name) for e in estimates], float) for name in ("center", "axis"))
    strength, least, gate, constant = (
        np.array([getattr(e, name) for e in estimates]) for name in ("strength", "least", "gate", "constant")
    )
    squared = np.zeros((len(middles), len(estimates)))
    along = np.zeros_like(squared)
    for axis in range(3):
        offset = middles[:, None, axis] - centers[None, :, axis]
        squared += offset**2
        along += offset * axes[None, :, axis]
    weights = strength / np.maximum(squared, np.maximum(least, radius**2)) + constant
    behind = (gate >= 0) & (along < -radius)
    power = strength / max(squared.mean(), radius**2) + constant
    weights = np.where(behind, 0, weights)
    total = weights.sum(axis=1, keepdims=True)
    weights = np.where(total > 0, weights / np.where(total > 0, total, 1), 0)
    return (1 - BY_POWER) * weights + BY_POWER * power / power.sum()
