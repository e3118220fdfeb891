"""The rays of a picture as arrays on the host, so that different tracers can be given the very same ones."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import numpy as np

from renderer.core.backend import UInt32, Vector3f
from renderer.core.records import Ray
from renderer.engine.loop import pixel_corner
from renderer.scene.geometry import SHADOW_END

# Mitsuba starts a shadow ray this many times (1 + largest coordinate) off the surface; so do both sides here.
MITSUBA_OFFSET = 1500 * 2.0**-24


@dataclass(frozen=True)
class HostRays:
    """Rays that start at `o` (N, 3) float32 in unit directions `d`; the rest is only there for shadow rays."""

    o: np.ndarray
    d: np.ndarray
    distance: np.ndarray | None = None  # (N,) float32: to the light
    left_index: np.ndarray | None = None  # (N,) uint32: shape that the ray leaves, which our tracer is told
    left_inwards: np.ndarray | None = None  # (N,) bool

    @property
    def maxt(self):
        """Where a shadow ray ends, just before its light."""
        return self.distance * np.float32(SHADOW_END)


def primary_rays(camera, width, height):
    """Return one ray through the middle of each pixel, row by row."""
    kind, row = camera
    o, d = kind.ray(row, pixel_corner(dr.arange(UInt32, width * height), dr.opaque(UInt32, width)) + 0.5)
    o += dr.zeros(Vector3f, width * height)
    return HostRays(_host(o), _host(d))


def shadow_rays(scene, rays):
    """Return the rays from what `rays` hit to every light that the side met faces, light by light."""
    ray = Ray(Vector3f(rays.o.T), Vector3f(rays.d.T))
    hit = scene.intersect(ray)
    surface = scene.surface(ray, hit, with_uv=False)
    n = dr.select(dr.dot(surface.n_geo, ray.d) < 0, surface.n_geo, -surface.n_geo)
    largest = dr.maximum(abs(surface.p.x), dr.maximum(abs(surface.p.y), abs(surface.p.z)))
    o = surface.p + n * ((1 + largest) * MITSUBA_OFFSET)
    found = []
    for group in scene.lights:
        for k in range(group.rows.count):
            light = group.kind.sample(group.rows[k], o)
            inwards = dr.dot(surface.n_geo, light.wo) < 0
            facing = (hit.valid & (dr.dot(n, light.wo) > 0)).numpy()
            parts = _host(o), _host(light.wo), light.distance.numpy(), hit.index.numpy(), inwards.numpy()
            found.append([part[facing] for part in parts])
    return HostRays(*map(np.concatenate, zip(*found)))


def _host(vectors):
    """Return lanes of vectors as (N, 3)."""
    return np.ascontiguousarray(vectors.numpy().T)
