"""Point light. Path-traced scenes get intensity / distance^2 from it, phong mode the intensity."""

import drjit as dr

from renderer.core.backend import Bool, Float
from renderer.core.numeric import TINY, greater
from renderer.lights.base import DirectSample, LightKind, LightSample, register

POSITION, INTENSITY = 0, 3


def pack(light):
    """Return position and intensity."""
    return [*light.position, *light.intensity]


def sample(row, p, u2=None):
    """Return the direction to the light and its intensity."""
    to_light = row.vector(POSITION) - p
    distance = dr.norm(to_light)
    return LightSample(to_light * dr.rcp(greater(distance, TINY)), distance, row.vector(INTENSITY))


def direct(row, p, u, u2, has):
    """Return the direction to the light and what arrives."""
    light = sample(row, p)
    falloff = dr.rcp(greater(dr.square(light.distance), TINY))
    return DirectSample(light.wo, light.distance, light.radiance * falloff, Float(1), Bool(True))


def estimate(light, luminance):
    """Return the values of the light's Estimate."""
    return {"center": light.position, "strength": luminance, "least": TINY}


register(LightKind("pointlight", pack, sample, direct, estimate))
