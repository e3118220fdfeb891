"""Convex volumes on the host: half-spaces from whichever description the scene gives."""

import math
from array import array
from functools import lru_cache

FAR_AWAY = 4.0  # sizes of a volume from the origin at which it gets an origin of its own
RELAXATIONS = 64  # steps towards a volume, each into the half-space that is left the most
SAME_PLANE = 9  # decimals to which unit normals and offsets of facets agree that lie in one plane


@lru_cache(maxsize=1024)
def unit_halfspaces(halfspaces, vertices):
    """Return the half-spaces (nx, ny, nz, d), n.p <= d with unit n, of a volume given by either of the two.

    `halfspaces` is a tuple of 4-tuples with normals of any length, or None; then the volume is the hull of
    `vertices`, a tuple of points that do not lie in one plane.
    """
    if halfspaces is not None:
        return tuple(
            tuple(value / math.hypot(a, b, c) for value in (a, b, c, d)) for a, b, c, d in halfspaces
        )
    from scipy.spatial import ConvexHull  # slow to import, rarely needed

    # a facet with more than three corners comes as several triangles with almost the same plane
    facets = {}
    for a, b, c, minus_d in ConvexHull(vertices).equations.tolist():
        facets.setdefault(tuple(round(value, SAME_PLANE) for value in (a, b, c, minus_d)), (a, b, c, -minus_d))
    return tuple(facets.values())


def anchor(planes, vertices):
    """Return a point of float32 numbers that unit half-spaces far from the origin are best measured from, or None.

    `vertices` are the volume's if it is given by them. None is for volumes that reach within a few times their size of
    the origin: nothing is gained there, and planes through the origin stay exact.
    """
    if vertices is not None:
        near = [sum(axis) / len(vertices) for axis in zip(*vertices)]
    else:
        near = [0.0, 0.0, 0.0]
        for _ in range(RELAXATIONS):
            excess, normal = max((_beyond(plane, near), plane) for plane in planes)
            if excess <= 0:
                break
            near = [x - excess * n for x, n in zip(near, normal)]
    near = array("f", near).tolist()
    reach = max(abs(_beyond(plane, near)) for plane in planes)
    return near if FAR_AWAY * reach < scale_of(planes) else None


def _beyond(plane, p):
    """Return how far a point is outside of a half-space."""
    a, b, c, d = plane
    return a * p[0] + b * p[1] + c * p[2] - d


def scale_of(planes):
    """Return the greatest distance of a plane from the origin, 1 where all pass through it."""
    return max(abs(d) for *_, d in planes) or 1.0


def interior_point(planes):
    """Return (point, radius): the middle of the largest ball inside unit half-spaces.

    The radius is at most `scale_of(planes)`; it is 0, and the point None, where the intersection is empty or flat.
    """
    from scipy.optimize import linprog

    scale = scale_of(planes)
    rows = [(a, b, c, 1.0) for a, b, c, _ in planes]
    offsets = [d / scale for *_, d in planes]
    bounds = [(None, None)] * 3 + [(None, 1.0)]  # capped, so that unbounded volumes have a largest ball
    answer = linprog([0, 0, 0, -1], A_ub=rows, b_ub=offsets, bounds=bounds, method="highs")
    if answer.status != 0 or answer.x[3] <= 0:
        return None, 0.0
    return [scale * x for x in answer.x[:3]], scale * float(answer.x[3])


@lru_cache(maxsize=1024)
def corners(halfspaces, vertices):
    """Return the corners of a convex volume (arguments as above); none where it is unbounded or empty."""
    if vertices is not None:
        return vertices
    import numpy as np
    from scipy.spatial import HalfspaceIntersection, QhullError

    planes = unit_halfspaces(halfspaces, None)
    inside, _ = interior_point(planes)
    if inside is None:
        return ()
    try:
        found = HalfspaceIntersection(np.array([(a, b, c, -d) for a, b, c, d in planes]), np.array(inside))
    except QhullError:  # too few half-spaces to bound anything
        return ()
    points = found.intersections
    return tuple(map(tuple, points.tolist())) if np.isfinite(points).all() else ()


def volume(halfspaces, vertices):
    """Return the volume of a convex volume (arguments as above); infinity where it is unbounded."""
    from scipy.spatial import ConvexHull

    points = corners(halfspaces, vertices)
    return float(ConvexHull(points).volume) if points else math.inf
