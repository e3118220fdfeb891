"""Point light."""

import drjit as dr

from renderer.core.numeric import TINY, greater
from renderer.lights.base import LightKind, LightSample, register

POSITION, INTENSITY = 0, 3


def pack(light):
    """Return position and intensity."""
    return [*light.position, *light.intensity]


def sample(row, p):
    """Return the direction to the light and its intensity."""
    to_light = row.vector(POSITION) - p
    distance = dr.norm(to_light)
    return LightSample(to_light * dr.rcp(greater(distance, TINY)), distance, row.vector(INTENSITY))


register(LightKind("pointlight", pack, sample))
