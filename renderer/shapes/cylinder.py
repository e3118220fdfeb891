"""Capped cylinder of any axis: the intersection of an infinite cylinder and a slab."""

import drjit as dr

from renderer.core.backend import Vector2f
from renderer.core.numeric import TINY, away_from_zero, greater, lesser
from renderer.core.records import Surface
from renderer.core.vectors import box_around, disk_reach, frame, unit
from renderer.shapes.base import ShapeKind, polar_tangents, register, turn

CENTER, AXIS, TANGENT, BITANGENT, RADIUS, HALF = 0, 3, 6, 9, 12, 13


def pack(shape, columns=None):
    """Return centre, unit axis with its two normals, radius and half length."""
    axis = unit(shape.axis)
    tangent, bitangent = frame(axis)
    return [*shape.center, *axis, *tangent, *bitangent, shape.radius, shape.height]


def interval(row, ray):
    """Return whether the line meets the solid cylinder, and where it enters and leaves it."""
    f = ray.o - row.vector(CENTER)
    (fx, dx), (fy, dy), (fz, dz) = (
        (dr.dot(f, row.vector(column)), dr.dot(ray.d, row.vector(column))) for column in (TANGENT, BITANGENT, AXIS)
    )

    # across the axis: a circle, as for the sphere but with a direction that is not of unit length; for a line along
    # the axis it is 0, and the interval becomes everything (inside the circle) or nothing (outside)
    speed2 = dr.fma(dx, dx, dy * dy)
    along = speed2 < TINY
    dx, dy = dr.select(along, 0, dx), dr.select(along, 0, dy)
    inverse = dr.rcp(greater(speed2, TINY))
    middle = -dr.fma(fx, dx, fy * dy) * inverse
    closest_x, closest_y = dr.fma(dx, middle, fx), dr.fma(dy, middle, fy)
    discriminant = dr.square(row[RADIUS]) - dr.fma(closest_x, closest_x, closest_y * closest_y)
    half = dr.sqrt(discriminant * inverse)  # NaN where the line misses the circle

    # along the axis: the slab between the caps
    rate = dr.rcp(away_from_zero(dz))
    to_middle, reach = -fz * rate, abs(rate) * row[HALF]

    # the second operand wins where it is NaN, and then fails the comparison
    near = greater(to_middle - reach, middle - half)
    far = lesser(to_middle + reach, middle + half)
    return near <= far, near, far


def _local(row, p):
    """Return the coordinate of p along the axis, its offset across the axis, and the distance from the axis."""
    f = p - row.vector(CENTER)
    along = dr.dot(f, row.vector(AXIS))
    across = f - row.vector(AXIS) * along
    return along, across, dr.norm(across)


def surface(row, p):
    """Return p moved onto the nearer of side and cap."""
    along, across, rho = _local(row, p)
    on_cap = abs(along) - row[HALF] > rho - row[RADIUS]
    end = dr.copysign(row[HALF], along)
    outward = across * dr.rcp(greater(rho, TINY))
    n = dr.select(on_cap, dr.select(along > 0, row.vector(AXIS), -row.vector(AXIS)), outward)
    middle = row.vector(CENTER)
    side_p = dr.fma(outward, row[RADIUS], dr.fma(row.vector(AXIS), along, middle))
    cap_p = middle + across + row.vector(AXIS) * end
    return Surface(dr.select(on_cap, cap_p, side_p), n)


def texture_coordinates(row, surface):
    """Return the angle in turns, and v: on the side from the top (0) to the bottom (1), on caps from the middle out."""
    along, across, rho = _local(row, surface.p)
    u = turn(-dr.dot(across, row.vector(BITANGENT)), dr.dot(across, row.vector(TANGENT)))
    on_cap = abs(dr.dot(surface.n_geo, row.vector(AXIS))) > 0.5
    return Vector2f(u, dr.select(on_cap, rho / row[RADIUS], 0.5 - 0.5 * along / row[HALF]))


def tangents(row, surface):
    """Return the derivatives by the angle in turns, and by the way along the side or from the middle of a cap."""
    _, across, _ = _local(row, surface.p)
    axis = row.vector(AXIS)
    along_u, outward = polar_tangents(across, axis, row.vector(TANGENT), row[RADIUS])
    on_cap = abs(dr.dot(surface.n_geo, axis)) > 0.5
    return along_u, dr.select(on_cap, outward, axis * (-2 * row[HALF]))


def bounds(shape):
    """Return the corners of the box around both caps."""
    axis = unit(shape.axis)
    reach = [shape.height * abs(along) + cap for along, cap in zip(axis, disk_reach(axis, shape.radius))]
    return box_around(shape.center, reach)


register(
    ShapeKind(
        "cylinder", pack, surface, texture_coordinates, tangents, interval=interval, bounds=bounds,
        directions=range(AXIS, RADIUS),
    )
)
