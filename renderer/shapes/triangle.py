"""Triangle, seen from both sides.

The plane is intersected first; barycentric coordinates of the hit are dot products with the dual edges,
b1 = g1.(p - v0) and b2 = g2.(p - v0) with g1 = e2 x n / |n|^2, g2 = n x e1 / |n|^2 and n = e1 x e2, computed once in
double precision. Neighbours overlap by EDGE_TOLERANCE, so that no ray slips through a shared edge.
"""

import drjit as dr

from renderer.core.backend import Vector2f
from renderer.core.numeric import EDGE_TOLERANCE
from renderer.core.vectors import subtract, unit
from renderer.shapes.base import ShapeKind, derivatives, dual_edges, edges, onto_plane, register, rounding, to_plane

V0, NORMAL, ROUNDING, DUAL1, DUAL2, UV0, UV1, UV2 = 0, 3, 6, 7, 10, 13, 15, 17


def pack(shape, columns=None):
    """Return v0, unit normal, rounding, dual edges, and the corners' texture coordinates."""
    e1 = subtract(shape.v1, shape.v0)
    e2 = subtract(shape.v2, shape.v0)
    n, dual1, dual2 = dual_edges(e1, e2)
    corners = (*shape.uv0, *shape.uv1, *shape.uv2)
    reach = [max(abs(a), abs(b)) for a, b in zip(e1, e2)]
    return [*shape.v0, *unit(n), rounding(unit(n), reach), *dual1, *dual2, *corners]


def distance(row, ray):
    """Return whether the line meets the triangle, and at which distance.

    A line within the plane divides by zero; t is infinite or NaN then, and fails the comparisons.
    """
    to_corner, t = to_plane(row, ray)
    q = dr.fma(ray.d, t, -to_corner)
    b1, b2 = dr.dot(row.vector(DUAL1), q), dr.dot(row.vector(DUAL2), q)
    return (b1 >= -EDGE_TOLERANCE) & (b2 >= -EDGE_TOLERANCE) & (b1 + b2 <= 1 + EDGE_TOLERANCE), t


def texture_coordinates(row, surface):
    """Return the barycentric mean of the corners' coordinates."""
    q = surface.p - row.vector(V0)
    b1, b2 = dr.dot(row.vector(DUAL1), q), dr.dot(row.vector(DUAL2), q)
    return Vector2f(*(row[UV0 + k] * (1 - b1 - b2) + row[UV1 + k] * b1 + row[UV2 + k] * b2 for k in range(2)))


def tangents(row, surface):
    """Return the derivatives by the coordinates of the corners."""
    e1, e2 = edges(row.vector(NORMAL), row.vector(DUAL1), row.vector(DUAL2))
    (du1, dv1), (du2, dv2) = ([row[uv + k] - row[UV0 + k] for k in range(2)] for uv in (UV1, UV2))
    return derivatives(e1, e2, Vector2f(du1, dv1), Vector2f(du2, dv2))


def bounds(shape):
    """Return the box around the corners."""
    axes = [*zip(shape.v0, shape.v1, shape.v2)]
    return [min(axis) for axis in axes], [max(axis) for axis in axes]


register(
    ShapeKind(
        "triangle", pack, onto_plane, texture_coordinates, tangents, distance=distance, bounds=bounds,
        directions=range(NORMAL, UV0),
    )
)
