"""Perfect mirror: all light goes to the mirror direction, times the reflectance."""

import drjit as dr

from renderer.bsdfs.base import BsdfKind, BsdfSample, register
from renderer.core.backend import Float, Vector3f

REFLECTANCE = 0


def pack(bsdf, outside):
    """Return the reflectance, black where a texture gives it."""
    return [*bsdf.reflectance] if isinstance(bsdf.reflectance, tuple) else [0.0, 0.0, 0.0]


def sample(p, wi, u, u2, has):
    """Return the mirror direction."""
    valid = wi.z > 0
    weight = dr.select(valid, p.vector(REFLECTANCE), 0)
    return BsdfSample(Vector3f(-wi.x, -wi.y, wi.z), weight, Float(0), valid, Float(1))


def evaluate(p, wi, wo, has):
    """Return zeros: the only direction is delta."""
    return Vector3f(0), Float(0)


def albedo(p):
    """Return the reflectance."""
    return p.vector(REFLECTANCE)


register(BsdfKind(
    "mirror", pack, sample, evaluate, albedo, smooth=lambda bsdf: False, textured={"reflectance": (REFLECTANCE, 3)}
))  # fmt: skip
