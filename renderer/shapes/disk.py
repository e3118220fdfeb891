"""Disk, seen from both sides."""

import drjit as dr

from renderer.core.backend import Vector2f
from renderer.core.vectors import box_around, disk_reach, frame, unit
from renderer.shapes.base import ShapeKind, onto_plane, polar_tangents, register, rounding, to_plane, turn

CENTER, NORMAL, ROUNDING, TANGENT, BITANGENT, RADIUS = 0, 3, 6, 7, 10, 13


def pack(shape, columns=None):
    """Return the middle, the unit normal, the rounding, the normal's two tangents, and the radius."""
    normal = unit(shape.normal)
    tangent, bitangent = frame(normal)
    off_plane = rounding(normal, disk_reach(normal, shape.radius))
    return [*shape.center, *normal, off_plane, *tangent, *bitangent, shape.radius]


def distance(row, ray):
    """Return whether the line meets the disk, and where; a line within its plane gives infinity or NaN."""
    to_middle, t = to_plane(row, ray)
    return dr.squared_norm(dr.fma(ray.d, t, -to_middle)) <= dr.square(row[RADIUS]), t


def texture_coordinates(row, surface):
    """Return the angle in turns, as on a cylinder's upper cap, and the distance from the middle over the radius."""
    q = surface.p - row.vector(CENTER)
    return Vector2f(turn(-dr.dot(q, row.vector(BITANGENT)), dr.dot(q, row.vector(TANGENT))), dr.norm(q) / row[RADIUS])


def tangents(row, surface):
    """Return the derivatives by the angle in turns and by the distance from the middle over the radius."""
    return polar_tangents(surface.p - row.vector(CENTER), row.vector(NORMAL), row.vector(TANGENT), row[RADIUS])


def bounds(shape):
    """Return the corners of the box around the rim."""
    return box_around(shape.center, disk_reach(unit(shape.normal), shape.radius))


register(
    ShapeKind(
        "disk", pack, onto_plane, texture_coordinates, tangents, distance=distance, bounds=bounds,
        directions=range(NORMAL, RADIUS),
    )
)
