"""Parallelogram, seen from both sides.

As for a triangle, coordinates of the hit are dot products with dual edges: a = gu.(p - c) and b = gv.(p - c) with
gu = v x n / |n|^2, gv = n x u / |n|^2 and n = u x v run from -1/2 to 1/2. Neighbours overlap by EDGE_TOLERANCE.
"""

import drjit as dr

from renderer.core.backend import Vector2f
from renderer.core.numeric import EDGE_TOLERANCE
from renderer.core.records import Surface
from renderer.core.vectors import cross, dot, unit
from renderer.shapes.base import ShapeKind, edges, register, rounding

CENTER, NORMAL, ROUNDING, DUAL_U, DUAL_V = 0, 3, 6, 7, 10


def pack(shape, columns=None):
    """Return the middle, the unit normal, the rounding and the dual edges."""
    n = cross(shape.u, shape.v)
    scale = 1 / dot(n, n)
    dual_u = [scale * component for component in cross(shape.v, n)]
    dual_v = [scale * component for component in cross(n, shape.u)]
    reach = [0.5 * (abs(a) + abs(b)) for a, b in zip(shape.u, shape.v)]
    return [*shape.center, *unit(n), rounding(unit(n), reach), *dual_u, *dual_v]


def distance(row, ray):
    """Return whether the line meets the parallelogram, and where; a line within its plane gives infinity or NaN."""
    n = row.vector(NORMAL)
    to_middle = row.vector(CENTER) - ray.o
    t = dr.dot(n, to_middle) / dr.dot(n, ray.d)
    q = dr.fma(ray.d, t, -to_middle)
    reach = 0.5 + EDGE_TOLERANCE
    return (abs(dr.dot(row.vector(DUAL_U), q)) <= reach) & (abs(dr.dot(row.vector(DUAL_V), q)) <= reach), t


def surface(row, p):
    """Return p projected along the normal into the plane."""
    n = row.vector(NORMAL)
    return Surface(p - n * dr.dot(n, p - row.vector(CENTER)), n)


def texture_coordinates(row, surface):
    """Return the position from 0 to 1 along both edges."""
    q = surface.p - row.vector(CENTER)
    return Vector2f(0.5 + dr.dot(row.vector(DUAL_U), q), 0.5 + dr.dot(row.vector(DUAL_V), q))


def tangents(row, surface):
    """Return both edges."""
    return edges(row.vector(NORMAL), row.vector(DUAL_U), row.vector(DUAL_V))


def bounds(shape):
    """Return the box around the four corners."""
    reach = [0.5 * (abs(u) + abs(v)) for u, v in zip(shape.u, shape.v)]
    return [c - r for c, r in zip(shape.center, reach)], [c + r for c, r in zip(shape.center, reach)]


register(
    ShapeKind(
        "rectangle", pack, surface, texture_coordinates, tangents, distance=distance, bounds=bounds,
        directions=range(NORMAL, DUAL_V + 3),
    )
)
