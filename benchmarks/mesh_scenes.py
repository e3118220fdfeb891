"""Meshes for comparing tracers of triangles, in the unit ball, as arrays on the host; the same at every call.

`bumpy` is what scanned and sculpted models are like: closed, vertices shared, bumps upon bumps down to the size of the
triangles. `soup` is what hierarchies like least: triangles anywhere, at any angle, that run through each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SEED = 7  # of both meshes
FIRST_FREQUENCY, OCTAVE = 5.0, 2.03  # radians a unit of length, and how many times the next octave's is that
SLOPE = 1.0  # of each octave's bumps, the same for all: the surface looks as rough from near as from afar
PER_WAVE = 1.5  # the finest octave has this many of the grid's steps a radian, or more
OUTERMOST = 0.999  # largest distance of a vertex from the origin
CROWDED = 1.6  # size of the soup's triangles, in edges of the cube that is each one's share of the ball


def bumpy(count):
    """Return a closed bumpy surface around the origin of about `count` triangles (8 k^2, k whole), outward windings.

    Returns: vertices (V, 3) float32 and faces (F, 3) uint32.
    """
    k = max(1, round((count / 8) ** 0.5))
    vertices, faces = octahedron(k)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    radius = np.exp(_bumps(vertices, k / PER_WAVE))
    return (vertices * (OUTERMOST / radius.max() * radius)[:, None]).astype(np.float32), faces


def octahedron(k):
    """Return an octahedron with each face cut into k^2 triangles, scaled so that |x| + |y| + |z| = k.

    A square of 2k by 2k cells is folded over it: the inner diamond becomes its upper half, the corners the lower.
    Returns: vertices (4 k^2 + 2, 3) float64, whole numbers, and faces (8 k^2, 3) uint32.
    """
    side = 2 * k + 1
    x, y = (axis.ravel() - k for axis in np.meshgrid(np.arange(side), np.arange(side), indexing="ij"))
    z = k - abs(x) - abs(y)
    folded = np.stack([np.where(z < 0, (k - abs(y)) * np.where(x < 0, -1, 1), x),
                       np.where(z < 0, (k - abs(x)) * np.where(y < 0, -1, 1), y), z], axis=1)  # fmt: skip
    # points of the square's edges meet in pairs, its corners all four
    keys = (folded + k) @ np.array([side * side, side, 1])
    _, first, label = np.unique(keys, return_index=True, return_inverse=True)
    cell = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    corners = cell, cell + side, cell + side + 1, cell + 1
    # the diagonal runs along the creases of the fold: one way where x and y have one sign, the other way elsewhere
    along = (x[cell] < 0) == (y[cell] < 0)
    pick = [np.where(along, corners[one], corners[other]) for one, other in
            zip((0, 1, 3, 1, 2, 3), (0, 1, 2, 0, 2, 3))]  # fmt: skip
    faces = label[np.stack(pick, axis=1).reshape(-1, 3)].astype(np.uint32)
    return folded[first].astype(np.float64), faces


def _bumps(p, finest):
    """Return the logarithm of the surface's radius at points of the unit sphere: octaves of waves in turned axes."""
    rng = np.random.default_rng(SEED)
    total, frequency = np.zeros(len(p)), FIRST_FREQUENCY
    while frequency < finest:
        turned, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        waves = np.sin(frequency * (p @ turned) + rng.uniform(0, 2 * np.pi, 3))
        total += SLOPE / frequency * (waves[:, 0] * waves[:, 1] + waves[:, 2] / 2)
        frequency *= OCTAVE
    return total


def soup(count):
    """Return `count` triangles anywhere in the unit ball, so large that neighbours overlap, none sharing a vertex.

    Returns: vertices (3 count, 3) float32 and faces (count, 3) uint32.
    """
    rng = np.random.default_rng(SEED)
    size = min(0.5, CROWDED * (4 / 3 * np.pi / count) ** (1 / 3))
    centres = (1 - size) * in_ball(rng, count)
    corners = centres[:, None] + size * in_ball(rng, 3 * count).reshape(-1, 3, 3)
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)


KINDS = {"bumpy": bumpy, "soup": soup}


def on_sphere(rng, count):
    """Return points (count, 3) spread evenly over the unit sphere."""
    points = rng.normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def in_ball(rng, count):
    """Return points (count, 3) spread evenly in the unit ball."""
    return on_sphere(rng, count) * rng.random((count, 1)) ** (1 / 3)


@dataclass(frozen=True)
class View:
    """A pinhole camera that looks at the origin, y upwards."""

    eye: tuple = (0.0, 0.45, 1.9)
    fov_deg: float = 45.0  # of the picture's height


@dataclass(frozen=True)
class Light:
    """A square above the mesh, parallel to y = 0, that shines downwards."""

    centre: tuple = (0.0, 2.5, 0.0)
    side: float = 2.0
    radiance: float = 10.0  # W/(m2 sr), all channels

    def points(self, rng, count):
        """Return points (count, 3) spread evenly over it."""
        u = self.side * (rng.random((count, 2)) - 0.5)
        return np.array(self.centre) + np.stack([u[:, 0], np.zeros(count), u[:, 1]], axis=1)


@dataclass(frozen=True)
class DiffusePicture:
    """A diffuse mesh, that light, and nothing else: what the path tracers render.

    A path has at most `max_depth` segments, the one to the eye and the one to the light included: as in Mitsuba's
    `path`, light comes from at most max_depth - 1 scatterings. None ends early by Russian roulette. The light is seen
    directly too. Pixels are means over independent points in the pixel's square (a box filter).
    """

    size: int  # pixels, width and height
    view: View = View()
    light: Light = Light()
    reflectance: float = 0.8
    max_depth: int = 6
