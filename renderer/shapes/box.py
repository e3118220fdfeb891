"""Axis-aligned box: three slabs [Kay1986].

Faces are kept as they are given: from a middle and half a length, the near end of a long box would come out wrong by
roundoffs of its far end, and would no longer touch what it stands on.
"""

import drjit as dr

from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.numeric import away_from_zero, greater, lesser
from renderer.core.records import Surface
from renderer.shapes.base import ShapeKind, register

LOW, HIGH = 0, 3


def pack(shape, columns=None):
    """Return the two corners."""
    return [*shape.min, *shape.max]


def interval(row, ray):
    """Return whether the line meets the box, and where it enters and leaves it."""
    to_low, to_high = row.vector(LOW) - ray.o, row.vector(HIGH) - ray.o
    near, far = None, None
    for axis in range(3):
        rate = dr.rcp(away_from_zero(ray.d[axis]))
        to_first, to_second = to_low[axis] * rate, to_high[axis] * rate
        enters, leaves = lesser(to_first, to_second), greater(to_first, to_second)
        near = enters if near is None else greater(enters, near)
        far = leaves if far is None else lesser(leaves, far)
    return near <= far, near, far


def _face(row, p):
    """Return three masks, of which the one of p's face is set, and whether p is nearer to the high corner's faces."""
    over, under = p - row.vector(HIGH), row.vector(LOW) - p
    high = [over[axis] > under[axis] for axis in range(3)]
    outside = [greater(over[axis], under[axis]) for axis in range(3)]
    on_x = (outside[0] >= outside[1]) & (outside[0] >= outside[2])
    on_y = ~on_x & (outside[1] >= outside[2])
    return (on_x, on_y, ~on_x & ~on_y), high


def surface(row, p):
    """Return p moved onto the nearest face."""
    faces, high = _face(row, p)
    moved, n = Vector3f(p), Vector3f(0)
    for axis, on_face in enumerate(faces):
        face = dr.select(high[axis], row[HIGH + axis], row[LOW + axis])
        moved[axis] = dr.select(on_face, face, p[axis])
        n[axis] = dr.select(on_face, dr.select(high[axis], Float(1), -1), 0)
    return Surface(moved, n)


def texture_coordinates(row, surface):
    """Return the position on the face from 0 to 1, to the right and down for who looks at it.

    The sides run along the horizon; the top is seen with +z up, the bottom with -z up.
    """
    (on_x, on_y, on_z), _ = _face(row, surface.p)
    low, high = row.vector(LOW), row.vector(HIGH)
    x, y, z = (((surface.p[axis] - low[axis]) - (high[axis] - surface.p[axis])) / (high[axis] - low[axis])
               for axis in range(3))  # -1 to 1
    n = surface.n_geo
    u = dr.select(on_x, z * n.x, dr.select(on_z, -x * n.z, x))
    v = dr.select(on_y, -z * n.y, -y)
    return Vector2f(0.5 + 0.5 * u, 0.5 + 0.5 * v)


def tangents(row, surface):
    """Return the edges of the face."""
    (on_x, on_y, on_z), _ = _face(row, surface.p)
    edge, n = row.vector(HIGH) - row.vector(LOW), surface.n_geo
    along_u = Vector3f(dr.select(on_x, 0, dr.select(on_z, -edge.x * n.z, edge.x)), 0, dr.select(on_x, edge.z * n.x, 0))
    return along_u, Vector3f(0, dr.select(on_y, 0, -edge.y), dr.select(on_y, -edge.z * n.y, 0))


def bounds(shape):
    """Return the box's own corners."""
    return shape.min, shape.max


register(ShapeKind("box", pack, surface, texture_coordinates, tangents, interval=interval, bounds=bounds))
