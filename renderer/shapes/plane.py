"""Infinite plane, seen from both sides."""

import drjit as dr

from renderer.core.backend import Bool, Vector2f
from renderer.core.vectors import frame, unit
from renderer.shapes.base import ShapeKind, onto_plane, register, rounding, to_plane

POINT, NORMAL, ROUNDING, TANGENT, BITANGENT = 0, 3, 6, 7, 10


def pack(shape, columns=None):
    """Return the point, the unit normal, the rounding for the world's origin, and the two axes of the texture."""
    normal = unit(shape.normal)
    tangent, bitangent = frame(normal)
    return [*shape.point, *normal, rounding(normal, map(abs, shape.point)), *tangent, *bitangent]


def distance(row, ray):
    """Return True, and the distance to the plane along the line: infinite or NaN for a line within it."""
    return Bool(True), to_plane(row, ray)[1]


def texture_coordinates(row, surface):
    """Return the distances from the point along the plane's two axes."""
    q = surface.p - row.vector(POINT)
    return Vector2f(dr.dot(q, row.vector(TANGENT)), dr.dot(q, row.vector(BITANGENT)))


def tangents(row, surface):
    """Return the plane's two axes."""
    return row.vector(TANGENT), row.vector(BITANGENT)


register(
    ShapeKind(
        "plane", pack, onto_plane, texture_coordinates, tangents, distance=distance,
        directions=range(NORMAL, BITANGENT + 3),
    )
)
