"""Parallelogram, seen from both sides.

As for a triangle, coordinates of the hit are dot products with dual edges: a = gu.(p - c) and b = gv.(p - c) with
gu = v x n / |n|^2, gv = n x u / |n|^2 and n = u x v run from -1/2 to 1/2. Neighbours overlap by EDGE_TOLERANCE.
"""

import drjit as dr

from renderer.core.backend import Vector2f
from renderer.core.numeric import EDGE_TOLERANCE
from renderer.core.vectors import box_around, unit
from renderer.shapes.base import ShapeKind, dual_edges, edges, onto_plane, register, rounding, to_plane

CENTER, NORMAL, ROUNDING, DUAL_U, DUAL_V = 0, 3, 6, 7, 10


def pack(shape, columns=None):
    """Return the middle, the unit normal, the rounding and the dual edges."""
    n, dual_u, dual_v = dual_edges(shape.u, shape.v)
    return [*shape.center, *unit(n), rounding(unit(n), _reach(shape)), *dual_u, *dual_v]


def _reach(shape):
    """Return how far the parallelogram reaches from its middle along each axis."""
    return [0.5 * (abs(u) + abs(v)) for u, v in zip(shape.u, shape.v)]


def distance(row, ray):
    """Return whether the line meets the parallelogram, and where; a line within its plane gives infinity or NaN."""
    to_middle, t = to_plane(row, ray)
    q = dr.fma(ray.d, t, -to_middle)
    reach = 0.5 + EDGE_TOLERANCE
    return (abs(dr.dot(row.vector(DUAL_U), q)) <= reach) & (abs(dr.dot(row.vector(DUAL_V), q)) <= reach), t


def texture_coordinates(row, surface):
    """Return the position from 0 to 1 along both edges."""
    q = surface.p - row.vector(CENTER)
    return Vector2f(0.5 + dr.dot(row.vector(DUAL_U), q), 0.5 + dr.dot(row.vector(DUAL_V), q))


def tangents(row, surface):
    """Return both edges."""
    return edges(row.vector(NORMAL), row.vector(DUAL_U), row.vector(DUAL_V))


def bounds(shape):
    """Return the corners of the box around the four corners."""
    return box_around(shape.center, _reach(shape))


register(
    ShapeKind(
        "rectangle", pack, onto_plane, texture_coordinates, tangents, distance=distance, bounds=bounds,
        directions=range(NORMAL, DUAL_V + 3),
    )
)
