"""Our intersection and shadow tests beside Mitsuba's, for the same rays in the same scene.

Both get identical ray arrays, evaluated in memory: the primary rays of the picture, one through the middle of each
pixel, and from each hit one shadow ray to every light that the surface faces. Closest hit: our `intersect` (distance
and shape) beside `Scene.ray_intersect_preliminary` (the same two evaluated). Shadow: our `occluded` beside
`Scene.ray_test`. Nothing is shaded. Mitsuba traces with Embree, and is measured with and without the hint that rays
are coherent: the ratios take the faster of the two for each test. Our shadow rays also carry the shape that they
leave, as those of the renderer do, which costs us time; one column is without that. CPU time of all threads; recording
the kernel is in it on both sides, compiling is not. The share is that of a kernel which only reads the same rays and
writes as many results: neither side can be faster than that.
"""

from __future__ import annotations

from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from benchmarks import scenes
from benchmarks.lanes import done, lanes, vectors
from benchmarks.measure import interleaved, result, spread
from benchmarks.rays import primary_rays, shadow_rays
from benchmarks.targets import HIGHER, Figure
from converters.mitsuba import to_dict
from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.numeric import FAR
from renderer.core.records import Ray
from renderer.scene.tables import compile_camera, compile_scene

AT_LEAST = 3.0  # times Mitsuba's speed, closest hits and shadow rays together
CALLS = 64  # of each test in one measurement: some systems count CPU time in steps of 4 ms
RELATIVE = 1e-4  # distances differ if they are further apart than this
NO_HIT = FAR / 2  # a miss is at FAR in our renderer and at infinity in Mitsuba


def measure(effort):
    """Return the ratios of speed, with rays per CPU second of both and the number of rays they disagree on."""
    rows = [_compare(name, effort) for name in scenes.LIT]
    figures = [
        Figure(f"{row['scene']}, rays beside Mitsuba", "x", HIGHER, row["both, x Mitsuba"]["median"], AT_LEAST)
        for row in rows
    ]
    return result(figures, ratios=rows)


def _compare(name, effort):
    """Return the row of one scene."""
    loaded = scenes.load(name, effort)
    scene, camera = compile_scene(loaded), compile_camera(loaded.description.camera)
    primary = primary_rays(camera, effort.width, effort.height)
    shadow = shadow_rays(scene, primary)
    ours, theirs = Ours(scene, primary, shadow), Theirs(loaded, primary, shadow)
    actions = {
        "our hits": ours.closest, "our shadows": ours.blocked, "untold": ours.blocked_untold, "reading": ours.only_read,
        "hits, hint": partial(theirs.closest, True), "hits, no hint": partial(theirs.closest, False),
        "shadows, hint": partial(theirs.blocked, True), "shadows, no hint": partial(theirs.blocked, False),
    }  # fmt: skip
    times = {kind: np.array(seconds) for kind, seconds in interleaved(actions, effort.repeats, CALLS).items()}
    hits, shadows = (_faster(times[f"{test}, hint"], times[f"{test}, no hint"]) for test in ("hits", "shadows"))
    our_time = times["our hits"] + times["our shadows"]
    return {
        "scene": name,
        "closest hits, x Mitsuba": _spread(hits / times["our hits"]),
        "shadow rays, x Mitsuba": _spread(shadows / times["our shadows"]),
        "both, x Mitsuba": _spread((hits + shadows) / our_time),
        "both, if ours is not told what is left": _spread((hits + shadows) / (times["our hits"] + times["untold"])),
        "our M rays/CPU s": _spread((len(primary.o) + len(shadow.o)) / 1e6 / our_time),
        "share of our time that only moves the rays": _spread(times["reading"] / our_time),
        "primary rays": len(primary.o), "shadow rays": len(shadow.o),
        "primary rays that differ": differing_hits(ours.closest()[0].numpy(), theirs.closest(True)[0].numpy()),
        "shadow rays that differ": int((ours.blocked().numpy() != theirs.blocked(True).numpy()).sum()),
    }  # fmt: skip


def _faster(one, other):
    """Return the times with the smaller median."""
    return min(one, other, key=np.median)


def differing_hits(ours, theirs):
    """Return how many rays hit something in one of two arrays of distances only, or at another distance."""
    both = (ours < NO_HIT) & (theirs < NO_HIT)
    apart = np.abs(ours[both] - theirs[both]) > RELATIVE * theirs[both]
    return int(((ours < NO_HIT) != (theirs < NO_HIT)).sum() + apart.sum())


def _spread(values):
    """Return the spread of an array as plain numbers."""
    return spread([float(value) for value in values])


class Ours:
    """Our tests of the rays. Shadow rays carry the shape that they leave, as those of the renderer do."""

    def __init__(self, scene, primary, shadow):
        self._scene = scene
        self._primary = Ray(vectors(Vector3f, Float, primary.o), vectors(Vector3f, Float, primary.d))
        inwards = lanes(UInt32, shadow.left_inwards.astype(np.uint32)) != 0
        self._shadow = Ray(vectors(Vector3f, Float, shadow.o), vectors(Vector3f, Float, shadow.d),
                           lanes(UInt32, shadow.left_index), inwards)  # fmt: skip
        self._distance = lanes(Float, shadow.distance)
        dr.eval(inwards)

    def closest(self):
        """Return distance and shape of the closest hits."""
        hit = self._scene.intersect(self._primary)
        return done(hit.t, hit.index)

    def only_read(self):
        """Return results of the same sizes from all that the rays consist of, without a scene."""
        first, second = self._primary, self._shadow
        sums = dr.sum(second.o) + dr.sum(second.d) + self._distance
        hidden = (sums > 0) ^ (second.left_index == 0) ^ second.left_inwards
        return done(dr.sum(first.o), dr.sum(first.d), hidden)

    def blocked(self):
        """Return whether each light is hidden."""
        return done(self._scene.occluded(self._shadow, self._distance, Bool(True)))[0]

    def blocked_untold(self):
        """Return the same from just the arrays that Mitsuba gets."""
        return done(self._scene.occluded(Ray(self._shadow.o, self._shadow.d), self._distance, Bool(True)))[0]


class Theirs:
    """Mitsuba's tests of the rays. Its scene has to live as long as what it traced."""

    def __init__(self, loaded, primary, shadow):
        self._scene = mi.load_dict(to_dict(loaded))
        self._primary = self._rays(primary)
        self._shadow = self._rays(shadow)
        self._shadow.maxt = lanes(mi.Float, shadow.maxt)

    @staticmethod
    def _rays(rays):
        """Return arrays of the host as Mitsuba's rays."""
        return mi.Ray3f(vectors(mi.Point3f, mi.Float, rays.o), vectors(mi.Vector3f, mi.Float, rays.d))

    def closest(self, coherent):
        """Return distance and shape of the closest hits."""
        hit = self._scene.ray_intersect_preliminary(self._primary, coherent=coherent)
        return done(hit.t, hit.shape)

    def blocked(self, coherent):
        """Return whether each light is hidden."""
        return done(self._scene.ray_test(self._shadow, coherent=coherent))[0]
