"""Light from one point into a cone: full within the beam width, then falling linearly with the angle to the cutoff.

Path-traced scenes get intensity / distance^2 from it, phong mode the intensity, both times this factor. The angle is
measured by the chord between unit directions: an arc cosine would lose narrow beams to rounding.
"""

import math

import drjit as dr

from renderer.core.backend import Float
from renderer.core.numeric import EPSILON, TINY, greater, lesser
from renderer.core.vectors import unit
from renderer.lights.base import LightKind, LightSample, direction_to, fallen_off, register

POSITION, INTENSITY, DIRECTION, CUTOFF, INVERSE_WIDTH = 0, 3, 6, 9, 10  # cutoff in radians
SHARPEST = 1e6  # per radian: a beam as wide as the cutoff has an edge
GATE_ROUNDING = 8 * EPSILON  # of a cosine, so that no point in the light counts as outside
BEAM = 0.75  # of the cutoff, where the file has no beamwidth


def pack(light):
    """Return position, intensity, unit direction, cutoff and the inverse of the angle over which it falls."""
    cutoff = math.radians(light.cutoff)
    width = cutoff - math.radians(BEAM * light.cutoff if light.beamwidth is None else light.beamwidth)
    return [*light.position, *light.intensity, *unit(light.direction), cutoff, 1 / max(width, 1 / SHARPEST)]


def sample(row, p, u2=None):
    """Return the direction to the light and its intensity there."""
    wo, distance = direction_to(row.vector(POSITION), p)
    angle = 2 * dr.safe_asin(0.5 * dr.norm(wo + row.vector(DIRECTION)))
    factor = lesser(greater((row[CUTOFF] - angle) * row[INVERSE_WIDTH], Float(0)), Float(1))
    return LightSample(wo, distance, row.vector(INTENSITY) * factor)


def direct(row, p, u, u2, has):
    """Return the direction to the light and what arrives."""
    return fallen_off(sample(row, p))


def estimate(light, luminance):
    """Return the values of the light's Estimate."""
    gate = math.cos(math.radians(light.cutoff)) - GATE_ROUNDING
    axis = tuple(unit(light.direction))
    return {"center": light.position, "strength": luminance, "least": TINY, "axis": axis, "gate": gate}


register(LightKind("spot", pack, sample, direct, estimate))
