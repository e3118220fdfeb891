"""Local frames: z along the shading normal; cosines of local directions are their z."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float, Vector3f
from renderer.core.numeric import TINY, greater, largest


@dataclass
class Frame:
    """A right-handed orthonormal basis (t, b, n) in world space."""

    t: Vector3f
    b: Vector3f
    n: Vector3f

    @staticmethod
    def of(n):
        """Return the frame of a unit normal, with tangents of any direction [Duff2017, listing 3]."""
        sign = dr.select(n.z >= 0, Float(1), Float(-1))
        a = -dr.rcp(sign + n.z)
        b = n.x * n.y * a
        return Frame(
            Vector3f(1 + sign * dr.square(n.x) * a, sign * b, -sign * n.x),
            Vector3f(b, sign + dr.square(n.y) * a, -n.y),
            n,
        )

    @staticmethod
    def along(n, dp_du):
        """Return the frame of a unit normal with t as near to dp_du (of any length, not along n) as it can be.

        What dp_du has along n is taken off twice: where it is most of dp_du, rounding leaves some of it the first time.
        """
        t = dp_du * dr.rcp(greater(largest(dp_du), Float(TINY)))  # so that no square overflows or vanishes
        t -= n * dr.dot(n, t)
        t -= n * dr.dot(n, t)
        t *= dr.rsqrt(greater(dr.squared_norm(t), Float(TINY)))
        return Frame(t, dr.cross(n, t), n)

    def to_local(self, v):
        """Return a world vector in this frame."""
        return Vector3f(dr.dot(v, self.t), dr.dot(v, self.b), dr.dot(v, self.n))

    def to_world(self, v):
        """Return a local vector in the world."""
        return dr.fma(self.t, v.x, dr.fma(self.b, v.y, self.n * v.z))
