"""Rays at a mesh in the unit ball, as arrays on the host, so that different tracers can be given the very same ones.

From outside: origins spread over a sphere around the ball, directions inwards by the cosine. From inside: origins
anywhere in the ball, directions anywhere. Bounce: from points spread over the surface, by the cosine around its normal,
as paths go on from a diffuse surface. Shadow: from points of the surface that face it to points of a square light
above. Primary: through the middle of each pixel of a pinhole camera's picture; row by row, and in tiles of 4 x 4 and
of 8 x 8 pixels. Origins on the surface lie OFFSET off it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.mesh_scenes import Light, View, in_ball, on_sphere
from benchmarks.rays import HostRays

SEED = 3
AROUND = 1.2  # radius of the sphere that rays from outside start at
OFFSET = 1e-5  # far more than roundoff in the unit ball, far less than an edge of 10 million triangles
TILES = {"rows": 1, "4 x 4 tiles": 4, "8 x 8 tiles": 8}
AS_MADE = "as made"


@dataclass(frozen=True)
class RaySet:
    """Rays of one sort: in one or more orders, of which each tracer may take the one that it likes best."""

    name: str
    orders: dict  # name: HostRays
    coherent: bool = False  # whether neighbours are alike

    @property
    def shadow(self):
        """Whether is asked if anything is in the way, and not what is nearest."""
        return next(iter(self.orders.values())).distance is not None


def ray_sets(vertices, faces, width, height):
    """Return the RaySets of a mesh, each of width x height rays."""
    rng, count = np.random.default_rng(SEED), width * height
    around = on_sphere(rng, count)
    p, n = surface_points(rng, vertices, faces, count)
    sets = {
        "from outside": _rays(AROUND * around, _cosine(rng, -around)),
        "from inside": _rays(in_ball(rng, count), on_sphere(rng, count)),
        "bounce": _rays(p + OFFSET * n, _cosine(rng, n)),
        "shadow": _to_light(rng, vertices, faces, count, Light()),
    }
    primary = {name: _primary(View(), width, height, tile) for name, tile in TILES.items()}
    return [RaySet(name, {AS_MADE: rays}) for name, rays in sets.items()] + [RaySet("primary", primary, True)]


def surface_points(rng, vertices, faces, count):
    """Return points spread evenly over a mesh's surface, and the normals there: (count, 3) float64 each."""
    corners = vertices[faces].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice_area = np.linalg.norm(normals, axis=1)
    upto = np.cumsum(twice_area)
    face = np.searchsorted(upto, rng.random(count) * upto[-1])
    u, v = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    return (corners[face] * weights[:, :, None]).sum(axis=1), normals[face] / twice_area[face, None]


def _to_light(rng, vertices, faces, count, light):
    """Return shadow rays from points that face theirs on the light; about half of those tried do."""
    starts, ways = np.empty((0, 3)), np.empty((0, 3))
    while len(starts) < count:
        p, n = surface_points(rng, vertices, faces, count)
        start = p + OFFSET * n
        way = light.points(rng, count) - start
        facing = (way * n).sum(axis=1) > 0
        starts, ways = np.concatenate([starts, start[facing]]), np.concatenate([ways, way[facing]])
    length = np.linalg.norm(ways[:count], axis=1)
    return _rays(starts[:count], ways[:count] / length[:, None], length)


def _primary(view, width, height, tile):
    """Return a ray through the middle of each pixel, tile by tile; a tile of one pixel means row by row."""
    y, x = np.divmod(pixel_order(width, height, tile), width)
    eye = np.array(view.eye)
    back = eye / np.linalg.norm(eye)
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    pixel = 2 * np.tan(np.radians(view.fov_deg) / 2) / height
    across, upwards = (x + 0.5 - width / 2) * pixel, (height / 2 - y - 0.5) * pixel
    d = across[:, None] * right + upwards[:, None] * np.cross(back, right) - back
    return _rays(np.broadcast_to(eye, d.shape), d / np.linalg.norm(d, axis=1, keepdims=True))


def pixel_order(width, height, tile):
    """Return the numbers of a picture's pixels (counted row by row) in the order of square tiles."""
    y, x = np.divmod(np.arange(width * height), width)
    return np.lexsort((x, y, x // tile, y // tile))


def _cosine(rng, normals):
    """Return unit directions around unit normals, by the cosine: to points of the sphere that stands on the plane."""
    d = normals * (1 + OFFSET) + on_sphere(rng, len(normals))  # a little longer, so that it never vanishes
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def _rays(*arrays):
    """Return HostRays of origins, directions and, for shadow rays, distances."""
    return HostRays(*(np.ascontiguousarray(array, dtype=np.float32) for array in arrays))
