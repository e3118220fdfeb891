"""Triangles to trace rays through: soups that are hard on a structure, closed meshes, and what float64 says of them."""

import drjit as dr
import numpy as np

from renderer.core.backend import Float, Vector3f
from renderer.core.numeric import EPSILON
from renderer.core.records import Ray
from renderer.scene.geometry import Geometry
from renderer.scene.meshes import plain_triangles
from renderer.scene.structures import structure_over

PROJECTION_ROUNDOFFS = 8  # of |corner - o|: a difference, a basis orthonormal to 2, and a sum of three products


def vectors(points):
    """Return host points, (N, 3), as lanes; copied, because memory of numpy need not be aligned."""
    one = dr.opaque(Float, 1)
    return Vector3f(*(Float(np.ascontiguousarray(axis, np.float32)) * one for axis in np.asarray(points).T))


def geometry(corners, accel):
    """Return the Geometry of one mesh, (T, 3, 3) float32, as scenes are arranged with the structure `accel`."""
    triangles = plain_triangles(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    return Geometry((), triangles, structure_over(triangles, accel=accel), 1)


def unit(directions):
    """Return directions, (N, 3), of unit length to the rounding of float32."""
    d = np.asarray(directions, np.float64)
    return np.float32(d / np.linalg.norm(d, axis=1, keepdims=True))


def closest_index(scene, o, d):
    """Return the triangles, (N,), that rays with origins and directions (N, 3) meet first, NO_SHAPE for none."""
    return scene.intersect(Ray(vectors(o), vectors(d))).index.numpy()


# Closed meshes


def ball(rows, bumps=0.0):
    """Return vertices (V, 3) float64 and faces (8 rows^2, 3) of an octahedron blown up to the unit sphere.

    Faces wind outwards. `bumps` is the depth of waves in the radius; the mesh stays visible from its middle.
    """
    lattice = _octahedron(rows)
    points, faces = np.unique(lattice.reshape(-1, 3), axis=0, return_inverse=True)
    v = points / np.linalg.norm(points, axis=1, keepdims=True)
    radius = 1 + bumps * np.sin(7 * v[:, 0] + 1) * np.sin(9 * v[:, 1]) * np.cos(8 * v[:, 2])
    return v * radius[:, None], faces.reshape(-1, 3)


def dyadic_ball(rows, bits=10):
    """Return the same with all coordinates multiples of 2^-bits, so that midpoints of edges are floats too."""
    v, faces = ball(rows, 0.1)
    return np.round(v * 2.0**bits) * 2.0**-bits, faces


def _octahedron(rows):
    """Return the triangles, (8 rows^2, 3, 3) integers, of the octahedron |x| + |y| + |z| = rows."""
    i, j = (part.ravel() for part in np.meshgrid(np.arange(rows), np.arange(rows), indexing="ij"))

    def corner(di, dj, where):
        return np.stack([i + di, j + dj, rows - i - j - di - dj], -1)[where]

    up, down = i + j < rows, i + j < rows - 1
    flat = np.concatenate([
        np.stack([corner(*at, up) for at in ((0, 0), (1, 0), (0, 1))], 1),
        np.stack([corner(*at, down) for at in ((1, 0), (1, 1), (0, 1))], 1),
    ])  # fmt: skip
    signs = np.stack(np.meshgrid([1, -1], [1, -1], [1, -1], indexing="ij"), -1).reshape(-1, 1, 1, 3)
    mirrored = flat * signs
    odd = signs.prod(-1).ravel() < 0
    mirrored[odd] = mirrored[odd][:, :, ::-1]
    return mirrored.reshape(-1, 3, 3)


def cube():
    """Return vertices and faces of the cube from -1 to 1, wound outwards."""
    v = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return v, np.array([(a, b, c) for a, b, c, d in quads] + [(a, c, d) for a, b, c, d in quads])


def write_obj(path, vertices, faces):
    """Write a mesh as an OBJ file with coordinates that read back to the same doubles."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path.name


# Soups: (T, 3, 3) float32


def _soup(rng, count=300):
    """Small triangles anywhere in a cube."""
    return rng.random((count, 1, 3)) + 0.3 * (rng.random((count, 3, 3)) - 0.5)


def _bumpy(rng):
    """A closed mesh with waves."""
    v, faces = ball(8, 0.15)
    return v[faces]


def _needles(rng, count=300):
    """Triangles a thousand times as long as wide."""
    along, across = rng.normal(size=(2, count, 3))
    start = rng.random((count, 3))
    return np.stack([start, start + along, start + along + 1e-3 * across], 1)


def _huge_among_tiny(rng):
    """One triangle through a crowd of small ones."""
    huge = [[[-500, -400, 0.1], [700, -300, 0.4], [0, 900, 0.7]]]
    return np.concatenate([0.05 * _soup(rng, 200) + 0.5, huge, 0.05 * _soup(rng, 99) + 0.2])


def _concentric(rng, count=200):
    """Triangles whose boxes all have the same middle."""
    half = rng.random((count, 3)) + 0.1
    return np.stack([half, -half, half * rng.choice([-1, 1], (count, 3))], 1)


def _flat(rng):
    """A soup in one plane."""
    return _soup(rng) * [1, 1, 0] + [0, 0, 0.25]


def _grid(rng, side=12):
    """Quads in the plane z = 0 between whole numbers, and the same in x = 3."""
    x, y = (part.ravel() for part in np.meshgrid(np.arange(side), np.arange(side)))
    a, b, c, d = (np.stack([x + dx, y + dy, 0 * x], 1) for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1)))
    floor = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.concatenate([floor, floor[..., [2, 0, 1]] + [3, 0, 0]])


def _twice(rng):
    """Every triangle two times, the second time turned round: all hits are ties."""
    once = _soup(rng, 150)
    return np.concatenate([once, once[:, ::-1]])


SOUPS = {
    "soup": _soup, "bumpy": _bumpy, "needles": _needles, "huge among tiny": _huge_among_tiny, "concentric": _concentric,
    "flat": _flat, "grid": _grid, "twice": _twice,
    "far away": lambda rng: _soup(rng) * 300 + 1e6, "tiny": lambda rng: _soup(rng) * 1e-6,
    "giant": lambda rng: _soup(rng) * 1e6, "one": lambda rng: _soup(rng, 1), "two": lambda rng: _soup(rng, 2),
    "three": lambda rng: _soup(rng, 3),
}  # fmt: skip


def soup(name, rng):
    """Return the triangles of one of SOUPS, (T, 3, 3) float32."""
    return np.float32(SOUPS[name](rng))


def rays_among(corners, rng, count):
    """Return origins and unit directions, (count, 3) float32 each: three quarters aim at points on triangles.

    A fifth each starts far away, in a corner, and on a triangle, the rest in the scene's box; a tenth runs along axes.
    """
    corners = corners.astype(np.float64)
    lo, hi = corners.min((0, 1)), corners.max((0, 1))
    size = max((hi - lo).max(), 1e-30)

    def points(share):
        return np.einsum("nk,nkx->nx", share, corners[rng.integers(len(corners), size=count)])

    on = points(rng.dirichlet((1, 1, 1), count))
    corner = points(np.eye(3)[rng.integers(3, size=count)])
    edge = points(rng.dirichlet((1, 1), count) @ np.eye(3)[:2])
    start, aim = rng.integers(10, size=(2, count, 1))
    afar = (lo + hi) / 2 + 10 * size * rng.normal(size=on.shape)
    o = np.select([start < 2, start < 4, start < 6], [afar, corner, on],
                  rng.uniform(lo - 0.1 * size, hi + 0.1 * size, on.shape))  # fmt: skip
    o = np.float32(o).astype(float)
    shuffled = rng.permutation(count)
    target = np.select([aim < 4, aim < 6, aim < 8], [on[shuffled], corner[shuffled], edge[shuffled]],
                       o + rng.normal(size=o.shape))  # fmt: skip
    d = target - o
    along = (rng.random(count) < 0.1) | (np.abs(d).max(1) == 0)
    d[along] = rng.choice([-1, 1], (along.sum(), 1)) * np.eye(3)[rng.integers(3, size=along.sum())]
    return np.float32(o), unit(d)


class Judge:
    """What rays meet in double precision, and how far float32 may be off.

    The watertight test decides exactly on corners that were projected along the ray in float32, so its answer is the
    right one for corners moved by `moved`, PROJECTION_ROUNDOFFS of their distance. Anything it may then say is allowed:
    a triangle is surely met if all of its edges pass farther than that, surely missed if it lies farther away, and its
    distance is off by what moving changes across its steepest slope.
    """

    def __init__(self, corners, o, d):
        """Project (T, 3, 3) corners along (R, 3) rays: all results are (R, T)."""
        o, d = o.astype(np.float64), d.astype(np.float64)
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        x = np.cross(d, np.eye(3)[np.abs(d).argmin(1)])
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        basis = np.stack([x, np.cross(d, x), d], 1)
        p = np.einsum("rbx,rtkx->rtkb", basis, corners.astype(np.float64)[None] - o[:, None, None])
        moved = PROJECTION_ROUNDOFFS * EPSILON * np.linalg.norm(p, axis=-1).max(-1)
        flat, z = p[..., :2], p[..., 2]
        a, b = flat[:, :, [1, 2, 0]], flat[:, :, [2, 0, 1]]  # the edge opposite to each corner
        along = b - a
        length = np.linalg.norm(along, axis=-1)
        weights = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
        area = weights.sum(-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip(-(a * along).sum(-1) / length**2, 0, 1)
            share = np.where(length > 0, share, 0)
            gap = np.linalg.norm(a + share[..., None] * along, axis=-1).min(-1)
            inside = (weights >= 0).all(-1) | (weights <= 0).all(-1)
            height = np.abs(area) / length.max(-1)
            self.t = (weights * z).sum(-1) / area
            steepness = np.ptp(z, axis=-1) / (height - 2 * moved)
        thick = height > 4 * moved
        self.error = np.where(thick, moved * (2 + np.abs(steepness)), np.inf)
        self.met = inside & (gap > moved) & thick
        self.missed = ~inside & (gap > moved)

    def check(self, index, t, hit):
        """Fail unless the closest hits, (R,) each, are what may come out; return the share that was decided."""
        ahead = self.met & (self.t > self.error)
        with np.errstate(invalid="ignore"):
            nearest = np.where(ahead, self.t + self.error, np.inf).min(1)
        assert not (~hit & np.isfinite(nearest)).any(), "a triangle was missed"
        ray = np.flatnonzero(hit)
        at = ray, index[ray]
        assert not self.missed[at].any(), "a triangle was met that is not there"
        known = np.isfinite(self.error[at])
        # the rounding of the distance itself comes on top, and the length of d, which is 1 only to rounding
        bound = self.error[at] + 4 * EPSILON * t[ray]
        assert (np.abs(t[ray] - self.t[at])[known] <= bound[known]).all(), "the distance is wrong"
        assert (t[ray] <= nearest[ray] * (1 + 4 * EPSILON)).all(), "a nearer triangle was missed"
        return np.isfinite(nearest).sum() / max(hit.sum(), 1)
