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


@dataclass
class Slabs:
    """What box tests need of a ray."""

    o: Vector3f
    rate: Vector3f  # 1 / d, finite
    slack: Vector3f  # by which entries are earlier and exits later; distance along the ray
    negative: list  # for each axis, whether the ray runs down it

    @classmethod
    def of(cls, ray, reach):
        """Return the slabs of rays in a scene whose coordinates are at most `reach` (Float) in size."""
        rate = Vector3f(*(dr.rcp(away_from_zero(component)) for component in ray.d))
        o = abs(ray.o)
        rounding = (greater(o.x, greater(o.y, o.z)) + reach) * Float(BOX_ROUNDOFFS * EPSILON)
        return cls(ray.o, rate, abs(rate) * rounding, [component < 0 for component in rate])
