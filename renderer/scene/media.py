"""Nested media: which index of refraction lies outside each glass surface.

The interface of a closed refractive shape separates its own index from that of the smallest refractive shape that
contains it wholly, or 1. This is settled once, on the host; the kernel only sees the ratio. All closed shapes are
convex, so a shape lies inside another exactly when its extreme points do; round shapes are represented by points
on their surface.
"""

import itertools
import math

from renderer.core.hull import corners, unit_halfspaces
from renderer.core.vectors import dot, frame, subtract, unit
from renderer.scene import schema

CIRCLE = [(math.cos(math.tau * k / 32), math.sin(math.tau * k / 32)) for k in range(32)]
DIRECTIONS = [unit(d) for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)]
SLACK = 1e-9  # relative; a shape that touches its container from inside counts as contained


def contains(shape, point, slack=0.0):
    """Return whether a closed shape, grown by the relative slack, contains a point; sheets contain nothing."""
    match shape:
        case schema.Sphere():
            return math.dist(point, shape.center) <= shape.radius * (1 + slack)
        case schema.Cylinder():
            offset, axis = subtract(point, shape.center), unit(shape.axis)
            along = dot(offset, axis)
            across = math.hypot(*(f - along * a for f, a in zip(offset, axis)))
            return abs(along) <= shape.height * (1 + slack) and across <= shape.radius * (1 + slack)
        case schema.Box():
            margins = [slack * (high - low) for low, high in zip(shape.min, shape.max)]
            return all(low - m <= x <= high + m for low, x, high, m in zip(shape.min, point, shape.max, margins))
        case schema.Convex():
            margin = slack * (1 + math.hypot(*point))
            planes = unit_halfspaces(shape.halfspaces, shape.vertices)
            return all(dot((a, b, c), point) <= d + margin for a, b, c, d in planes)
    return False


def exterior_index(shape, shapes):
    """Return the index of refraction around a refractive shape; `shapes` are all shapes of the scene."""
    points = _extreme_points(shape)
    around = [
        other
        for other in shapes
        if other is not shape
        and other.material.isrefractive
        and points
        and all(contains(other, point, SLACK) for point in points)
        and not all(contains(shape, point, SLACK) for point in _extreme_points(other) or [(math.inf,) * 3])
    ]
    return min(around, key=_size).material.refractiveindex if around else 1.0


def _extreme_points(shape):
    """Return points whose hull is the shape, or close to it; none for sheets and unbounded volumes."""
    match shape:
        case schema.Sphere():
            return [[c + shape.radius * x for c, x in zip(shape.center, d)] for d in DIRECTIONS]
        case schema.Cylinder():
            axis = unit(shape.axis)
            t, b = frame(axis)
            return [
                [
                    c + end * shape.height * a + shape.radius * (x * p + y * q)
                    for c, a, p, q in zip(shape.center, axis, t, b)
                ]
                for end in (-1, 1)
                for x, y in CIRCLE
            ]
        case schema.Box():
            return [list(corner) for corner in itertools.product(*zip(shape.min, shape.max))]
        case schema.Convex():
            return corners(shape.halfspaces, shape.vertices)
    return []


def _size(shape):
    """Return the length of the diagonal of the box around a closed shape."""
    points = _extreme_points(shape)
    return math.dist(*([pick(axis) for axis in zip(*points)] for pick in (min, max))) if points else math.inf
