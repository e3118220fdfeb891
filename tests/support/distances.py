"""Signed distances to shapes in float64 numpy, written down independently of the renderer: negative inside.

For polyhedra it is a lower bound of the distance outside, which is enough for marching along a ray.
"""

import numpy as np
from scipy.spatial import ConvexHull


def signed_distance(shape, p):
    """Return the (N,) signed distances of points (N, 3) to a shape given as its JSON object; sheets are unsigned."""
    return FORMULAE[shape["type"]](shape, np.asarray(p, np.float64))


def _sphere(shape, p):
    """Distance to the middle, less the radius."""
    return np.linalg.norm(p - shape["center"], axis=-1) - shape["radius"]


def _cylinder(shape, p):
    """Distance to the box that a cylinder is in (distance along, distance across)."""
    axis = np.asarray(shape["axis"]) / np.linalg.norm(shape["axis"])
    q = p - shape["center"]
    along = np.abs(q @ axis) - shape["height"]
    across = np.linalg.norm(np.cross(q, axis), axis=-1) - shape["radius"]
    outside = np.hypot(np.maximum(along, 0), np.maximum(across, 0))
    return outside + np.minimum(np.maximum(along, across), 0)


def _box(shape, p):
    """Distance in one octant around the box's corner."""
    low, high = np.asarray(shape["min"]), np.asarray(shape["max"])
    q = np.abs(p - 0.5 * (low + high)) - 0.5 * (high - low)
    return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(-1), 0)


def _convex(shape, p):
    """Greatest distance to a plane."""
    if "halfspaces" in shape:
        planes = np.asarray(shape["halfspaces"], float)
        planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
        normals, offsets = planes[:, :3], planes[:, 3]
    else:
        equations = ConvexHull(shape["vertices"]).equations
        normals, offsets = equations[:, :3], -equations[:, 3]
    return (p @ normals.T - offsets).max(-1)


def _triangle(shape, p):
    """Distance to the nearest point of the triangle: over its inside, or over one of its three edges."""
    v = [np.asarray(shape[name], float) for name in ("v0", "v1", "v2")]
    n = np.cross(v[1] - v[0], v[2] - v[0])
    n /= np.linalg.norm(n)
    edges, inside = [], np.ones(len(p), bool)
    for a, b in zip(v, v[1:] + v[:1]):
        along = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)[:, None]
        edges.append(np.linalg.norm(p - a - along * (b - a), axis=-1))
        inside &= (p - a) @ np.cross(n, b - a) >= 0
    return np.where(inside, np.abs((p - v[0]) @ n), np.min(edges, axis=0))


def _rectangle(shape, p):
    """Distance to a parallelogram, as two triangles that share a diagonal."""
    c, u, v = (np.asarray(shape[name], float) for name in ("center", "u", "v"))
    a, b, c, d = (c + x * u + y * v for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)))
    halves = ({"v0": a, "v1": b, "v2": c}, {"v0": a, "v1": c, "v2": d})
    return np.min([_triangle(half, p) for half in halves], axis=0)


def _disk(shape, p):
    """Distance to the disk, in the plane of the axis and the point."""
    n = np.asarray(shape["normal"]) / np.linalg.norm(shape["normal"])
    q = p - shape["center"]
    along = q @ n
    across = np.linalg.norm(q - along[:, None] * n, axis=-1)
    return np.hypot(along, np.maximum(across - shape["radius"], 0))


def _plane(shape, p):
    """Distance to a plane, unsigned."""
    n = np.asarray(shape["normal"]) / np.linalg.norm(shape["normal"])
    return np.abs((p - shape["point"]) @ n)


FORMULAE = {
    "sphere": _sphere, "cylinder": _cylinder, "box": _box, "convex": _convex, "triangle": _triangle, "plane": _plane,
    "rectangle": _rectangle, "disk": _disk,
}  # fmt: skip


def march(shape, o, d, steps=4000, reach=1e4, precision=1e-10):
    """Return the (N,) distances at which rays first meet the shape, infinity where they do not; undecided is NaN."""
    t = np.zeros(len(o))
    for _ in range(steps):
        gap = np.abs(signed_distance(shape, o + t[:, None] * d))
        moving = (gap > precision) & (t < reach)
        if not moving.any():
            break
        t = np.where(moving, t + gap, t)
    gap = np.abs(signed_distance(shape, o + t[:, None] * d))
    return np.where(gap <= precision, t, np.where(t >= reach, np.inf, np.nan))
