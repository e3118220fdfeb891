"""Infinite plane, seen from both sides."""

import drjit as dr

from renderer.core.backend import Bool, Vector2f
from renderer.core.records import Surface
from renderer.core.vectors import frame, unit
from renderer.shapes.base import ShapeKind, register, rounding

POINT, NORMAL, ROUNDING, TANGENT, BITANGENT = 0, 3, 6, 7, 10


def pack(shape, columns=None):
    """Return the point, the unit normal, the rounding for the world's origin, and the two axes of the texture."""
    normal = unit(shape.normal)
    tangent, bitangent = frame(normal)
    return [*shape.point, *normal, rounding(normal, map(abs, shape.point)), *tangent, *bitangent]


def distance(row, ray):
    """Return True, and the distance to the plane along the line: infinite or NaN for a line within it."""
    n = row.vector(NORMAL)
    return Bool(True), dr.dot(n, row.vector(POINT) - ray.o) / dr.dot(n, ray.d)


def surface(row, p):
    """Return p projected along the normal into the plane."""
    n = row.vector(NORMAL)
    return Surface(p - n * dr.dot(n, p - row.vector(POINT)), n)


def texture_coordinates(row, surface):
    """Return the distances from the point along the plane's two axes."""
    q = surface.p - row.vector(POINT)
    return Vector2f(dr.dot(q, row.vector(TANGENT)), dr.dot(q, row.vector(BITANGENT)))


def tangents(row, surface):
    """Return the plane's two axes."""
    return row.vector(TANGENT), row.vector(BITANGENT)


register(
    ShapeKind(
        "plane", pack, surface, texture_coordinates, tangents, distance=distance,
        directions=range(NORMAL, BITANGENT + 3),
    )
)
