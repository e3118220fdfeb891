"""Disk, seen from both sides."""

import math

import drjit as dr

from renderer.core.backend import Vector2f
from renderer.core.records import Surface
from renderer.core.vectors import frame, unit
from renderer.shapes.base import ShapeKind, polar_tangents, register, rounding, turn

CENTER, NORMAL, ROUNDING, TANGENT, BITANGENT, RADIUS = 0, 3, 6, 7, 10, 13


def pack(shape, columns=None):
    """Return the middle, the unit normal, the rounding, the normal's two tangents, and the radius."""
    normal = unit(shape.normal)
    tangent, bitangent = frame(normal)
    reach = [shape.radius * math.sqrt(max(0.0, 1 - n * n)) for n in normal]
    return [*shape.center, *normal, rounding(normal, reach), *tangent, *bitangent, shape.radius]


def distance(row, ray):
    """Return whether the line meets the disk, and where; a line within its plane gives infinity or NaN."""
    n = row.vector(NORMAL)
    to_middle = row.vector(CENTER) - ray.o
    t = dr.dot(n, to_middle) / dr.dot(n, ray.d)
    return dr.squared_norm(dr.fma(ray.d, t, -to_middle)) <= dr.square(row[RADIUS]), t


def surface(row, p):
    """Return p projected along the normal into the plane."""
    n = row.vector(NORMAL)
    return Surface(p - n * dr.dot(n, p - row.vector(CENTER)), n)


def texture_coordinates(row, surface):
    """Return the angle in turns, as on a cylinder's upper cap, and the distance from the middle over the radius."""
    q = surface.p - row.vector(CENTER)
    return Vector2f(turn(-dr.dot(q, row.vector(BITANGENT)), dr.dot(q, row.vector(TANGENT))), dr.norm(q) / row[RADIUS])


def tangents(row, surface):
    """Return the derivatives by the angle in turns and by the distance from the middle over the radius."""
    return polar_tangents(surface.p - row.vector(CENTER), row.vector(NORMAL), row.vector(TANGENT), row[RADIUS])


def bounds(shape):
    """Return the box around the rim, which reaches r sqrt(1 - n^2) along an axis with the normal's cosine n."""
    reach = [shape.radius * math.sqrt(max(0.0, 1 - n * n)) for n in unit(shape.normal)]
    return [c - r for c, r in zip(shape.center, reach)], [c + r for c, r in zip(shape.center, reach)]


register(
    ShapeKind(
        "disk", pack, surface, texture_coordinates, tangents, distance=distance, bounds=bounds,
        directions=range(NORMAL, RADIUS),
    )
)
