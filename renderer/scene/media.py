"""Which closed shape lies inside which: nested media, and lights that are walled in.

The interface of a closed refractive shape separates its own index of refraction from that of the smallest refractive
shape that contains it wholly, or 1. This is settled once, on the host; the kernel only sees the ratio. All closed
shapes are convex, so a shape is represented by points whose hull it is, and a ball around each of them: a ball itself
is one point, a polyhedron its corners, a cylinder the points of its rims.
"""

import itertools
import math

from renderer.core.hull import corners, unit_halfspaces, volume
from renderer.core.vectors import dot, frame, length, subtract, unit
from renderer.scene import schema

RIM_POINTS = 360  # exact to (pi / 360)^2 / 2 = 4e-5 of the radius
SLACK = 1e-9  # relative; a shape that touches its container from inside counts as contained


def encloses(shape, points, ball=0.0):
    """Return whether a closed shape holds balls of radius `ball` around all points; sheets hold nothing."""
    slack = SLACK * (1 + ball + max(abs(x) for point in points for x in point))
    match shape:
        case schema.Sphere():
            return all(math.dist(point, shape.center) + ball <= shape.radius + slack for point in points)
        case schema.Cylinder():
            axis = unit(shape.axis)
            return all(_within_cylinder(shape, axis, point, ball - slack) for point in points)
        case schema.Box():
            return all(
                low - slack <= x - ball and x + ball <= high + slack
                for point in points
                for low, x, high in zip(shape.min, point, shape.max)
            )
        case schema.Convex():
            planes = unit_halfspaces(shape.halfspaces, shape.vertices)
            return all(dot(plane, point) + ball <= plane[3] + slack for plane in planes for point in points)
    return False


def exterior_index(shape, shapes):
    """Return the index of refraction around a refractive shape; `shapes` are all shapes of the scene.

    Of two that contain each other (equal ones) neither is the smaller, so neither surrounds the other.
    """
    points, ball = _extreme_points(shape)
    if not points:
        return 1.0
    own = _volume(shape)
    around = [
        (_volume(other), other.material.refractiveindex)
        for other in shapes
        if other is not shape and other.material.isrefractive and encloses(other, points, ball)
    ]
    return min(((size, index) for size, index in around if size > own), default=(own, 1.0))[1]


def _within_cylinder(shape, axis, point, ball):
    offset = subtract(point, shape.center)
    along = dot(offset, axis)
    across = length([f - along * a for f, a in zip(offset, axis)])
    return abs(along) + ball <= shape.height and across + ball <= shape.radius


def _extreme_points(shape):
    """Return (points, radius of a ball around each) whose hull is the shape; no points for what is not closed."""
    match shape:
        case schema.Sphere():
            return [shape.center], shape.radius
        case schema.Cylinder():
            return _rims(shape), 0.0
        case schema.Box():
            return list(itertools.product(*zip(shape.min, shape.max))), 0.0
        case schema.Convex():
            return corners(shape.halfspaces, shape.vertices), 0.0
    return (), 0.0


def _rims(cylinder):
    """Return points on both rims."""
    axis = unit(cylinder.axis)
    tangent, bitangent = frame(axis)
    angles = [math.tau * k / RIM_POINTS for k in range(RIM_POINTS)]
    ring = [
        [cylinder.radius * (math.cos(angle) * t + math.sin(angle) * b) for t, b in zip(tangent, bitangent)]
        for angle in angles
    ]
    return [
        [c + end * cylinder.height * a + r for c, a, r in zip(cylinder.center, axis, offset)]
        for end in (-1, 1)
        for offset in ring
    ]


def _volume(shape):
    """Return the volume of a closed shape; infinity for unbounded ones."""
    match shape:
        case schema.Sphere():
            return 4 / 3 * math.pi * shape.radius**3
        case schema.Cylinder():
            return math.tau * shape.radius**2 * shape.height
        case schema.Box():
            return math.prod(high - low for low, high in zip(shape.min, shape.max))
    return volume(shape.halfspaces, shape.vertices)
