"""Which refractive shape lies inside which: the index of refraction outside each glass surface.

All closed shapes of the scene format are convex, so A contains B exactly where the farthest points of B, measured
against each surface of A, lie inside: a plane needs the support function of B, a sphere or a cylinder the greatest
distance of B from a point or from an axis.
"""

from __future__ import annotations

import numpy as np

from converters.geometry import box_polyhedron, frame, hull, intersection, unit

CLOSED = ("sphere", "cylinder", "box", "convex")
GLASS = ("dielectric", "roughdielectric")  # BSDFs that light passes
ANGLES = 4096  # points of a circle; their greatest distance from an axis is exact to (pi / ANGLES)^2 / 2 = 3e-7
SLACK = 1e-9  # relative: shapes that touch from inside count as contained


def polyhedron(shape):
    """Return the polyhedron of a box or convex shape."""
    if shape.type == "box":
        return box_polyhedron(shape.min, shape.max)
    return hull(shape.vertices) if shape.vertices is not None else intersection(shape.halfspaces)


def _rims(cylinder):
    """Return points on both rims, (2 * ANGLES, 3): the cylinder is their convex hull."""
    axis, centre = unit(cylinder.axis), np.asarray(cylinder.center)
    tangent, bitangent = frame(axis)
    angle = np.linspace(0, 2 * np.pi, ANGLES, endpoint=False)[:, None]
    ring = cylinder.radius * (np.cos(angle) * tangent + np.sin(angle) * bitangent)
    return np.concatenate([centre + sign * cylinder.height * axis + ring for sign in (1, -1)])


def _points(shape):
    """Return points whose convex hull is the shape, and the radius of a ball to be added to it."""
    if shape.type == "sphere":
        return np.asarray([shape.center]), shape.radius
    if shape.type == "cylinder":
        return _rims(shape), 0.0
    return polyhedron(shape).corners, 0.0


def _volume(shape):
    """Return the shape's volume in cubic scene units; unbounded volumes count as clipped."""
    if shape.type == "sphere":
        return 4 / 3 * np.pi * shape.radius**3
    if shape.type == "cylinder":
        return np.pi * shape.radius**2 * 2 * shape.height
    from scipy.spatial import ConvexHull

    return ConvexHull(polyhedron(shape).corners).volume


def contains(outer, inner):
    """Return whether the closed shape `outer` contains the closed shape `inner` wholly."""
    points, ball = _points(inner)
    slack = SLACK * max(1.0, np.abs(points).max() + ball)
    if outer.type == "sphere":
        return np.linalg.norm(points - outer.center, axis=1).max() + ball <= outer.radius + slack
    if outer.type == "cylinder":
        axis = unit(outer.axis)
        along = (points - outer.center) @ axis
        beside = np.linalg.norm(points - outer.center - along[:, None] * axis, axis=1)
        return np.abs(along).max() + ball <= outer.height + slack and beside.max() + ball <= outer.radius + slack
    planes = polyhedron(outer)
    return bool(((points @ planes.normals.T).max(axis=0) + ball <= planes.offsets + slack).all())


def index_of(material, mode):
    """Return the index of refraction inside a shape of the material in a render mode, or None if it is opaque."""
    if mode == "pathtracer" and material.bsdf is not None:
        return material.bsdf.ior if material.bsdf.type in GLASS else None
    return material.refractiveindex if material.isrefractive else None


def outside_indices(shapes, mode="phong"):
    """Return the index of refraction around each shape, in the order of `shapes`, a list of descriptions.

    It is that of the smallest closed refractive shape that contains the shape wholly, else 1. Of two that contain
    each other (equal ones) neither is the smaller, so neither surrounds the other.
    """
    glass = [s for s in shapes if s.type in CLOSED and index_of(s.material, mode) is not None]
    volumes = {id(s): _volume(s) for s in glass}
    result = []
    for shape in shapes:
        around = [other for other in glass if id(shape) in volumes and other is not shape
                  and volumes[id(other)] > volumes[id(shape)] and contains(other, shape)]
        inner = min(around, key=lambda s: volumes[id(s)], default=None)
        result.append(index_of(inner.material, mode) if inner else 1.0)
    return result
