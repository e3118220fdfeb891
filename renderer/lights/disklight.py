"""Shining disk in phong mode: a light whose place is any of its points. Path-traced scenes see it as a shape."""

import drjit as dr

from renderer.core.vectors import frame, unit
from renderer.core.warp import square_to_disk
from renderer.lights.base import LightKind, LightSample, direction_to, register

CENTER, INTENSITY, EDGE_U, EDGE_V = 0, 3, 6, 9


def pack(light):
    """Return middle, intensity and two radii at a right angle."""
    radii = [[light.radius * x for x in edge] for edge in frame(unit(light.normal))]
    return [*light.position, *light.intensity, *radii[0], *radii[1]]


def sample(row, p, u2=None):
    """Return the direction to a point of the light, its middle without u2, and its intensity."""
    q = row.vector(CENTER)
    if u2 is not None:
        place = square_to_disk(u2)
        q = dr.fma(row.vector(EDGE_U), place.x, dr.fma(row.vector(EDGE_V), place.y, q))
    return LightSample(*direction_to(q, p), row.vector(INTENSITY))


register(LightKind("disklight", pack, sample, extended=True))
