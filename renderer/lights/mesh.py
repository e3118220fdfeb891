"""Shining meshes of path-traced scenes: each is one light, with points spread evenly over all its triangles.

A triangle is chosen by its area from an alias table. Light goes to the side that the normals of the triangles show.
"""

import drjit as dr

from renderer.core.backend import Bool, Float, UInt32
from renderer.core.numeric import LEAST_NORMAL, TINY, greater, largest
from renderer.core.rows import Rows
from renderer.core.warp import square_to_triangle
from renderer.lights.base import towards

RADIANCE, INVERSE_AREA = 0, 3
TABLE, BITS, TRIANGLE = range(3)  # first place of its table, size of that, first triangle


class MeshLights:
    """All meshes that are sampled; those lights are numbered from `first` on."""

    def __init__(self, triangles, meshes, first):
        """Hold Triangles, and for each mesh its first triangle, (N,) areas of its triangles, and radiance."""
        from renderer.core.distribution import AliasTables

        self.first, self.count, self._triangles = first, len(meshes), triangles
        self._alias, tables, bits = AliasTables.of([areas[None] for _, areas, _ in meshes])
        self._rows = Rows([[*radiance, 1 / float(areas.sum())] for _, areas, radiance in meshes])
        places = zip(tables, bits, (triangle for triangle, _, _ in meshes))
        self._places = Rows([[*place] for place in places], UInt32)

    def direct(self, chosen, p, u2):
        """Return the DirectSample of each lane whose light is one of these."""
        row, place = chosen.row(self._rows, self.first), chosen.row(self._places, self.first)
        number, left = self._alias.choose(chosen.u, u2.x, place[TABLE], place[BITS])
        v0, v1, v2 = self._triangles.corners(number + place[TRIANGLE], chosen.within(self.first, self.count))
        e1, e2 = v1 - v0, v2 - v0
        u2.x = left
        b = square_to_triangle(u2)
        normal = dr.cross(e1, e2)
        normal *= dr.rcp(greater(largest(normal), Float(LEAST_NORMAL)))  # small triangles' squares would vanish
        normal *= dr.rsqrt(greater(dr.squared_norm(normal), Float(TINY)))
        q = dr.fma(e1, b.x, dr.fma(e2, b.y, v0))
        return towards(q, normal, p, row.vector(RADIANCE), row[INVERSE_AREA], Bool(False))
