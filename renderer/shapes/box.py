"""Axis-aligned box: three slabs [Kay1986]."""

import drjit as dr

from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.numeric import away_from_zero, greater, lesser
from renderer.core.records import Surface
from renderer.shapes.base import ShapeKind, register

CENTER, HALF = 0, 3


def pack(shape, columns=None):
    """Return the middle and the half edge lengths."""
    middle = [0.5 * (low + high) for low, high in zip(shape.min, shape.max)]
    half = [0.5 * (high - low) for low, high in zip(shape.min, shape.max)]
    return [*middle, *half]


def interval(row, ray):
    """Return whether the line meets the box, and where it enters and leaves it."""
    to_middle, half = row.vector(CENTER) - ray.o, row.vector(HALF)
    near, far = None, None
    for axis in range(3):
        rate = dr.rcp(away_from_zero(ray.d[axis]))
        middle, reach = to_middle[axis] * rate, half[axis] * abs(rate)
        near = middle - reach if near is None else greater(middle - reach, near)
        far = middle + reach if far is None else lesser(middle + reach, far)
    return near <= far, near, far


def _face(row, p):
    """Return p relative to the middle and three masks, of which the one of p's face is set."""
    q, half = p - row.vector(CENTER), row.vector(HALF)
    outside = [abs(q[axis]) - half[axis] for axis in range(3)]
    on_x = (outside[0] >= outside[1]) & (outside[0] >= outside[2])
    on_y = ~on_x & (outside[1] >= outside[2])
    return q, (on_x, on_y, ~on_x & ~on_y)


def surface(row, p):
    """Return p moved onto the nearest face."""
    q, faces = _face(row, p)
    half, middle = row.vector(HALF), row.vector(CENTER)
    moved, n = Vector3f(p), Vector3f(0)
    for axis, on_face in enumerate(faces):
        moved[axis] = dr.select(on_face, middle[axis] + dr.copysign(half[axis], q[axis]), p[axis])
        n[axis] = dr.select(on_face, dr.copysign(Float(1), q[axis]), 0)
    return Surface(moved, n)


def texture_coordinates(row, surface):
    """Return the position on the face from 0 to 1, to the right and down for who looks at it.

    The sides run along the horizon; the top is seen with +z up, the bottom with -z up.
    """
    q, (on_x, on_y, on_z) = _face(row, surface.p)
    x, y, z = (q[axis] / row[HALF + axis] for axis in range(3))
    n = surface.n_geo
    u = dr.select(on_x, z * n.x, dr.select(on_z, -x * n.z, x))
    v = dr.select(on_y, -z * n.y, -y)
    return Vector2f(0.5 + 0.5 * u, 0.5 + 0.5 * v)


def tangents(row, surface):
    """Return the edges of the face."""
    _, (on_x, on_y, on_z) = _face(row, surface.p)
    half, n = row.vector(HALF) * 2, surface.n_geo
    along_u = Vector3f(dr.select(on_x, 0, dr.select(on_z, -half.x * n.z, half.x)), 0, dr.select(on_x, half.z * n.x, 0))
    return along_u, Vector3f(0, dr.select(on_y, 0, -half.y), dr.select(on_y, -half.z * n.y, 0))


def bounds(shape):
    """Return the box's own corners."""
    return shape.min, shape.max


register(ShapeKind("box", pack, surface, texture_coordinates, tangents, interval=interval, bounds=bounds))
