"""Lights of phong mode, for the exact counterpart: where they are seen from a point, and how bright.

None falls off with the distance. Lamps are points in their middle, as pictures of one sample have them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from converters.geometry import unit
from converters.mitsuba.lamps import beam_deg


@dataclass(frozen=True)
class Light:
    """A light at a `position`, or infinitely far away in the direction `towards`."""

    intensity: tuple
    position: tuple | None = None
    towards: tuple | None = None
    axis: tuple | None = None  # unit, of a cone
    cutoff: float = 0.0  # half angle of the cone, radians
    beam: float = 0.0  # half angle of its full part

    def direction(self, p):
        """Return the unit direction to the light from points (lanes), and its distance; None: infinite."""
        if self.position is None:
            return mi.Vector3f(*self.towards) + dr.zeros(mi.Vector3f, dr.width(p)), None
        way = mi.Point3f(*self.position) - p
        distance = dr.norm(way)
        return way / distance, distance

    def brightness(self, to_light):
        """Return the intensity in the direction back from the light."""
        if self.axis is None:
            return mi.Color3f(*self.intensity)
        angle = dr.acos(dr.clip(-dr.dot(to_light, mi.Vector3f(*self.axis)), -1, 1))
        full = dr.clip((self.cutoff - angle) / max(self.cutoff - self.beam, 1e-6), 0, 1)
        return mi.Color3f(*self.intensity) * full


def lights(world):
    """Return the Lights of a scene's description, without what is all around."""
    return [_KINDS[light.type](light) for light in world.lightsources if light.type in _KINDS]


def _numbers(vector):
    """Return a vector as plain floats."""
    return tuple(float(x) for x in vector)


def _point(light):
    """Return the Light of a point, or of the middle of a lamp."""
    return Light(_numbers(light.intensity), position=_numbers(light.position))


def _spot(light):
    """Return the Light of a cone."""
    return Light(_numbers(light.intensity), _numbers(light.position), axis=_numbers(unit(light.direction)),
                 cutoff=math.radians(light.cutoff), beam=math.radians(beam_deg(light)))


def _directional(light):
    """Return the Light of one that is infinitely far away."""
    return Light(_numbers(light.intensity), towards=_numbers(-unit(light.direction)))


_KINDS = {"pointlight": _point, "spot": _spot, "directional": _directional, "arealight": _point, "disklight": _point}
