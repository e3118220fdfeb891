"""Capped cylinder of any axis: the intersection of an infinite cylinder and a slab."""

import drjit as dr

from renderer.core.numeric import FAR, TINY, away_from_zero, greater, lesser, safe_sqrt
from renderer.core.records import Surface
from renderer.core.vectors import frame, unit
from renderer.shapes.base import ShapeKind, register, turn, uv

CENTER, AXIS, TANGENT, BITANGENT, RADIUS, HALF = 0, 3, 6, 9, 12, 13


def pack(shape, columns=None):
    """Return centre, unit axis with its two normals, radius and half length."""
    axis = unit(shape.axis)
    tangent, bitangent = frame(axis)
    return [*shape.center, *axis, *tangent, *bitangent, shape.radius, shape.height]


def interval(row, ray):
    """Return where the line enters and leaves the solid cylinder."""
    f, axis = ray.o - row.vector(CENTER), row.vector(AXIS)
    f_axis, d_axis = dr.dot(f, axis), dr.dot(ray.d, axis)

    # across the axis: a circle, as for the sphere but with a direction that is not of unit length; it vanishes for
    # a line along the axis, where the interval becomes everything (inside the circle) or nothing (outside)
    f_across, d_across = f - axis * f_axis, ray.d - axis * d_axis
    inverse = dr.rcp(greater(dr.squared_norm(d_across), TINY))
    middle = -dr.dot(f_across, d_across) * inverse
    discriminant = dr.square(row[RADIUS]) - dr.squared_norm(dr.fma(d_across, middle, f_across))
    half = safe_sqrt(discriminant * inverse)

    # along the axis: the slab between the caps
    rate = dr.rcp(away_from_zero(d_axis))
    to_middle, reach = -f_axis * rate, abs(rate) * row[HALF]

    near = greater(middle - half, to_middle - reach)
    far = lesser(middle + half, to_middle + reach)
    inside = discriminant >= 0
    return dr.select(inside, near, FAR), dr.select(inside, far, -FAR)


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
    """Return the angle in turns; and on the side the way from the top (0) to the bottom (1), on a cap the distance from its middle."""
    along, across, rho = _local(row, surface.p)
    u = turn(-dr.dot(across, row.vector(BITANGENT)), dr.dot(across, row.vector(TANGENT)))
    on_cap = abs(dr.dot(surface.n_geo, row.vector(AXIS))) > 0.5
    return uv(u, dr.select(on_cap, rho / row[RADIUS], 0.5 - 0.5 * along / row[HALF]))


register(ShapeKind("cylinder", pack, surface, texture_coordinates, interval=interval))
