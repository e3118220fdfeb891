"""Convex volume: the intersection of half-spaces n.p <= d, possibly unbounded [Haines1991].

Where one of a scene's volumes is far from the origin, n.p - d would lose what is small beside d. All of them then carry
a point to measure from, behind their half-spaces; else there is no such point, and nothing is subtracted.
"""

import drjit as dr

from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.hull import anchor, corners, unit_halfspaces
from renderer.core.numeric import FAR, away_from_zero, greater, lesser
from renderer.core.records import Surface
from renderer.core.rows import repeat
from renderer.core.vectors import dot
from renderer.shapes.base import ShapeKind, lane_frame, register

PLANE_COLUMNS, ANCHOR_COLUMNS = 4, 3  # n, d; a point
EVERYWHERE = (0.0, 0.0, 0.0, 1.0)  # contains all points; fills up records of volumes with fewer facets


def columns(shapes):
    """Return the record width that holds the volume with the most facets, and a point if any is far away."""
    each = [unit_halfspaces(shape.halfspaces, shape.vertices) for shape in shapes]
    far_away = any(anchor(planes, shape.vertices) for planes, shape in zip(each, shapes))
    return PLANE_COLUMNS * max(map(len, each)) + ANCHOR_COLUMNS * far_away


def pack(shape, columns):
    """Return the half-spaces, filled up to the record width, and the point that they are relative to."""
    planes, count = unit_halfspaces(shape.halfspaces, shape.vertices), columns // PLANE_COLUMNS
    middle = (anchor(planes, shape.vertices) or [0.0] * ANCHOR_COLUMNS) if columns % PLANE_COLUMNS else []
    relative = [(*n, d - dot(n, middle) if middle else d) for *n, d in planes]
    return [value for plane in relative + [EVERYWHERE] * (count - len(planes)) for value in plane] + middle


def _relative(row, p):
    """Return a point as the half-spaces are: to the record's point where there is one."""
    return p - row.vector(row.width - ANCHOR_COLUMNS) if row.width % PLANE_COLUMNS else p


def interval(row, ray):
    """Return whether the line meets the volume, and where it enters and leaves it."""
    o = _relative(row, ray.o)

    def clip(k, near, far):
        n, d = row.vector(k * PLANE_COLUMNS), row[k * PLANE_COLUMNS + 3]
        rate = away_from_zero(dr.dot(n, ray.d))
        t = (d - dr.dot(n, o)) / rate
        return dr.select(rate < 0, greater(t, near), near), dr.select(rate < 0, far, lesser(t, far))

    near, far = repeat(row.width // PLANE_COLUMNS, clip, (Float(-FAR), Float(FAR)), "half-spaces")
    return near <= far, near, far


def surface(row, p):
    """Return p projected onto the facet that it is nearest to."""
    q = _relative(row, p)

    def nearest(k, outside, n):
        plane, d = row.vector(k * PLANE_COLUMNS), row[k * PLANE_COLUMNS + 3]
        distance = dr.dot(plane, q) - d
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
