"""Which closed shape lies inside which: nested media, and lights that are walled in.

The interface of a closed refractive shape separates its own index of refraction from that of the smallest refractive
shape that contains it wholly, or 1. This is settled once, on the host; the kernel only sees the ratio. All closed
shapes are convex, so a shape is represented by points whose hull it is, and a ball around each of them: a ball itself
is one point, a polyhedron its corners, a cylinder the points of its rims.
"""

import itertools
import math

from renderer.core.hull import corners, unit_halfspaces, volume
from renderer.core.vectors import box_around, disk_reach, dot, frame, length, subtract, unit
from renderer.scene import schema

RIM_POINTS = 360  # exact to (pi / 360)^2 / 2 = 4e-5 of the radius
DIELECTRICS = ("dielectric", "roughdielectric")  # kinds of BSDF that refract
CLOSED = ("sphere", "cylinder", "box", "convex")
FEW = 64  # refractive shapes: below, trying all takes less than importing numpy
WIDE_SLACK = 1e-4  # of bounds, relative: nothing that `encloses` takes by points on rims may be passed over
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


def index_of(material, paths=False):
    """Return the index of refraction inside a material, None if it does not refract; `paths` is mode pathtracer."""
    if paths and material.bsdf is not None:
        return material.bsdf.ior if material.bsdf.type in DIELECTRICS else None
    return material.refractiveindex if material.isrefractive else None


def exterior_indices(shapes, paths=False):
    """Return the index of refraction around each shape of a scene; 1 for those that do not refract.

    Of a few refractive shapes all are tried; of many only those whose bounds hold the bounds of the shape inside.
    """
    glass = [shape for shape in shapes if index_of(shape.material, paths) is not None]
    around = _containers(glass) if len(glass) > FEW else {id(shape): glass for shape in glass}
    return [exterior_index(shape, around[id(shape)], paths) if id(shape) in around else 1.0 for shape in shapes]


def _containers(shapes):
    """Return {id of a shape: the shapes whose bounding boxes hold its own}, for shapes that have others around them."""
    import numpy as np

    closed = [shape for shape in shapes if shape.type in CLOSED]
    if not closed:
        return {}
    low, high = np.array([_bounds(shape) for shape in closed]).transpose(1, 0, 2)
    slack = WIDE_SLACK * (1 + np.maximum(np.abs(low), np.abs(high)).max(1, keepdims=True))
    with np.errstate(invalid="ignore"):
        outer_low, outer_high = low - slack, high + slack
    unknown = ~np.isfinite(low).all(1)
    outer_low[unknown], outer_high[unknown] = -np.inf, np.inf
    order = np.argsort(outer_low[:, 0], kind="stable")
    outer_low, outer_high = outer_low[order], outer_high[order]
    before = np.searchsorted(outer_low[:, 0], low[:, 0], side="right")  # only these begin far enough to the left
    found = {}
    for number, shape in enumerate(closed):
        count = before[number]
        wide = np.flatnonzero(outer_high[:count, 0] >= high[number, 0])
        holds = (outer_low[wide] <= low[number]).all(1) & (outer_high[wide] >= high[number]).all(1)
        if np.count_nonzero(holds) > 1:  # its own box is always among them
            found[id(shape)] = [closed[index] for index in order[wide[holds]]]
    return found


def _bounds(shape):
    """Return the corners with the least and with the greatest coordinates of a closed shape.

    Half-spaces may have no bounds; they get those of nothing, which lie in all others.
    """
    if isinstance(shape, schema.Convex) and shape.halfspaces is not None:
        return [math.inf] * 3, [-math.inf] * 3
    if isinstance(shape, schema.Cylinder):  # its rims are many points
        axis = unit(shape.axis)
        reach = [shape.height * abs(along) + cap for along, cap in zip(axis, disk_reach(axis, shape.radius))]
        return box_around(shape.center, reach)
    points, ball = _extreme_points(shape)
    return [min(axis) - ball for axis in zip(*points)], [max(axis) + ball for axis in zip(*points)]


def exterior_index(shape, shapes, paths=False):
    """Return the index of refraction around a refractive shape; `shapes` are all that may be around it.

    Of two that contain each other (equal ones) neither is the smaller, so neither surrounds the other.
    """
    points, ball = _extreme_points(shape)
    if not points:
        return 1.0
    own = _volume(shape)
    around = [
        (_volume(other), index_of(other.material, paths))
        for other in shapes
        if other is not shape and index_of(other.material, paths) is not None and encloses(other, points, ball)
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
