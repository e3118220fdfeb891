"""Light from infinitely far away: its intensity is what arrives on a surface that faces it, at any distance."""

from renderer.core.backend import Bool, Float
from renderer.core.numeric import FAR
from renderer.core.vectors import unit
from renderer.lights.base import DirectSample, LightKind, LightSample, register

TO_LIGHT, INTENSITY = 0, 3


def pack(light):
    """Return the direction to the light and its irradiance."""
    return [*(-x for x in unit(light.direction)), *light.intensity]


def sample(row, p, u2=None):
    """Return the direction to the light and its irradiance."""
    return LightSample(row.vector(TO_LIGHT), Float(FAR), row.vector(INTENSITY))


def direct(row, p, u, u2, has):
    """Return the direction to the light and what arrives."""
    return DirectSample(row.vector(TO_LIGHT), Float(FAR), row.vector(INTENSITY), Float(1), Bool(True))


def estimate(light, luminance):
    """Return the value of the light's Estimate."""
    return {"constant": luminance}


register(LightKind("directional", pack, sample, direct, estimate))
