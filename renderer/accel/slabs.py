"""Rays against boxes: the parts of three slabs that a line crosses [Kay1986], rounded so that no box is missed.

A leaf test may find a hit that lies outside of its box by the rounding of its own coordinates, which grows with the
distance between the ray's origin and the scene. So boxes are widened by BOX_ROUNDOFFS of that distance while they are
tested: a few times the error of a watertight triangle test (three products and sums of |v - o|, in each of three
axes), which also covers the rounding of the slabs themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float, Vector3f
from renderer.core.numeric import EPSILON, away_from_zero, greater

BOX_ROUNDOFFS = 32.0
MOST = 1e38


@dataclass
class Slabs:
    """What box tests need of a ray."""

    o: Vector3f
    rate: Vector3f  # 1 / d, finite
    slack: Vector3f  # by which entries are earlier and exits later; distance along the ray
    negative: list  # for each axis, whether the ray runs down it

    @property
    def valid(self):
        """Whether the ray is one: NaN would meet every box, and those that are not there."""
        parts = self.o + self.rate
        return abs(parts.x + parts.y + parts.z) <= MOST

    @classmethod
    def of(cls, ray, middle, radius):
        """Return the slabs of rays in a scene that reaches up to `radius` (Float) from `middle` along each axis."""
        rate = Vector3f(*(dr.rcp(away_from_zero(component)) for component in ray.d))
        away = abs(ray.o - middle)
        rounding = (greater(away.x, greater(away.y, away.z)) + radius) * Float(BOX_ROUNDOFFS * EPSILON)
        return cls(ray.o, rate, abs(rate) * rounding, [component < 0 for component in rate])
