"""Shining rectangle in phong mode: a light whose place is any of its points. Path-traced scenes see it as a shape."""

import drjit as dr

from renderer.lights.base import LightKind, LightSample, direction_to, register

CENTER, INTENSITY, EDGE_U, EDGE_V = 0, 3, 6, 9


def pack(light):
    """Return middle, intensity and edges."""
    return [*light.position, *light.intensity, *light.u, *light.v]


def sample(row, p, u2=None):
    """Return the direction to a point of the light, its middle without u2, and its intensity."""
    q = row.vector(CENTER)
    if u2 is not None:
        q = dr.fma(row.vector(EDGE_U), u2.x - 0.5, dr.fma(row.vector(EDGE_V), u2.y - 0.5, q))
    return LightSample(*direction_to(q, p), row.vector(INTENSITY))


register(LightKind("arealight", pack, sample, extended=True))
