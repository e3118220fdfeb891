"""Rays at shapes: what the renderer and Mitsuba find on the same float32 input. Not a case by itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import drjit as dr
import numpy as np

from converters.solids import parts
from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.numeric import FAR
from renderer.core.records import Ray
from renderer.core.rows import Rows
from renderer.engine import queries
from renderer.scene import schema
from renderer.scene.geometry import Geometry, ShapeGroup
from renderer.shapes import KINDS
from tests.stability.case import mitsuba

EXACT = np.longdouble  # yardsticks: 64 bits of mantissa where the machine has them


@dataclass(frozen=True)
class Found:
    """Hits of N rays as float64: distance (N,), infinity for none, point (NaN for none) and normal (N, 3)."""

    t: np.ndarray
    p: np.ndarray
    n: np.ndarray

    @property
    def hit(self):
        """Whether anything was hit, (N,)."""
        return np.isfinite(self.t)


def sphere(center, radius):
    """Return a sphere with float32 numbers."""
    return schema.Sphere(center=singles(center), radius=single(radius))


def single(value):
    """Return the float32 nearest to a number, as a Python float."""
    return float(np.float32(value))


def singles(values):
    """Return the float32 numbers nearest to some, as a tuple."""
    return tuple(np.asarray(values, np.float32).astype(np.float64).tolist())


def vectors(array):
    """Return an (N, 3) array as lanes."""
    return Vector3f(*np.ascontiguousarray(np.asarray(array, np.float32).T))


def unit(array):
    """Return (N, 3) vectors at unit length but for float32's rounding."""
    array = np.asarray(array, EXACT)
    return (array / np.sqrt((array * array).sum(-1, keepdims=True))).astype(np.float32)


def several(shape):
    """Return a tuple of shapes: of one, or as it is."""
    return shape if isinstance(shape, tuple) else (shape,)


@lru_cache(maxsize=64)
def geometry(*shapes):
    """Return the renderer's Geometry of some shapes of one kind."""
    kind = KINDS[shapes[0].type]
    columns = kind.columns(shapes) if kind.columns else None
    rows = Rows([kind.pack(shape, columns) for shape in shapes], directions=kind.directions)
    return Geometry((ShapeGroup(kind, rows, 0),), None, None, len(shapes))


def ours(shape, o, d, left_inwards=None):
    """Return what the renderer finds; `left_inwards` tells of rays that start on the shape which way they go.

    `shape` is one, or a tuple of some of one kind; likewise for Mitsuba.
    """
    shapes = geometry(*several(shape))
    ray = Ray(vectors(o), vectors(d))
    if left_inwards is not None:
        ray.left_index, ray.left_inwards = dr.zeros(UInt32, len(o)), Bool(np.broadcast_to(left_inwards, len(o)))
    hit = queries.closest(shapes, ray)
    surface = shapes.surface(ray, hit, with_uv=False)
    t = np.where(np.array(hit.valid), doubles(hit.t), np.inf)
    return Found(t, np.where(np.isfinite(t), doubles(surface.p), np.nan).T, doubles(surface.n_geo).T)


def theirs(shape, o, d):
    """Return what Mitsuba finds."""
    mi = mitsuba()
    found = stage(*several(shape)).ray_intersect(mi.Ray3f(mi.Point3f(*columns(o)), mi.Vector3f(*columns(d))))
    p = np.where(np.isfinite(t := doubles(found.t)), doubles(found.p), np.nan)
    return Found(t, p.T, doubles(found.n).T)


def our_shadows(shape, o, d):
    """Return which rays the renderer finds blocked: at distance 1, without points and normals."""
    blocked = queries.occluded(geometry(shape), Ray(vectors(o), vectors(d)), Float(FAR))
    return Found(np.where(np.array(blocked), 1, np.inf), None, None)


def mitsuba_shadows(shape, o, d):
    """Return which rays Mitsuba finds blocked, likewise."""
    mi = mitsuba()
    blocked = stage(shape).ray_test(mi.Ray3f(mi.Point3f(*columns(o)), mi.Vector3f(*columns(d))))
    return Found(np.where(np.array(blocked), 1, np.inf), None, None)


@lru_cache(maxsize=64)
def stage(*shapes):
    """Return Mitsuba's scene of some shapes, without materials, lights and sensors."""
    mi, scene = mitsuba(), {"type": "scene"}
    everything = [(shape, part) for shape in shapes for part in parts(shape)]
    for number, (shape, part) in enumerate(everything):
        name = f"{part.name}{number}"
        if part.mesh is not None:
            scene[name] = mitsuba_mesh(name, part.mesh.vertices, part.mesh.faces)
        elif shape.type == "sphere":
            scene[name] = {"type": "sphere", "center": list(shape.center), "radius": shape.radius}
        else:
            scene[name] = {"type": part.kind, "to_world": mi.ScalarTransform4f(part.to_world)}
    return mi.load_dict(scene)


def mitsuba_mesh(name, vertices, faces):
    """Return Mitsuba's mesh of (V, 3) vertices and of faces, three numbers of vertices each, without normals."""
    mi = mitsuba()
    mesh = mi.Mesh(name, len(vertices), np.size(faces) // 3)
    content = mi.traverse(mesh)
    content["vertex_positions"] = mi.Float(np.float32(vertices).ravel())
    content["faces"] = mi.UInt32(np.uint32(faces).ravel())
    content.update()
    return mesh


def columns(array):
    """Return the columns of an (N, 3) array, contiguous and in single precision."""
    return [*np.ascontiguousarray(np.asarray(array, np.float32).T)]


def doubles(lanes):
    """Return lanes as a float64 array."""
    return np.array(lanes, np.float64)


def dot(a, b):
    """Return the dot products of (N, 3) arrays in the yardstick's precision."""
    return (np.asarray(a, EXACT) * np.asarray(b, EXACT)).sum(-1)


def at(o, d, t):
    """Return the exact points o + t d, NaN where t is infinite."""
    return np.asarray(o, EXACT) + np.asarray(d, EXACT) * np.where(np.isfinite(t), t, np.nan)[:, None]
