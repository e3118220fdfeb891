"""A picture in passes: each adds a few samples to all pixels and takes a bounded time, until there is enough.

All passes run one kernel: the film and the numbers of the samples are its inputs.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float64, UInt32
from renderer.engine.filters import Box
from renderer.engine.film import Film, is_finite
from renderer.engine.loop import follow_sample, pixel_corner, sample_pixels
from renderer.scene.schema import MAX_SAMPLES

PASS_SECONDS = 0.5  # aim for the length of a pass: often enough for progress and Ctrl-C
FIRST_PASS_SAMPLES = 1
LONGEST_GROWTH = 8  # a pass is at most this many times the one before
LEAST_FOR_ERROR = 16  # samples a pixel before their spread is believed
SEARCHED_AT_ONCE = 2**16  # samples of a pixel, when a lost one is looked for
MOST_EXAMPLES = 4  # pixels that are searched for lost samples


@dataclass(frozen=True)
class Until:
    """When a picture is done: as soon as one of these holds."""

    samples: int = MAX_SAMPLES  # a pixel
    seconds: float | None = None  # since the first pass began
    error: float | None = None  # Film.relative_error

    def progress(self, done, seconds, error):
        """Return (done, total) of what is nearest to its end."""
        if self.seconds is None and self.error is None:
            return done, self.samples
        shares = [done / self.samples]
        if self.seconds is not None:
            shares.append(seconds / self.seconds)
        if self.error is not None and error is not None:
            shares.append(min(1.0, (self.error / error) ** 2) if error > 0 else 1.0)  # the square falls with the samples
        return min(1.0, max(shares)), 1.0


@dataclass(frozen=True)
class View:
    """What decides every sample of a picture."""

    integrator: object
    camera: tuple  # of compile_camera
    sampler: Callable  # kind
    width: int
    height: int
    seed: int = 0
    centred: bool = False
    pixel_filter: object = Box()

    def _lanes(self, pixel):
        """Return the samplers and corners of pixel numbers."""
        return self.sampler(pixel, dr.opaque(UInt32, self.seed)), pixel_corner(pixel, dr.opaque(UInt32, self.width))

    def expose(self, film, first, end):
        """Return the film with the samples from `first` up to `end`, not evaluated yet."""
        sampler, corner = self._lanes(dr.arange(UInt32, self.width * self.height))
        first, end = dr.opaque(UInt32, first), dr.opaque(UInt32, end)
        return sample_pixels(
            self.integrator, self.camera, sampler, corner, film, first, end, self.centred, self.pixel_filter
        )

    def follow(self, pixel, first, count=1):
        """Return the radiance of `count` samples of one pixel, evaluated, one lane each, whether finite or not."""
        sampler, corner = self._lanes(dr.opaque(UInt32, pixel) + dr.zeros(UInt32, count))
        sample = dr.opaque(UInt32, first) + dr.arange(UInt32, count)
        dr.eval(sampler, corner, sample)
        radiance = follow_sample(
            self.integrator, self.camera, sampler, corner, sample, self.centred, self.pixel_filter
        )
        dr.eval(radiance)
        return radiance


def refine(view, film, until, progress=None, interrupted=None):
    """Return the film (evaluated) and how many samples a pixel it has.

    `progress(done, total)` is called after every pass, then `interrupted()`, which tells whether to stop there.
    """
    done, count, start = 0, min(until.samples, FIRST_PASS_SAMPLES), time.perf_counter()
    if until.samples > count:
        film = film.opaque()  # so that the first pass uses the same kernel as the others
    while True:
        begin, end = time.perf_counter(), min(done + count, until.samples)
        film = view.expose(film, done, end)
        dr.eval(film)
        launched = time.perf_counter()  # what came before is tracing and, in the first pass, compilation
        dr.sync_thread()
        now, done = time.perf_counter(), end
        error = film.relative_error(done) if until.error is not None and done >= LEAST_FOR_ERROR else None
        if progress:
            progress(*until.progress(done, now - start, error))
        stops = interrupted is not None and interrupted()
        if stops or done == until.samples or error is not None and error <= until.error:
            return film, done
        seconds, room = max(now - launched, 1e-6) / count, PASS_SECONDS
        if until.seconds is not None:
            left = until.seconds - (now - start) - (launched - begin if done > count else 0)
            if left < seconds:
                return film, done
            room = min(room, left)
        count = max(1, int(min(LONGEST_GROWTH * count, room / seconds)))


@dataclass(frozen=True)
class Lost:
    """Samples that were left out because they were NaN or infinite."""

    count: int
    examples: tuple  # of (kind, column, row, sample): `nan` or `inf`, the first of each kind in some pixel


def find_lost(view, film, samples):
    """Return the Lost of a film with so many samples a pixel, or None; the samples of a few pixels are repeated."""
    if not dr.any(film.lost > 0):
        return None
    count = int(dr.sum(Float64(film.lost)).item())
    pixels, examples = dr.compress(film.lost > 0), {}
    for k in range(min(MOST_EXAMPLES, len(pixels))):
        pixel = int(pixels[k])
        for first in range(0, samples, SEARCHED_AT_ONCE):
            radiance = view.follow(pixel, first, min(SEARCHED_AT_ONCE, samples - first))
            nan = dr.isnan(radiance.x) | dr.isnan(radiance.y) | dr.isnan(radiance.z)
            for kind, mask in (("nan", nan), ("inf", ~nan & ~is_finite(radiance))):
                found = dr.compress(mask)
                if kind not in examples and len(found):
                    examples[kind] = (kind, pixel % view.width, pixel // view.width, first + int(found[0]))
            if examples:
                break
        if len(examples) == 2:
            break
    return Lost(count, tuple(examples.values()))
