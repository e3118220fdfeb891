"""Shapes of the description as Mitsuba's primitives: the one place that says which primitive stands for which shape.

Both the stock export and the exact Whitted counterpart read these parts. A cylinder becomes a tube and two disks, an
infinite plane a disk of radius PLANE_RADIUS (a rectangle of that size loses digits and shadows itself), triangles,
boxes and convex volumes become meshes, and mesh files are left to Mitsuba's own readers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from converters.geometry import (
    Mesh, box_mesh, convex_mesh, frame, hull, intersection, matrix, unit,
)
from converters.meshes import MeshFile, mesh_file

BELOW = 1e-3  # scene units between a textured plane's rectangle and what goes on beyond
RIGHT_ANGLE = 1e-6  # cosine: Mitsuba's rectangles have right angles, other parallelograms become meshes
PLANE_RADIUS = 1e6  # scene units: the rim is 1e-6 from the horizon, less than rounding of a camera ray
# Scene units; Mitsuba's disks have polar texture coordinates, so a rectangle stands in for a textured plane.
TEXTURED_PLANE_HALF_SIDE = 100.0

# From the primitive's own texture coordinates to ours, homogeneous 3 x 3. Our camera's picture is mirrored against
# Mitsuba's, so angles run the other way; a tube's own v runs up and ours down. A disk has (radius, azimuth); the lower
# cap of a cylinder looks the other way, so its azimuth runs backwards.
OWN_UV = np.eye(3)
SPHERE_UV = np.array([[-1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
TUBE_UV = np.array([[-1.0, 0.0, 1.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]])
CAP_UV = np.array([[0.0, -1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
LOWER_CAP_UV = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_H = TEXTURED_PLANE_HALF_SIDE
RECTANGLE_UV = np.array([[2 * _H, 0.0, -_H], [0.0, 2 * _H, -_H], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Part:
    """One primitive of a shape: `sphere`, `cylinder`, `disk`, `rectangle` (unit, placed by `to_world`), `mesh`, or
    `ply` and `obj` (from a `file`).
    """

    name: str
    kind: str
    to_world: np.ndarray | None = None  # (4, 4) float64
    mesh: Mesh | None = None
    file: MeshFile | None = None
    uv_map: np.ndarray | None = None  # (3, 3): primitive's uv to ours; None where the primitive's uv are of no use


def _sphere(shape):
    """Yield the primitive of a sphere."""
    # The pole of Mitsuba's sphere is its local z: local (x, y, z) goes to world (x, -z, y), which keeps handedness.
    columns = shape.radius * np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    yield Part("sphere", "sphere", matrix(*columns, shape.center), uv_map=SPHERE_UV)


def _cylinder(shape):
    """Yield a tube and two disks."""
    axis, centre, radius = unit(shape.axis), np.asarray(shape.center), shape.radius
    t, b = (radius * v for v in frame(axis))
    low, high = centre - shape.height * axis, centre + shape.height * axis
    yield Part("side", "cylinder", matrix(t, b, 2 * shape.height * axis, low), uv_map=TUBE_UV)
    yield Part("top", "disk", matrix(t, b, axis, high), uv_map=CAP_UV)
    yield Part("bottom", "disk", matrix(t, -b, -axis, low), uv_map=LOWER_CAP_UV)


def _triangle(shape):
    """Yield a mesh of one triangle."""
    corners, uv = np.array([shape.v0, shape.v1, shape.v2]), np.array([shape.uv0, shape.uv1, shape.uv2])
    yield Part("triangle", "mesh", mesh=Mesh(corners, np.array([[0, 1, 2]]), uv), uv_map=OWN_UV)


def _plane(shape):
    """Yield a disk that reaches to the horizon."""
    normal = unit(shape.normal)
    t, b = frame(normal)
    yield Part("plane", "disk", matrix(PLANE_RADIUS * t, PLANE_RADIUS * b, normal, shape.point))


def sheet_mesh(name, middle, u, v):
    """Return the part of a parallelogram with the edges u and v, seen from the side of u x v; uv from 0 to 1."""
    middle, u, v = (np.asarray(vector, dtype=np.float64) for vector in (middle, u, v))
    if abs(u @ v) <= RIGHT_ANGLE * np.linalg.norm(u) * np.linalg.norm(v):
        return Part(name, "rectangle", matrix(u / 2, v / 2, unit(np.cross(u, v)), middle), uv_map=OWN_UV)
    uv = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    corners = middle + (uv - 0.5) @ np.array([u, v])
    return Part(name, "mesh", mesh=Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), uv), uv_map=OWN_UV)


def _rectangle(shape):
    """Yield the primitive of a parallelogram."""
    yield sheet_mesh("rectangle", shape.center, shape.u, shape.v)


def _disk(shape):
    """Yield the primitive of a disk."""
    normal = unit(shape.normal)
    t, b = (shape.radius * v for v in frame(normal))
    yield Part("disk", "disk", matrix(t, b, normal, shape.center), uv_map=CAP_UV)


def _box(shape):
    """Yield the mesh of a box."""
    yield Part("box", "mesh", mesh=box_mesh(shape.min, shape.max), uv_map=OWN_UV)


def _convex(shape):
    """Yield the mesh of a convex volume's facets."""
    volume = hull(shape.vertices) if shape.vertices is not None else intersection(shape.halfspaces)
    yield Part("convex", "mesh", mesh=convex_mesh(volume), uv_map=OWN_UV)


def _mesh(shape, resolve):
    """Yield the primitive of a mesh file."""
    file = mesh_file(shape, resolve)
    yield Part("mesh", file.plugin, file=file, uv_map=OWN_UV)


_PARTS = {"sphere": _sphere, "cylinder": _cylinder, "triangle": _triangle, "plane": _plane, "box": _box,
          "convex": _convex, "rectangle": _rectangle, "disk": _disk}


def parts(shape, resolve=None):
    """Return the list of primitives that stand for a shape of the description.

    `resolve` gives the path of a file that the scene names (`LoadedScene.resolve`); only meshes need it.
    """
    return list(_mesh(shape, resolve) if shape.type == "mesh" else _PARTS[shape.type](shape))


def textured_plane(shape):
    """Return the finite rectangle that stands for a textured plane in stock Mitsuba; its uv map is ours."""
    normal, half = unit(shape.normal), TEXTURED_PLANE_HALF_SIDE
    t, b = frame(normal)
    return Part("plane", "rectangle", matrix(half * t, half * b, normal, shape.point), uv_map=RECTANGLE_UV)


def far_plane(shape):
    """Return the disk that stands for a textured plane beyond its rectangle, just under it; without texture."""
    normal = unit(shape.normal)
    t, b = frame(normal)
    below = np.asarray(shape.point) - BELOW * normal
    return Part("far", "disk", matrix(PLANE_RADIUS * t, PLANE_RADIUS * b, normal, below))


def is_unbounded(shape):
    """Return whether a convex shape had to be clipped to become a mesh."""
    return shape.type == "convex" and shape.vertices is None and intersection(shape.halfspaces).clipped
