"""Shapes at any scale and place, and rays that leave them: ours, and by a fixed epsilon. Not a case by itself."""

from __future__ import annotations

from functools import lru_cache

import drjit as dr
import numpy as np

from renderer.core.backend import Bool, Float, UInt32
from renderer.core.records import Hit, Ray
from renderer.core.rows import Rows
from renderer.scene import schema
from renderer.scene.geometry import Geometry, ShapeGroup, leave
from renderer.shapes import KINDS
from tests.stability import probe
from tests.stability.case import mitsuba
from tests.support import soups

EPSILON = 1e-4  # scene units: the usual one
TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]  # along no axis
RECORDS = {"sphere": schema.Sphere, "cylinder": schema.Cylinder, "box": schema.Box, "convex": schema.Convex,
           "triangle": schema.Triangle, "rectangle": schema.Rectangle, "disk": schema.Disk, "plane": schema.Plane}
POINTS = {"center", "point", "min", "max", "v0", "v1", "v2", "vertices"}  # keys that are moved and scaled
LENGTHS = {"radius", "height", "u", "v"}  # that are scaled
# name -> (scale, middle in sizes): from tiny to giant, and so far off that points are known to 1e-4 of a size
PLACES = {"tiny": (1e-4, 1), "small, aside": (1e-2, 300), "plain": (1, 0), "aside": (1, 20), "far": (1, 1e3),
          "giant": (1e6, 0.5), "giant, far": (1e3, 1e3)}  # fmt: skip


def placed(kind, place, **keys):
    """Return a shape of unit size in a place of PLACES, its numbers rounded to float32."""
    scale, sizes = PLACES[place]
    middle = scale * sizes * np.array([0.9, -0.7, 1.0])

    def put(name, value):
        value = np.asarray(value, float)
        value = scale * value + middle if name in POINTS else scale * value if name in LENGTHS else value
        single = np.float32(value).astype(float).tolist()
        return tuple(map(tuple, single)) if value.ndim == 2 else tuple(single) if value.ndim else single

    return RECORDS[kind](**{name: put(name, value) for name, value in keys.items()})


@lru_cache(maxsize=256)
def scene(*shapes):
    """Return the Geometry of shapes without a structure; those of one kind are neighbours."""
    groups, first = [], 0
    for name in dict.fromkeys(shape.type for shape in shapes):
        kind, own = KINDS[name], [shape for shape in shapes if shape.type == name]
        columns = kind.columns(own) if kind.columns else None
        groups.append(ShapeGroup(kind, Rows([kind.pack(s, columns) for s in own], directions=kind.directions), first))
        first += len(own)
    return Geometry(tuple(groups), None, None, len(shapes))


def mesh(corners):
    """Return the Geometry of a mesh of (T, 3, 3) corners in a hierarchy."""
    return soups.geometry(np.float32(corners), "bvh")


def seen(geometry, o, d):
    """Return what rays (N, 3) meet, and the surface there."""
    ray = Ray(probe.vectors(o), probe.vectors(d))
    hit = geometry.intersect(ray)
    surface = geometry.surface(ray, hit, with_uv=False)
    dr.eval(hit, surface)
    return hit, surface


def below(geometry, index, p, n, height):
    """Return the hit and surface of shapes `index` (int) at points (N, 3), as rays from `height` above find them."""
    lanes = len(p)
    ray = Ray(probe.vectors(p + height * n), probe.vectors(np.broadcast_to(-n, p.shape)))
    hit = Hit(dr.full(Float, height, lanes), dr.full(UInt32, index, lanes))
    surface = geometry.surface(ray, hit, with_uv=False)
    dr.eval(hit, surface)
    return hit, surface


def ours(hit, surface, d):
    """Return rays that leave as the renderer's do."""
    return leave(surface, hit.index, probe.vectors(d))


def by_epsilon(hit, surface, d):
    """Return rays that start the usual epsilon along their way, and have left no shape."""
    d = probe.vectors(d)
    return Ray(dr.fma(d, EPSILON, surface.p), d)


def meets(geometry, ray):
    """Return whether rays meet anything (N,), and at which distance, infinity for none."""
    hit = geometry.intersect(ray)
    valid = hit.valid.numpy()
    return valid, np.where(valid, hit.t.numpy(), np.inf)


def blocked(geometry, ray, distance):
    """Return whether anything lies on rays before a distance, by the query for shadows and by the closest hit."""
    distance = np.float32(np.broadcast_to(distance, len(np.array(ray.d.x))))
    shadow = geometry.occluded(ray, Float(distance), Bool(True)).numpy()
    _, t = meets(geometry, ray)
    return shadow, t < distance * (1 - 1e-6)


def hemisphere(n, rng):
    """Return unit directions, a cosine's density around normals (N, 3), and half of them within 1e-3 of the surface."""
    n = np.asarray(n, float)
    u = rng.random((len(n), 2))
    up = np.where(rng.random(len(n)) < 0.5, np.sqrt(u[:, 0]), 1e-3 * u[:, 0])[:, None]
    x = np.cross(n, np.eye(3)[np.abs(n).argmin(1)])
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    angle = 2 * np.pi * u[:, 1:]
    return probe.unit(np.sqrt(1 - up**2) * (np.cos(angle) * x + np.sin(angle) * np.cross(n, x)) + up * n)


def theirs(shapes, o, d):
    """Return Mitsuba's scene of shapes, or of (T, 3, 3) corners, and its interactions with rays."""
    mi = mitsuba()
    stage = mitsuba_scene(shapes)
    return stage, stage.ray_intersect(mi.Ray3f(mi.Point3f(*probe.columns(o)), mi.Vector3f(*probe.columns(d))))


def mitsuba_scene(shapes):
    """Return Mitsuba's scene of a tuple of shapes, or of a mesh of (T, 3, 3) corners."""
    mi = mitsuba()
    level = mi.log_level()
    mi.set_log_level(mi.LogLevel.Error)  # it warns of rounded rotations
    try:
        if isinstance(shapes, tuple):
            return probe.stage(*shapes)
        mesh = probe.mitsuba_mesh("mesh", np.reshape(shapes, (-1, 3)), np.arange(3 * len(shapes)))
        return mi.load_dict({"type": "scene", "mesh": mesh})
    finally:
        mi.set_log_level(level)


def vector(mi, d):
    """Return (N, 3) as Mitsuba's vectors."""
    return mi.Vector3f(*probe.columns(d))


def hull(shape):
    """Return unit half-spaces (H, 4), n.p + d <= 0, of a convex shape of corners, in double precision."""
    from scipy.spatial import ConvexHull

    return ConvexHull(np.array(shape.vertices)).equations
