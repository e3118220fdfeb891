"""A path tracer for one diffuse mesh under one square light: what the structure gives where rays bounce.

Light sampling and cosine sampling are combined by the balance heuristic [Veach1995], as Mitsuba's `path` does, with one
ray of each at every vertex. Traversal and shading share one loop: every lane is on its way with a ray of either kind,
after some steps the lanes that are done are shaded and get their next ray, and a lane whose path has ended starts the
pixel's next one. No lane waits for another's ray or path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from renderer.accel.bvh import Walk
from renderer.accel.watertight import Axes
from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.hashing import mix
from renderer.core.numeric import FAR, TINY, away_from_zero, greater, lesser
from renderer.core.records import NO_SHAPE, Ray
from renderer.core.vectors import cross, subtract, unit
from renderer.scene.geometry import SHADOW_END, leave

STEPS = 5  # through the hierarchy between shadings
PIXELS = 4  # of a lane, a square: with more paths to follow, lanes end more evenly
LIGHT = NO_SHAPE - 1  # index of a hit on the light


@dataclass
class Path:
    """A lane's path: the ray on its way, and what the path has gathered."""

    pixel: UInt32  # along a Z-order curve
    sample: UInt32
    random: UInt32  # state of the generator
    o: Vector3f
    d: Vector3f
    left: UInt32  # triangle that the ray left
    t: Float
    index: UInt32
    walk: Walk
    shadow: UInt32  # 1 for a ray towards the light, 0 for one that follows the path
    segments: UInt32  # of the path, the ray's own included
    throughput: Vector3f
    density: Float  # per steradian, of the direction by cosine sampling; 0 for the camera's
    onward: Vector3f  # direction in which the path goes on after the shadow ray
    pending: Vector3f  # radiance that arrives if the shadow ray does
    radiance: Vector3f  # sum over the samples


class DiffusePath:
    """A DiffusePicture of a Geometry."""

    def __init__(self, geometry, picture):
        assert picture.size.bit_count() == 1, "pixels are numbered along a Z-order curve"
        self._geometry, self._bvh, self._picture = geometry, geometry.structure, picture
        forward = unit(subtract([0.0, 0.0, 0.0], picture.view.eye))
        right = unit(cross(forward, [0.0, 1.0, 0.0]))
        half = math.tan(math.radians(picture.view.fov_deg) / 2)
        axes = ([half * x for x in right], [half * x for x in cross(right, forward)], forward)
        self._eye = Vector3f(*(dr.opaque(Float, x) for x in picture.view.eye))
        self._right, self._up, self._forward = (Vector3f(*(dr.opaque(Float, x) for x in axis)) for axis in axes)
        light = picture.light
        self._centre = Vector3f(*(dr.opaque(Float, x) for x in light.centre))
        self._side, self._emitted = dr.opaque(Float, light.side), dr.opaque(Float, light.radiance)
        self._albedo = Vector3f(dr.opaque(Float, picture.reflectance))

    def render(self, samples, seed):
        """Return the picture as an array (height, width, 3)."""
        size = self._picture.size
        lanes = -(-size * size // PIXELS)
        end, seed = dr.opaque(UInt32, samples), dr.opaque(UInt32, seed)
        self._film = dr.zeros(Float, 3 * size * size)
        first = dr.arange(UInt32, lanes) * PIXELS
        stop = lesser(first + PIXELS, dr.opaque(UInt32, size * size))
        zero, vector = dr.zeros(UInt32, lanes), dr.zeros(Vector3f, lanes)
        random = mix(first + seed * size * size)
        path = Path(first, zero, random, vector, vector, zero, Float(zero), zero, self._bvh.start(lanes), zero, zero,
                    vector, Float(zero), vector, vector, vector)
        self._restart(path, first < stop)

        def advance(path):
            """Take some steps through the hierarchy, then shade the lanes whose ray is done."""
            ray = Ray(path.o, path.d, path.left, Bool(False))
            slabs, leaf = self._bvh.slabs(ray), self._geometry.leaf_test(ray)
            running = path.pixel < stop
            active, shadow = running, path.shadow != 0
            for _ in range(STEPS):
                fetched = self._bvh.fetch(path.walk, active)
                path.walk, path.t, path.index, active = self._bvh.step(
                    path.walk, fetched, slabs, path.t, path.index, leaf, active, shadow
                )
            self._shade(path, ray, running & ~active, end)
            return path

        dr.while_loop((path,), lambda path: path.pixel < stop, lambda path: (advance(path),), label="paths")
        dr.eval(self._film)
        return self._film.numpy().reshape(size, size, 3) / samples

    def _shade(self, path, ray, done, end):
        """Give the lanes whose ray is done their next one."""
        arrived, followed = done & (path.shadow != 0), done & (path.shadow == 0)
        self._collect(path, arrived, followed)

        hits = followed & (path.index < LIGHT) & (path.segments < self._picture.max_depth)
        surface = self._geometry.triangles.surface(ray, path.index, hits, with_uv=False)
        n = dr.select(dr.dot(surface.n_geo, path.d) < 0, surface.n_geo, -surface.n_geo)
        u = [_uniform(path) for _ in range(4)]
        to_light = self._centre + Vector3f(self._side * (u[0] - 0.5), 0, self._side * (u[1] - 0.5)) - surface.p
        squared = dr.squared_norm(to_light)
        wo = to_light * dr.rsqrt(squared)
        cos_o = dr.dot(n, wo)
        density = squared / (greater(wo.y, Float(TINY)) * dr.square(self._side))
        share = dr.rcp(density + cos_o / math.pi)  # balance heuristic over density
        reaches = hits & (cos_o > 0) & (wo.y > 0)
        pending = path.throughput * self._albedo * (self._emitted * share * cos_o / math.pi)

        r, phi = dr.sqrt(u[2]), 2 * math.pi * u[3]
        sin_phi, cos_phi = dr.sincos(phi)
        z = dr.sqrt(1 - u[2])
        basis = Axes.of(Ray(surface.p, n))
        onward = basis.x * (r * cos_phi) + basis.y * (r * sin_phi) + n * z

        # the next ray: towards the light, or on, from the new point; or on after the shadow ray, from where it began
        out = leave(surface, path.index, n)
        path.o, path.left = dr.select(hits, out.o, path.o), dr.select(hits, path.index, path.left)
        path.throughput = dr.select(hits, path.throughput * self._albedo, path.throughput)
        path.pending, path.onward = dr.select(hits, pending, path.pending), dr.select(hits, onward, path.onward)
        path.density = dr.select(hits, z / math.pi, path.density)
        goes_on = (hits & ~reaches) | arrived
        path.d = dr.select(reaches, wo, dr.select(goes_on, path.onward, path.d))
        path.shadow = dr.select(reaches, UInt32(1), dr.select(goes_on, 0, path.shadow))
        path.segments = dr.select(goes_on, path.segments + 1, path.segments)
        self._begin(path, reaches | goes_on, reaches, dr.sqrt(squared) * SHADOW_END)

        self._finish(path, followed & ~hits, end)

    def _collect(self, path, arrived, followed):
        """Add the light that the rays bring: shadow rays what waits for them, others that of a light they met."""
        path.radiance += dr.select(arrived & (path.index == NO_SHAPE), path.pending, 0)
        lit = followed & (path.index == LIGHT) & (path.d.y > 0)
        distance_squared, cosine = dr.square(path.t), abs(path.d.y)
        by_light = distance_squared / (cosine * dr.square(self._side) + TINY)
        weight = path.density / (path.density + by_light)
        path.radiance += dr.select(lit, path.throughput * self._emitted * dr.select(path.segments == 1, 1, weight), 0)

    def _finish(self, path, ended, end):
        """Begin the next sample where a path has ended, and write the pixels that have all of theirs."""
        path.sample = dr.select(ended, path.sample + 1, path.sample)
        complete = ended & (path.sample == end)
        x, y = _place(path.pixel)
        for channel in range(3):
            dr.scatter(self._film, path.radiance[channel], 3 * (y * self._picture.size + x) + channel, complete)
        path.radiance = dr.select(complete, 0, path.radiance)
        path.sample, path.pixel = dr.select(complete, 0, path.sample), dr.select(complete, path.pixel + 1, path.pixel)
        self._restart(path, ended)

    def _restart(self, path, where):
        """Begin the next path of the pixels `where`."""
        scale = 2 / self._picture.size
        x, y = (Float(axis) for axis in _place(path.pixel))
        across, down = (x + _uniform(path)) * scale - 1, (y + _uniform(path)) * scale - 1
        d = dr.normalize(self._forward + self._right * across - self._up * down)
        path.o, path.d = dr.select(where, self._eye, path.o), dr.select(where, d, path.d)
        path.left, path.shadow = dr.select(where, NO_SHAPE, path.left), dr.select(where, 0, path.shadow)
        path.segments = dr.select(where, 1, path.segments)
        path.throughput = dr.select(where, Vector3f(1), path.throughput)
        self._begin(path, where, Bool(False), Float(0))

    def _begin(self, path, where, shadow, end):
        """Send the rays `where` into the hierarchy: shadow rays up to `end`, others up to the light."""
        t = (self._centre.y - path.o.y) / away_from_zero(path.d.y)
        p = dr.fma(path.d, t, path.o) - self._centre
        lit = (t > 0) & (greater(abs(p.x), abs(p.z)) <= self._side * 0.5) & ~shadow
        path.t = dr.select(where, dr.select(shadow, end, dr.select(lit, t, FAR)), path.t)
        path.index = dr.select(where, dr.select(lit, UInt32(LIGHT), NO_SHAPE), path.index)
        path.walk.record = dr.select(where, 0, path.walk.record)
        path.walk.height = dr.select(where, 0, path.walk.height)


def _uniform(path):
    """Return a number in [0, 1) and advance the path's generator: a congruential one, hashed."""
    path.random = path.random * 747796405 + 2891336453
    return Float(mix(path.random) >> 8) * 2.0**-24


def _place(pixel):
    """Return column and row of a pixel by its number along a Z-order curve: the even bits and the odd ones."""
    bits = []
    for x in (pixel & 0x55555555, (pixel >> 1) & 0x55555555):
        for shift, mask in ((1, 0x33333333), (2, 0x0F0F0F0F), (4, 0x00FF00FF), (8, 0x0000FFFF)):
            x = (x | (x >> shift)) & mask
        bits.append(x)
    return bits
