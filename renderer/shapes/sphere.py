"""Sphere.

The discriminant is taken from the ray's distance to the centre, r^2 - |f + b d|^2 with f = o - c and b = -f.d, and
not from b^2 - 4ac, which cancels for small or distant spheres [Haines2019, sec. 7.3].
"""

import math

import drjit as dr

from renderer.core.backend import Bool, Float, Vector2f, Vector3f
from renderer.core.numeric import TINY, greater
from renderer.core.records import Surface
from renderer.core.vectors import box_around
from renderer.shapes.base import SHORT, ShapeKind, register, turn

CENTER, RADIUS = 0, 3


def pack(shape, columns=None):
    """Return centre and radius."""
    return [*shape.center, shape.radius]


def interval(row, ray):
    """Return whether the line meets the ball, and where it enters and leaves it."""
    f = ray.o - row.vector(CENTER)
    b = -dr.dot(f, ray.d)
    discriminant = dr.square(row[RADIUS]) - dr.squared_norm(dr.fma(ray.d, b, f))
    half = dr.sqrt(discriminant)  # NaN where the line misses: both distances then fail every comparison
    return Bool(True), b - half, b + half


def surface(row, p):
    """Return the radial projection of p and its normal."""
    n = dr.normalize(p - row.vector(CENTER))
    return Surface(dr.fma(n, row[RADIUS], row.vector(CENTER)), n)


def texture_coordinates(row, surface):
    """Return longitude around +y in turns, and latitude from the north pole (0) to the south pole (1)."""
    n = surface.n_geo
    return Vector2f(turn(n.z, n.x), dr.safe_acos(n.y) * (1 / math.pi))


def tangents(row, surface):
    """Return the derivatives by longitude in turns and latitude in half turns; at a pole along longitude 0."""
    n = surface.n_geo
    s = dr.sqrt(n.x * n.x + n.z * n.z)
    inverse = dr.rcp(greater(s, Float(TINY)))
    cos_phi, sin_phi = dr.select(s > TINY, n.x * inverse, 1), dr.select(s > TINY, n.z * inverse, 0)
    along_u = Vector3f(-sin_phi, 0, cos_phi) * (math.tau * greater(s, SHORT) * row[RADIUS])
    return along_u, Vector3f(n.y * cos_phi, -s, n.y * sin_phi) * (math.pi * row[RADIUS])


def bounds(shape):
    """Return the corners of the box around the sphere."""
    return box_around(shape.center, [shape.radius] * 3)


register(ShapeKind("sphere", pack, surface, texture_coordinates, tangents, interval=interval, bounds=bounds))
