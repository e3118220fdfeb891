"""Vertex normals for meshes that bring none: the mean of the normals around a vertex, weighted by angle.

The angle that a triangle takes at a vertex is the weight that makes the mean independent of how the surface around it
is cut into triangles [Thurmer1998].
"""

from __future__ import annotations

import numpy as np

BLOCK = 2**16  # triangles at a time: temporary arrays stay in the cache and small beside the mesh


def smooth_normals(vertices, faces):
    """Return (V, 3) float32 unit normals, to the side from which the triangles are counterclockwise.

    vertices: (V, 3) floats; faces: (F, 3) integers. Triangles without area do not count. A vertex that no other
    triangle has, or around which the normals cancel out, gets (0, 0, 0).
    """
    sums = np.zeros((3, len(vertices)))
    centre, extent = _frame(vertices)
    for start in range(0, len(faces), BLOCK):
        block = faces[start : start + BLOCK]
        weighted = _weighted((vertices[block].astype(np.float64) - centre) / extent)  # (f, corner, axis)
        corners = block.reshape(-1)
        for axis in range(3):
            np.add.at(sums[axis], corners, weighted[:, :, axis].reshape(-1))
    lengths = np.sqrt((sums**2).sum(0))
    # What is left where normals cancel out is rounding: of sums of a few terms of at most pi.
    defined = lengths > 1e-12
    return np.ascontiguousarray(np.where(defined, sums / np.where(defined, lengths, 1.0), 0.0).T, np.float32)


def _frame(vertices):
    """Return a point amid the vertices and their extent, so that products neither overflow nor vanish."""
    low, high = vertices.min(0).astype(np.float64), vertices.max(0).astype(np.float64)
    return (low + high) / 2, max(float((high - low).max()), np.finfo(np.float64).tiny)


def _weighted(corners):
    """Return (f, 3, 3): for each corner of each triangle, the triangle's unit normal times the angle there."""
    edges = np.roll(corners, -1, axis=1) - corners  # from each corner to the next
    normals = np.cross(edges[:, 0], edges[:, 1])
    doubled = np.sqrt((normals**2).sum(-1, keepdims=True))  # twice the area
    has_area = doubled > 0
    normals = np.where(has_area, normals / np.where(has_area, doubled, 1.0), 0.0)
    # sin and cos of the angle between the edges that leave a corner, times their lengths; the sine's part is the same
    # for all three. Nothing is lost near 0 and pi, where an arc cosine loses half the digits.
    cosines = -(edges * np.roll(edges, 1, axis=1)).sum(-1)
    return np.arctan2(doubled, cosines)[:, :, None] * normals[:, None, :]
