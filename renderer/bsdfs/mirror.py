"""Perfect mirror: all light goes to the mirror direction, times the reflectance."""

import drjit as dr

from renderer.bsdfs.base import BsdfKind, BsdfSample, constant, nothing, register
from renderer.core.backend import Float, Vector3f

REFLECTANCE = 0


def pack(bsdf, outside):
    """Return the reflectance, black where a texture gives it."""
    return [*constant(bsdf.reflectance)]


def sample(p, wi, u, u2, has):
    """Return the mirror direction."""
    valid = wi.z > 0
    weight = dr.select(valid, p.vector(REFLECTANCE), 0)
    return BsdfSample(Vector3f(-wi.x, -wi.y, wi.z), weight, Float(0), valid, Float(1))


def albedo(p):
    """Return the reflectance."""
    return p.vector(REFLECTANCE)


register(BsdfKind(
    "mirror", pack, sample, nothing, albedo, smooth=lambda bsdf: False, textured={"reflectance": (REFLECTANCE, 3)}
))  # fmt: skip
