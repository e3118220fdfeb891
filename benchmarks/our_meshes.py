"""Our side of the comparison of meshes: the renderer's own structure and queries, over arrays."""

from __future__ import annotations

from benchmarks.diffuse_path import DiffusePath
from renderer.core.records import Ray
from renderer.engine import queries
from renderer.scene.geometry import Geometry
from renderer.scene.meshes import plain_triangles
from renderer.scene.structures import structure_over


def build(vertices, faces):
    """Return the Geometry of one mesh, from (V, 3) float32 and (F, 3) uint32 on the host."""
    triangles = plain_triangles(vertices, faces)
    return Geometry((), triangles, structure_over(triangles), 1)


def closest(accel, o, d, coherent):
    """Return lanes of distances and triangles."""
    hit = queries.closest(accel, Ray(o, d), coherent)
    return hit.t, hit.index


def occluded(accel, o, d, distance, coherent):
    """Return lanes of whether anything is hit nearer than the distance."""
    return queries.occluded(accel, Ray(o, d), distance, coherent)


def diffuse_path(accel, picture, samples, seed):
    """Return a DiffusePicture as an array (height, width, 3)."""
    return DiffusePath(accel, picture).render(samples, seed)
