"""Triangles: needles, seen edge-on, and from far away.

4000 triangles of size 1 and thickness 1 to 1e-5 at 8 rays each, that come from 0.1 to 1000 sizes away at angles with
cosines from 1 to 1e-5. The textbook's test takes the distance from products of two edges, of which almost nothing is
left of a needle. `triangle` shapes have unit normal and dual edges from double precision instead; meshes keep corners
only and weight their depths, so that a hit is no farther from the triangle than the corners' rounding. A roundoff is
2^-24 of the distance between ray and triangle. (u and v have no case: their errors are within 3 roundoffs over the
triangle's height and the cosine, and so are the textbook's and Mitsuba's.) Points of meshes lie off their plane by less
than the bound by which rays start off it (`renderer/scene/triangles.py`), also 1e6 sizes from the world's origin.
"""

from functools import lru_cache

import drjit as dr
import numpy as np

from renderer.accel import watertight
from renderer.core.backend import UInt32
from renderer.core.records import Ray
from renderer.core.rows import Rows
from renderer.scene import schema
from renderer.shapes import KINDS
from tests.stability import probe, stage
from tests.stability.case import ULP, Case
from tests.support.soups import ball

COUNT, RAYS = 4000, 8
SIZES = 1.0, 1e3, 1e4, 1e6  # from the world's origin, of the last case
SHAPE = KINDS["triangle"]


def unit64(v):
    """Return (..., 3) float64 vectors at unit length."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@lru_cache(maxsize=1)
def inputs():
    """Return (N, 3, 3) float32 corners, float32 rays (o, d), exact normals and t, distance of corners, what counts.

    What counts are rays that pass no edge within a fiftieth of the triangle, and whose side of the plane is not lost
    in the rounding of d.
    """
    rng = np.random.default_rng(41)
    along, beside = unit64(rng.normal(size=(2, COUNT, 3)))
    across = unit64(np.cross(along, beside))
    thin = 10 ** rng.uniform(-5, 0, (COUNT, 1))
    corners = np.stack([-0.5 * along, 0.5 * along, rng.uniform(-0.4, 0.4, (COUNT, 1)) * along + thin * across], 1)
    corners = np.float32(corners + rng.uniform(-0.5, 0.5, (COUNT, 1, 3)))
    order = rng.permuted(np.tile(np.arange(3), (COUNT, 1)), axis=1)
    corners = np.repeat(corners[np.arange(COUNT)[:, None], order], RAYS, 0)
    v = corners.astype(probe.EXACT)
    n = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    n /= np.sqrt(probe.dot(n, n))[:, None]
    aim = np.einsum("nk,nkx->nx", rng.dirichlet((2, 2, 2), len(v)), v)
    cosine = 10 ** rng.uniform(-5, 0, (len(v), 1)) * rng.choice([-1, 1], (len(v), 1))
    flat = unit64(np.cross(n, rng.normal(size=n.shape)).astype(float))
    way = cosine * n + np.sqrt(1 - cosine**2) * flat
    o = np.float32(aim - 10 ** rng.uniform(-1, 3, (len(v), 1)) * way)
    d = probe.unit(aim - o)
    t = probe.dot(n, v[:, 0] - o) / probe.dot(n, d)
    p = o + t[:, None] * d.astype(probe.EXACT)
    duals = [np.cross(v[:, 2] - v[:, 0], n), np.cross(n, v[:, 1] - v[:, 0])]
    edges = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    duals = [dual / probe.dot(dual, edge)[:, None] for dual, edge in zip(duals, edges)]
    weights = np.stack([probe.dot(dual, p - v[:, 0]) for dual in duals], 1)
    margin = (np.column_stack([weights, 1 - weights.sum(1)]).min(1) > 0.02) & (abs(probe.dot(n, d)) > 5e-6) & (t > 0)
    distance = np.abs(v - o[:, None]).max((1, 2)).astype(float)
    return corners, o, d, n, t, distance, margin


def off_plane(met, t):
    """Return how far from the plane the points at distances t are, in roundoffs, where something is said to be met."""
    _, _, d, n, exact, distance, good = inputs()
    d, n, exact, distance, t = (part[good & met] for part in (d, n, exact, distance, t))
    return (np.abs(t - exact) * np.abs(probe.dot(n, d)) / (ULP * distance)).astype(float)


def off_triangle(met, t):
    """Return how far from the triangle, its edges included, they are."""
    corners, o, d, _, _, distance, good = inputs()
    corners, o, d, distance, t = (part[good & met] for part in (corners, o, d, distance, t))
    v, p = corners.astype(float), (o + t[:, None] * d.astype(probe.EXACT)).astype(float)
    best = np.full(len(p), np.inf)
    inside = np.ones(len(p), bool)
    n = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    for a, b in ((0, 1), (1, 2), (2, 0)):
        edge, to = v[:, b] - v[:, a], p - v[:, a]
        share = np.clip((to * edge).sum(1) / (edge * edge).sum(1), 0, 1)
        best = np.minimum(best, np.linalg.norm(to - share[:, None] * edge, axis=1))
        inside &= (np.cross(edge, to) * n).sum(1) >= 0
    flat = np.abs(((p - v[:, 0]) * n).sum(1)) / np.linalg.norm(n, axis=1)
    return np.where(inside, flat, best) / (ULP * distance)


@lru_cache(maxsize=1)
def shapes():
    """Return the records of all triangles as shapes, and each ray's number among them."""
    corners = inputs()[0][::RAYS].astype(float)
    made = [schema.Triangle(**dict(zip(("v0", "v1", "v2"), map(tuple, c.tolist())))) for c in corners]
    return Rows([SHAPE.pack(shape, None) for shape in made]), UInt32(np.arange(COUNT * RAYS) // RAYS)


def rays():
    """Return the rays."""
    _, o, d, *_ = inputs()
    return Ray(probe.vectors(o), probe.vectors(d))


def of_shapes():
    """Return where `triangle` shapes are met, and the distances, (N,) each."""
    rows, number = shapes()
    row, ray = rows.row(number, True), rays()
    met, t = SHAPE.distance(row, ray)
    return met.numpy(), probe.doubles(t)


def of_meshes():
    """Return the same of triangles in the leaves of a hierarchy, without its boxes."""
    corners, axes = inputs()[0], watertight.Axes.of(rays())
    v = [probe.vectors(corners[:, k]) for k in (0, 1, 2, 2)]
    words = [dr.reinterpret_array(UInt32, corner[axis]) for corner in v for axis in range(3)] + [UInt32(0)] * 4
    (met, t, _), _ = watertight.test(words, axes)
    return met.numpy() & np.isfinite(probe.doubles(t)), probe.doubles(t)


def textbook():
    """Return the same by the textbook's test, in single precision."""
    corners, o, d, *_ = inputs()
    e1, e2, to = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], o - corners[:, 0]
    p, q = np.cross(d, e2), np.cross(to, e1)
    with np.errstate(all="ignore"):
        inverse = 1 / (e1 * p).sum(1)
        u, v, t = (to * p).sum(1) * inverse, (d * q).sum(1) * inverse, (e2 * q).sum(1) * inverse
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & np.isfinite(t)
    return met, t.astype(float)


def theirs():
    """Return the same of Mitsuba's mesh of them all, where a ray meets the triangle that is meant."""
    corners, o, d, *_ = inputs()
    _, found = stage.theirs(corners[::RAYS], o, d)
    met = found.is_valid().numpy() & (found.prim_index.numpy() == np.arange(len(o)) // RAYS)
    return met, probe.doubles(found.t)


# Points of meshes, and the bound by which rays start off them


@lru_cache(maxsize=4)
def far_mesh(sizes):
    """Return corners (T, 3, 3) of a bumpy ball so many sizes from the world's origin, and rays at its triangles."""
    rng = np.random.default_rng(43)
    v, faces = ball(24, 0.15)
    middle = sizes * np.array([0.9, -0.7, 1.0])
    corners = np.float32(v + middle)[faces]
    aim = np.einsum("nk,nkx->nx", rng.dirichlet((1, 1, 1), 40_000), corners[rng.integers(len(corners), size=40_000)])
    o = np.float32(middle + (2 + sizes * rng.random((len(aim), 1))) * unit64(rng.normal(size=aim.shape)))
    return corners, o, probe.unit(aim - o)


def of_bound(points):
    """Return how far points lie off their triangle's plane, over the bound; `points` (ray, surface) gives them."""
    errors = []
    for sizes in SIZES:
        corners, o, d = far_mesh(sizes)
        hit, surface = stage.seen(stage.mesh(corners), o, d)
        valid = hit.valid.numpy()
        p = points((o, d, hit), surface)[valid]
        errors.append(_over_bound(corners, hit.index.numpy()[valid], p, surface.rounding.numpy()[valid]))
    return np.concatenate(errors)


def of_bound_mitsuba():
    """Return the same of Mitsuba's points, over our bound for them."""
    errors = []
    for sizes in SIZES:
        corners, o, d = far_mesh(sizes)
        _, found = stage.theirs(corners, o, d)
        hit, surface = stage.seen(stage.mesh(corners), o, d)
        index = found.prim_index.numpy()
        same = hit.valid.numpy() & found.is_valid().numpy() & (hit.index.numpy() == index)
        errors.append(_over_bound(corners, index[same], probe.doubles(found.p).T[same], surface.rounding.numpy()[same]))
    return np.concatenate(errors)


def _over_bound(corners, index, p, bound):
    """Return how far points are off their triangles' planes, in units of the bound."""
    v = corners[index].astype(float)
    n = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    area = np.linalg.norm(n, axis=1)
    thick = area > 0  # far away some have none
    return (np.abs(((p - v[:, 0]) * n).sum(1))[thick] / area[thick]) / bound[thick]


def along_ray(seen, _):
    """Return points as the textbook has them, origin plus distance times direction."""
    o, d, hit = seen
    return o + np.where(hit.valid.numpy(), hit.t.numpy(), 0)[:, None] * d


CASES = (
    Case("needles and triangles seen edge-on: distance of hits from their plane", "roundoffs", 10,
         "a difference, the normal, three products and their sums above and below the line, a division",
         lambda: off_plane(*of_shapes()), lambda: off_plane(*textbook()), "Moeller and Trumbore",
         lambda: off_plane(*theirs()), "asked where the triangle that is meant is met first, one ray in 60"),
    Case("the same in meshes: distance of hits from the triangle", "roundoffs", 12,
         "the hit is a mean of corners, each projected within 8; 4 for depth and the length of d",
         lambda: off_triangle(*of_meshes()), lambda: off_triangle(*textbook()), "Moeller and Trumbore",
         lambda: off_triangle(*theirs()), "asked as above"),
    Case("points of meshes up to 1e6 sizes from the origin", "of the bound", 1,
         "that of two roundings of a corner's coordinates and four of edges",
         lambda: of_bound(lambda _, surface: probe.doubles(surface.p).T), lambda: of_bound(along_ray),
         "origin plus distance times direction", of_bound_mitsuba),
)
