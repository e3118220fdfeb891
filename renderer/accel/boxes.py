"""Boxes as pairs of corners, and their surface areas, which is what a hierarchy's cost is made of.

A random ray that hits a box hits a smaller convex one inside it with the probability of the quotient of their surface
areas [MacDonald1990]. Only quotients matter, so that boxes are measured in units of the scene's largest extent:
areas neither overflow nor vanish, however large or small the scene.
"""

import drjit as dr

from renderer.core.backend import Float, Vector3f
from renderer.core.numeric import greater, lesser

LEAST_EXTENT = 1e-37  # scene units; its reciprocal is finite in float32


def union(lo_a, hi_a, lo_b, hi_b):
    """Return the two corners of the smallest box around two boxes."""
    lo = Vector3f(*(lesser(a, b) for a, b in zip(lo_a, lo_b)))
    return lo, Vector3f(*(greater(a, b) for a, b in zip(hi_a, hi_b)))


def half_area(lo, hi, scale):
    """Return half the surface area of boxes in units of 1 / scale^2."""
    size = (hi - lo) * scale
    return dr.fma(size.x, size.y + size.z, size.y * size.z)


def scene_scale(lo, hi):
    """Return the lowest corner of all boxes (Vector3f) and 1 over their largest extent (Float), opaque, one lane."""
    lowest = Vector3f(*(dr.min(part) for part in lo))
    size = Vector3f(*(dr.max(part) for part in hi)) - lowest
    extent = greater(greater(size.x, size.y), greater(size.z, Float(LEAST_EXTENT)))
    scale = 1 / extent
    dr.make_opaque(lowest, scale)
    return lowest, scale
