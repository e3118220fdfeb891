"""All triangles of a scene's meshes, and of its `triangle` shapes where they are many, as shared vertices and corners.

A vertex has 4 words: its position and u; with normals or v it has 8: then also the normal and v. A triangle has 4: its
corners' vertices and its shape.
"""

from __future__ import annotations

import drjit as dr

from renderer.accel.watertight import Axes, barycentric
from renderer.core.backend import ArrayXf, ArrayXu, Float, UInt32, Vector2f, Vector3f
from renderer.core.numeric import EPSILON, TINY, greater, largest
from renderer.core.records import Surface
from renderer.shapes.base import derivatives

CORNER_WORDS = 4
PLAIN, FULL = 4, 8  # words of a vertex without and with normal and v
# How far a ray starts off the plane of its triangle, as [Pharr2023, sec. 6.8.1] but with less of the coordinates: those
# of a corner plus two parts of edges are rounded twice, and once when the point is moved.
POINT_ROUNDOFFS = 3.0
# Of the edges: a neighbour's corners are projected within 8 roundoffs of their distance (a difference, an orthonormal
# basis, three products). A point of the edge between them sees their mean: at most half of its length off, which the
# components of both edges that start at a corner are together at least.
EDGE_ROUNDOFFS = 4.0


class Triangles:
    """Triangles by number, from `first` on in the compiled order of primitives."""

    def __init__(self, vertices, corners, vertex_words, first, of_meshes, one_shape=False):
        """Hold evaluated arrays: `vertices` (Float, `vertex_words` each), `corners` (UInt32, 4 each).

        `of_meshes` tells whether some are a mesh's, so that a triangle's number is not its shape's,
        and `one_shape` whether all are of the shape with the number `first`.
        """
        self._one_shape = one_shape
        self.first, self.count, self.of_meshes = first, len(corners) // CORNER_WORDS, of_meshes
        self._vertices, self._corners, self._words = vertices, corners, vertex_words
        self.plain, self.as_in_records = vertex_words == PLAIN, False  # whether leaf records have all that surfaces are

    def hold(self, index):
        """Return whether a lane's primitive is one of these."""
        return (index >= self.first) & (index < self.first + self.count)

    def positions(self):
        """Return the positions of the three corners of all triangles (Vector3f, a lane a triangle)."""
        place = CORNER_WORDS * dr.arange(UInt32, self.count)
        vertices = (dr.gather(UInt32, self._corners, place + k) for k in range(3))
        return [
            Vector3f(*(dr.gather(Float, self._vertices, self._words * vertex + axis) for axis in range(3)))
            for vertex in vertices
        ]

    def corners(self, number, active):
        """Return the positions of the three corners of each active lane's triangle, by its number among these."""
        lanes = dr.width(number)
        vertices = dr.gather(ArrayXu, self._corners, number, active, shape=(CORNER_WORDS, lanes))
        words = (dr.gather(ArrayXf, self._vertices, vertices[k], active, shape=(self._words, lanes)) for k in range(3))
        return [Vector3f(corner[0], corner[1], corner[2]) for corner in words]

    def shapes(self):
        """Return the shape of all triangles (UInt32, a lane a triangle)."""
        return dr.gather(UInt32, self._corners, CORNER_WORDS * dr.arange(UInt32, self.count) + 3)

    def shape(self, index, active):
        """Return the shape of each active lane's triangle."""
        if self._one_shape:
            return UInt32(self.first)
        return dr.gather(UInt32, self._corners, CORNER_WORDS * (index - self.first) + 3, active)

    def surface(self, ray, index, active, with_uv, with_tangents=False):
        """Return the point where a ray meets its lane's triangle, as a mean of the corners."""
        lanes = max(dr.width(index), dr.width(ray))
        corners = dr.gather(ArrayXu, self._corners, index - self.first, active, shape=(CORNER_WORDS, lanes))
        words = [
            dr.gather(ArrayXf, self._vertices, corners[k], active, shape=(self._words, lanes)) for k in range(3)
        ]
        return self._surface(ray, words, with_uv, with_tangents)

    def plain_surface(self, ray, corners):
        """Return the point where a ray meets its lane's triangle, given the corners; of a plain mesh without uv."""
        return self._surface(ray, corners, False, False)

    def _surface(self, ray, words, with_uv, with_tangents):
        v = [Vector3f(*(vertex[axis] for axis in range(3))) for vertex in words]
        b1, b2 = barycentric(Axes.of(ray), *v)
        b0 = 1 - b1 - b2

        def mean(values):
            return dr.fma(values[0], b0, dr.fma(values[1], b1, values[2] * b2))

        e1, e2 = v[1] - v[0], v[2] - v[0]
        p = dr.fma(e1, b1, dr.fma(e2, b2, v[0]))
        n = dr.cross(e1, e2)
        n_geo = n * dr.rsqrt(greater(dr.squared_norm(n), Float(TINY)))
        size = [largest(Vector3f(*corners)) for corners in zip(*v)]
        rounding = dr.dot(abs(n_geo), Vector3f(*size)) * Float(POINT_ROUNDOFFS * EPSILON)
        rounding += dr.sum(abs(e1) + abs(e2)) * Float(EDGE_ROUNDOFFS * EPSILON)
        found = Surface(p, n_geo, rounding=rounding, n_smooth=n_geo)
        if not self.plain:
            smooth = mean([Vector3f(vertex[4], vertex[5], vertex[6]) for vertex in words])
            length = dr.squared_norm(smooth)
            found.n_smooth = dr.select(length > TINY, smooth * dr.rsqrt(greater(length, Float(TINY))), n_geo)
        asked = with_uv or with_tangents
        uv = [Vector2f(vertex[3], vertex[7]) for vertex in words] if asked and not self.plain else None
        if with_uv:
            found.uv = mean(uv) if uv else Vector2f(b1, b2)
        if with_tangents:
            found.dp_du, found.dp_dv = derivatives(e1, e2, uv[1] - uv[0], uv[2] - uv[0]) if uv else (e1, e2)
        return found
