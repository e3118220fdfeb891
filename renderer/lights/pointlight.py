"""Point light. Path-traced scenes get intensity / distance^2 from it, phong mode the intensity."""

from renderer.core.numeric import TINY
from renderer.lights.base import LightKind, LightSample, direction_to, fallen_off, register

POSITION, INTENSITY = 0, 3


def pack(light):
    """Return position and intensity."""
    return [*light.position, *light.intensity]


def sample(row, p, u2=None):
    """Return the direction to the light and its intensity."""
    return LightSample(*direction_to(row.vector(POSITION), p), row.vector(INTENSITY))


def direct(row, p, u, u2, has):
    """Return the direction to the light and what arrives."""
    return fallen_off(sample(row, p))


def estimate(light, luminance):
    """Return the values of the light's Estimate."""
    return {"center": light.position, "strength": luminance, "least": TINY}


register(LightKind("pointlight", pack, sample, direct, estimate))
