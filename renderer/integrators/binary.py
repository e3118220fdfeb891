"""Binary mode: red where a ray hits anything, black elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.numeric import FAR
from renderer.core.records import Ray
from renderer.integrators.base import register

HIT, MISS = (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)


@dataclass
class Path:
    """The camera ray of each lane."""

    o: Vector3f
    d: Vector3f


@register("binary")
class Binary:
    """Whether a ray hits: one any-hit query a ray, no shading."""

    looks_ahead = False
    uneven = False

    def __init__(self, scene, bounces):
        self._scene = scene

    def start(self, lanes):
        """Return lanes without a ray."""
        return Path(dr.zeros(Vector3f, lanes), dr.zeros(Vector3f, lanes))

    def restart(self, path, where, o, d):
        """Return the path with fresh camera rays in the lanes `where`."""
        return dr.select(where, Path(o, d), path)

    def step(self, path, draws):
        """Return red or black; no lane goes on."""
        hit = self._scene.occluded(Ray(path.o, path.d), Float(FAR), Bool(True))
        return dr.select(hit, Vector3f(HIT), Vector3f(MISS)), Bool(False), path
