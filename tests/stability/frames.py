"""Orthonormal frames.

A frame is made at every hit. Its tangents must be at right angles and of length 1 for every normal, also beside the
direction in which a formula has its seam, (0, 0, -1), and with components of 1e-45 to 1. Along a given tangent it must
be so however long that is, and where it is nearly parallel to the normal. Normals are unit vectors rounded to float32;
errors are taken from the exact products of what came out.
"""

import drjit as dr
import numpy as np

from renderer.core.backend import Vector3f
from renderer.core.frame import Frame
from tests.stability.case import ULP, Case, mitsuba

COUNT = 100_000


def normals():
    """Return unit vectors, (3, N) float32: even ones, and around each end of the axes at angles down to nothing."""
    rng = np.random.default_rng(1)
    even = rng.normal(size=(3, COUNT))
    around = []
    for axis in range(3):
        for sign in (1, -1):
            n = rng.normal(size=(3, COUNT)) * 10.0 ** rng.uniform(-45, 0, (3, COUNT))
            n[:, :100] = 0
            n[axis] = sign
            around.append(n)
    n = np.concatenate([even, *around], axis=1)
    return (n / np.linalg.norm(n, axis=0)).astype(np.float32)


def defects(t, b, n):
    """Return the largest of (N,) errors of frames (3, N): angles, lengths of the tangents, and t x b against n."""
    t, b, n = (np.asarray(axis, float) for axis in (t, b, n))
    with np.errstate(invalid="ignore"):
        errors = [(t * b).sum(0), (b * n).sum(0), (n * t).sum(0), np.linalg.norm(t, axis=0) - 1,
                  np.linalg.norm(b, axis=0) - 1, np.linalg.norm(np.cross(t.T, b.T).T - n, axis=0)]  # fmt: skip
    return np.abs(errors).max(axis=0)


def frisvad(n):
    """Return the tangents of a normal [Frisvad2012], without its case of the seam."""
    x, y, z = n
    with np.errstate(all="ignore"):
        a = 1 / (1 + z)
        b = -x * y * a
        return np.stack([1 - x * x * a, b, -x]), np.stack([b, 1 - y * y * a, -y])


def of_normals(tangents):
    """Return a callable: the defects of frames by a function of normals."""
    return lambda: defects(*tangents(normals()), normals())


def ours(n):
    """Return the renderer's tangents."""
    frame = Frame.of(Vector3f(*n))
    return frame.t.numpy(), frame.b.numpy()


def mitsubas(n):
    """Return Mitsuba's tangents."""
    mi = mitsuba()
    return [axis.numpy() for axis in mi.coordinate_system(mi.Vector3f(*n))]


def slanted():
    """Return normals and tangents of lengths from 1e-17 to 1e17 at angles from 1e-3 to 1 from them, or opposite."""
    rng = np.random.default_rng(2)
    n = normals()[:, :COUNT]
    angle = 10.0 ** rng.uniform(-3, 0, COUNT)
    across = np.cross(n.T, rng.normal(size=(COUNT, 3))).T
    across /= np.linalg.norm(across, axis=0)
    v = (np.cos(angle) * n + np.sin(angle) * across) * rng.choice([-1, 1], COUNT)
    return n, (v * 10.0 ** rng.uniform(-17, 17, COUNT)).astype(np.float32)


def along(tangents):
    """Return a callable: the defects of frames by a function of normals and tangents."""

    def measure():
        n, v = slanted()
        return defects(*tangents(n, v), n)

    return measure


def ours_along(n, v):
    """Return the renderer's tangents."""
    frame = Frame.along(Vector3f(*n), Vector3f(*v))
    return frame.t.numpy(), frame.b.numpy()


def gram_schmidt(n, v):
    """Return the textbook's tangents."""
    with np.errstate(all="ignore"):
        t = v - n * (n * v).sum(0)
        t = t / np.sqrt((t * t).sum(0))
    return t, np.cross(n.T, t.T).T


def mitsubas_along(n, v):
    """Return the tangents that Mitsuba makes of a shading normal and dp_du."""
    mi = mitsuba()
    si = dr.zeros(mi.SurfaceInteraction3f, n.shape[1])
    si.sh_frame.n, si.dp_du = mi.Normal3f(*n), mi.Vector3f(*v)
    si.initialize_sh_frame()
    return si.sh_frame.s.numpy(), si.sh_frame.t.numpy()


CASES = (
    Case("frames of normals", "1", 8 * ULP,
         "a component of a tangent is within 4 roundings, two of them err at once, and the normal's length within 2",
         of_normals(ours), of_normals(frisvad), "the frame of a normal before its seam was mended",
         of_normals(mitsubas)),
    Case("frames along tangents", "1", 8 * ULP,
         "each sum of three products rounds three times, projection and normalisation twice, and b is a cross product",
         along(ours_along), along(gram_schmidt), "one step of Gram and Schmidt", along(mitsubas_along)),
)  # fmt: skip
