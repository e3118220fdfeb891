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
from renderer.core.numeric import EPSILON, FAR, away_from_zero, greater, largest, lesser

BOX_ROUNDOFFS = 32.0
MOST = 1e38


@dataclass
class Slabs:
    """What box tests need of a ray, or of a group of rays that share one walk.

    A group enters a slab where the first of its rays does and leaves it where the last one does: the extremes over its
    origins and its rates, of which only the least and the greatest are kept.
    """

    o: list  # [where the group enters slabs from, where it leaves them from], Vector3f; twice the same for one ray
    rates: list  # 1 / d, finite, Vector3f: of the ray, or the least and the greatest of the group
    slacks: list  # for each rate, by which entries are earlier and exits later; distance along the ray, Vector3f
    negative: list  # for each axis, whether the ray runs down it

    @property
    def valid(self):
        """Whether the ray is one: NaN would meet every box, and those that are not there."""
        parts = self.o[0] + self.rates[0]
        return abs(parts.x + parts.y + parts.z) <= MOST

    @classmethod
    def of(cls, ray, middle, radius):
        """Return the slabs of rays in a scene that reaches up to `radius` (Float) from `middle` along each axis."""
        rate = Vector3f(*(dr.rcp(away_from_zero(component)) for component in ray.d))
        rounding = (largest(ray.o - middle) + radius) * Float(BOX_ROUNDOFFS * EPSILON)
        return cls([ray.o, ray.o], [rate], [abs(rate) * rounding], [component < 0 for component in rate])

    @classmethod
    def of_group(cls, rays, middle, radius):
        """Return the slabs that hold those of several valid rays.

        Along an axis that some of them run up and some down, boxes do not restrict the group.
        """
        each = [cls.of(ray, middle, radius) for ray in rays]
        o, rates, slacks = [Vector3f(0), Vector3f(0)], [Vector3f(1), Vector3f(1)], [Vector3f(FAR), Vector3f(FAR)]
        for axis in range(3):
            least, most = (_extreme(choose, [one.rates[0][axis] for one in each]) for choose in (lesser, greater))
            slack = _extreme(greater, [one.slacks[0][axis] for one in each])
            first, last = (_extreme(choose, [ray.o[axis] for ray in rays]) for choose in (lesser, greater))
            agree, down = (least > 0) | (most < 0), most < 0
            # up an axis, what starts furthest along enters first; down it, what starts least far
            o[0][axis], o[1][axis] = dr.select(down, first, last), dr.select(down, last, first)
            for k, rate in enumerate((least, most)):
                rates[k][axis], slacks[k][axis] = dr.select(agree, rate, 1), dr.select(agree, slack, FAR)
        return cls(o, rates, slacks, [component < 0 for component in rates[0]])


def _extreme(choose, values):
    """Return the least or the greatest of several."""
    found = values[0]
    for value in values[1:]:
        found = choose(found, value)
    return found
