"""Frames, polygons and convex hulls in float64: the converters' own geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

STEEP = 0.9  # |n.y| from which the frame of n starts from +z, because +y is nearly parallel to n
CLIP_DISTANCE = 1e3  # scene units: unbounded volumes end here; farther facets would cost float32 digits
SAME_POINT = 1e-9  # corners closer than this, relative to the volume's size, are one corner
ON_PLANE = 1e-8  # corners closer than this to a plane, relative to the volume's size, lie on it


class EmptyVolume(ValueError):
    """The half-spaces have no common interior."""


def unit(vector):
    """Return the vector divided by its length, (..., 3) float64."""
    vector = np.asarray(vector, dtype=np.float64)
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def frame(normal):
    """Return the tangent t and bitangent b = n x t that texture coordinates of a unit normal n are measured along."""
    helper = (0.0, 1.0, 0.0) if abs(normal[1]) < STEEP else (0.0, 0.0, 1.0)
    tangent = unit(np.cross(normal, helper))
    return tangent, np.cross(normal, tangent)


def matrix(x, y, z, origin):
    """Return the 4 x 4 matrix that maps the unit axes to the columns x, y, z and the origin to `origin`."""
    result = np.eye(4)
    result[:3, 0], result[:3, 1], result[:3, 2], result[:3, 3] = x, y, z, origin
    return result


@dataclass(frozen=True)
class Mesh:
    """Triangles with a texture coordinate for each corner; corners of different facets are not shared."""

    vertices: np.ndarray  # (V, 3) float64, world space
    faces: np.ndarray  # (F, 3) int, counter-clockwise seen from outside
    uv: np.ndarray  # (V, 2) float64


@dataclass(frozen=True)
class Polyhedron:
    """A bounded convex volume: the points p with normals . p <= offsets, and its corners."""

    normals: np.ndarray  # (P, 3) float64, unit, outward
    offsets: np.ndarray  # (P,) float64
    corners: np.ndarray  # (C, 3) float64
    clipped: bool  # the half-spaces given had no bounded intersection; CLIP_DISTANCE bounds it


def box_polyhedron(low, high):
    """Return the axis-aligned box from corner `low` to corner `high`."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    return Polyhedron(normals, np.concatenate([np.asarray(high, float), -np.asarray(low, float)]), corners, False)


def hull(vertices):
    """Return the convex hull of (V, 3) points; raises EmptyVolume where they lie in one plane."""
    vertices = np.asarray(vertices, dtype=np.float64)
    try:
        found = ConvexHull(vertices)
    except QhullError as error:
        raise EmptyVolume(str(error).splitlines()[0]) from error
    planes = _distinct_planes(found.equations)
    return Polyhedron(planes[:, :3], -planes[:, 3], vertices[found.vertices], False)


def _distinct_planes(equations):
    """Return one row of (n, -d) for each plane: the hull's triangles share the plane of their facet."""
    kept = []
    for row in equations:
        if all(np.abs(row - other).max() > ON_PLANE * max(1.0, abs(row[3])) for other in kept):
            kept.append(row)
    return np.array(kept)


def intersection(halfspaces, centre=(0.0, 0.0, 0.0)):
    """Return the intersection of (H, 4) rows [nx, ny, nz, d], n . p <= d, clipped around `centre` where unbounded."""
    rows = np.asarray(halfspaces, dtype=np.float64)
    rows = rows / np.linalg.norm(rows[:, :3], axis=1, keepdims=True)
    cage = box_polyhedron(np.asarray(centre) - CLIP_DISTANCE, np.asarray(centre) + CLIP_DISTANCE)
    normals = np.concatenate([rows[:, :3], cage.normals])
    offsets = np.concatenate([rows[:, 3], cage.offsets])
    inside = _interior_point(normals, offsets)
    points = HalfspaceIntersection(np.column_stack([normals, -offsets]), inside).intersections
    points = _distinct_points(points[np.isfinite(points).all(axis=1)])
    size = np.ptp(points, axis=0).max()
    used = [(np.abs(points @ n - d) <= ON_PLANE * size).sum() >= 3 for n, d in zip(normals, offsets)]
    return Polyhedron(normals[used], offsets[used], points, any(used[len(rows):]))


def _interior_point(normals, offsets):
    """Return the centre of the largest ball inside the half-spaces; raises EmptyVolume where there is none."""
    column = np.ones((len(normals), 1))
    bounds = [(None, None)] * 3 + [(0, None)]
    found = linprog([0, 0, 0, -1], A_ub=np.hstack([normals, column]), b_ub=offsets, bounds=bounds)
    if not found.success or found.x[3] <= 0:
        raise EmptyVolume("the half-spaces have no common interior")
    return found.x[:3]


def _distinct_points(points):
    """Return the points without repetitions, which arise where more than three planes meet."""
    size, kept = np.ptp(points, axis=0).max(), []
    for point in points:
        if all(np.abs(point - other).max() > SAME_POINT * size for other in kept):
            kept.append(point)
    return np.array(kept)


def facets(volume):
    """Yield (normal, corners in counter-clockwise order seen from outside) for each facet of the polyhedron."""
    size = np.ptp(volume.corners, axis=0).max()
    for normal, offset in zip(volume.normals, volume.offsets):
        points = volume.corners[np.abs(volume.corners @ normal - offset) <= ON_PLANE * 10 * size]
        if len(points) < 3:
            continue
        tangent, bitangent = frame(normal)
        around = points - points.mean(axis=0)
        yield normal, points[np.argsort(np.arctan2(around @ bitangent, around @ tangent))]


def joined(meshes):
    """Return several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]),
                np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts)]),
                np.concatenate([mesh.uv for mesh in meshes]))


def mesh_of_facets(polygons):
    """Return the mesh of (corners (K, 3), uv (K, 2)) polygons, each a fan around its first corner."""
    vertices, faces, uv, start = [], [], [], 0
    for corners, coordinates in polygons:
        vertices.append(corners)
        uv.append(coordinates)
        faces += [(start, start + k, start + k + 1) for k in range(1, len(corners) - 1)]
        start += len(corners)
    return Mesh(np.concatenate(vertices), np.array(faces), np.concatenate(uv))


def convex_mesh(volume):
    """Return the polyhedron's mesh; uv are distances from the world origin along the frame of each facet."""
    return mesh_of_facets((points, np.stack([points @ axis for axis in frame(normal)], axis=1))
                          for normal, points in facets(volume))


def box_mesh(low, high):
    """Return the box's mesh of 24 corners; every face shows the whole texture, as it is read from outside."""
    low, high = np.asarray(low, float), np.asarray(high, float)

    def face_uv(normal, points):
        x, y, z = ((points - low) / (high - low)).T
        axis = int(np.argmax(np.abs(normal)))
        positive = [(z, 1 - y), (x, 1 - z), (1 - x, 1 - y)]
        negative = [(1 - z, 1 - y), (x, z), (x, 1 - y)]
        return np.stack((positive if normal[axis] > 0 else negative)[axis], axis=1)

    return mesh_of_facets((points, face_uv(normal, points)) for normal, points in facets(box_polyhedron(low, high)))
