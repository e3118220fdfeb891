"""Convex volume: the intersection of half-spaces n.p <= d, possibly unbounded [Haines1991]."""

import drjit as dr

from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.hull import corners, unit_halfspaces
from renderer.core.numeric import FAR, away_from_zero, greater, lesser
from renderer.core.records import Surface
from renderer.core.rows import repeat
from renderer.shapes.base import ShapeKind, lane_frame, register

PLANE_COLUMNS = 4  # n, d
EVERYWHERE = (0.0, 0.0, 0.0, 1.0)  # contains all points; fills up records of volumes with fewer facets


def columns(shapes):
    """Return the record width that holds the volume with the most facets."""
    return PLANE_COLUMNS * max(len(unit_halfspaces(shape.halfspaces, shape.vertices)) for shape in shapes)


def pack(shape, columns):
    """Return the half-spaces, filled up to the record width."""
    values = [value for plane in unit_halfspaces(shape.halfspaces, shape.vertices) for value in plane]
    return values + list(EVERYWHERE) * ((columns - len(values)) // PLANE_COLUMNS)


def interval(row, ray):
    """Return whether the line meets the volume, and where it enters and leaves it."""

    def clip(k, near, far):
        n, d = row.vector(k * PLANE_COLUMNS), row[k * PLANE_COLUMNS + 3]
        rate = away_from_zero(dr.dot(n, ray.d))
        t = (d - dr.dot(n, ray.o)) / rate
        return dr.select(rate < 0, greater(t, near), near), dr.select(rate < 0, far, lesser(t, far))

    near, far = repeat(row.width // PLANE_COLUMNS, clip, (Float(-FAR), Float(FAR)), "half-spaces")
    return near <= far, near, far


def surface(row, p):
    """Return p projected onto the facet that it is nearest to."""

    def nearest(k, outside, n):
        plane, d = row.vector(k * PLANE_COLUMNS), row[k * PLANE_COLUMNS + 3]
        distance = dr.dot(plane, p) - d
        closer = distance > outside
        return dr.select(closer, distance, outside), dr.select(closer, plane, n)

    outside, n = repeat(row.width // PLANE_COLUMNS, nearest, (Float(-FAR), Vector3f(0, 0, 1)), "facets")
    return Surface(p - n * outside, n)


def texture_coordinates(row, surface):
    """Return the point's coordinates along the two axes of its facet, in scene units."""
    t, b = lane_frame(surface.n_geo)
    return Vector2f(dr.dot(surface.p, t), dr.dot(surface.p, b))


def tangents(row, surface):
    """Return the two axes of the facet."""
    return lane_frame(surface.n_geo)


def bounds(shape):
    """Return the box around the corners, or None where the volume reaches to infinity."""
    axes = [*zip(*corners(shape.halfspaces, shape.vertices))]
    return ([min(axis) for axis in axes], [max(axis) for axis in axes]) if axes else None


register(
    ShapeKind("convex", pack, surface, texture_coordinates, tangents, interval=interval, columns=columns, bounds=bounds)
)
