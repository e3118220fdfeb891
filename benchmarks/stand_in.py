"""Mitsuba in our tracer's place, called as ours is: a fair comparison must then find both equally fast."""

from __future__ import annotations

from dataclasses import dataclass

import mitsuba as mi
import numpy as np

from benchmarks import embree


@dataclass(frozen=True)
class Accel:
    """What is built; the arrays are kept for the picture only."""

    scene: object
    vertices: np.ndarray
    faces: np.ndarray
    pictures: dict  # DiffusePicture: its scene


def build(vertices, faces):
    """Return what the other functions trace, from (V, 3) float32 and (F, 3) uint32 on the host."""
    return Accel(embree.build(embree.mesh_of(vertices, faces)), vertices, faces, {})


def closest(accel, o, d, coherent):
    """Return lanes of distances and triangles; the distance of a miss is above NO_HIT."""
    return embree.closest(accel.scene, _ray(o, d), coherent)


def occluded(accel, o, d, distance, coherent):
    """Return lanes of whether anything is hit nearer than the distance."""
    ray = _ray(o, d)
    ray.maxt = mi.Float(distance)
    return embree.occluded(accel.scene, ray, coherent)[0]


def diffuse_path(accel, picture, samples, seed):
    """Return a DiffusePicture as lanes or arrays that numpy can read as (height, width, 3)."""
    if picture not in accel.pictures:
        accel.pictures[picture] = embree.DiffusePath(accel.vertices, accel.faces, picture)
    return accel.pictures[picture].render(samples, seed)


def _ray(o, d):
    """Return Mitsuba's rays from the renderer's lanes, which share the arrays."""
    return mi.Ray3f(mi.Point3f(*map(mi.Float, o)), mi.Vector3f(*map(mi.Float, d)))
