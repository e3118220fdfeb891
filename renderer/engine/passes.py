"""A picture in passes of bounded time, until there is enough.

A pass adds samples to one part of the picture. Many samples for a few pixels keep lanes busy, where few samples for
many would not: at the end of a pass, lanes wait for the last path of their packet. Rounds of passes bring all parts
to the same number of samples, one at first. All passes run one kernel: film, pixels and numbers of samples are its
inputs, and the bytes of the picture do not depend on parts and rounds.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import NAME, Float64, UInt32, Vector2f, new_scope
from renderer.engine.film import Film, is_finite, joined, relative_error
from renderer.engine.filters import Box
from renderer.engine.loop import follow_sample, pixel_corner, sample_pixels, sample_tiles
from renderer.engine.tiles import Tiles
from renderer.samplers.base import LENS, PIXEL
from renderer.scene.schema import MAX_SAMPLES

PASS_SECONDS = 0.5  # aim for the length of a pass: often enough for progress and Ctrl-C
LEAST_SECONDS = 1e-9  # for a clock that has not moved on
PART_PIXELS = 2**18 if NAME == "llvm" else 2**22  # of a part: work for two hundred threads, or for a GPU
LEAST_IN_PASS = 16  # samples a pixel, even if it takes longer: with fewer, waiting lanes cost more than a tenth
LONGEST_GROWTH = 64  # a round is at most this many times the one before
LEAST_FOR_ERROR = 16  # samples a pixel before their spread is believed
CAUTION = 0.9  # of the samples that an error seems to take, which is an estimate, are rendered before the next look
SEARCHED_AT_ONCE = 2**16  # samples of a pixel, when a lost one is looked for
MOST_EXAMPLES = 4  # pixels that are searched for lost samples


@dataclass(frozen=True)
class Until:
    """When a picture is done: as soon as one of these holds."""

    samples: int = MAX_SAMPLES  # a pixel
    seconds: float | None = None  # since the first pass began
    error: float | None = None  # film.relative_error

    def progress(self, done, seconds, error):
        """Return (done, total) of what is nearest to its end."""
        if self.seconds is None and self.error is None:
            return done, self.samples
        shares = [done / self.samples]
        if self.seconds is not None:
            shares.append(seconds / self.seconds)
        if self.error is not None and error is not None:
            # the error's square falls with the number of samples
            shares.append(min(1.0, (self.error / error) ** 2) if error > 0 else 1.0)
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
    centred: bool = False  # whether all rays go through the middles of their pixels and of the lens
    pixel_filter: object = Box()

    def ray(self, sampler, corner, sample):
        """Return origin and direction of samples' rays, and whether they count negatively (None: none ever does)."""
        kind, row = self.camera
        if self.centred:
            return *kind.ray(row, corner + Vector2f(0.5)), None
        offset = self.pixel_filter.offset(sampler.u2(sample, PIXEL))
        lens = sampler.u2(sample, LENS) if kind.has_lens else None
        return *kind.ray(row, corner + offset.position, lens), offset.negative

    def _inputs(self):
        """Return what `_lanes` needs of a kernel's inputs; to be made outside of loops."""
        return dr.opaque(UInt32, self.width), dr.opaque(UInt32, self.seed)

    def _lanes(self, pixel, width, seed):
        """Return the samplers and corners of pixel numbers."""
        return self.sampler(pixel, seed), pixel_corner(pixel, width)

    def expose(self, film, first, end, pixel=0):
        """Return the film with the samples from `first` up to `end`, not evaluated yet; its lanes begin at `pixel`."""
        new_scope()  # so that all passes have the kernel of the first
        inputs, count = self._inputs(), len(film.lost)
        span = dr.opaque(UInt32, first), dr.opaque(UInt32, end)
        if self.integrator.uneven and film.rest is not None:
            tiles = Tiles(self.width, pixel, count)
            return sample_tiles(
                self.integrator, self.ray, lambda pixel: self._lanes(pixel, *inputs), tiles, film, span
            )
        sampler, corner = self._lanes(dr.opaque(UInt32, pixel) + dr.arange(UInt32, count), *inputs)
        return sample_pixels(self.integrator, self.ray, sampler, corner, film, span)

    def follow(self, pixel, first, count=1):
        """Return the radiance of `count` samples of one pixel, evaluated, one lane each, whether finite or not."""
        sampler, corner = self._lanes(dr.opaque(UInt32, pixel) + dr.zeros(UInt32, count), *self._inputs())
        sample = dr.opaque(UInt32, first) + dr.arange(UInt32, count)
        dr.eval(sampler, corner, sample)
        radiance = follow_sample(self.integrator, self.ray, sampler, corner, sample)
        dr.eval(radiance)
        return radiance


@dataclass
class Part:
    """Some of the picture's pixels: their film, and how many samples a pixel it has."""

    pixel: int
    film: Film
    done: int = 0


@dataclass(frozen=True)
class Exposure:
    """What refinement came to."""

    film: Film  # of the whole picture, evaluated
    samples: int  # a pixel; where a limit fell into a round, some pixels have more
    taken: object  # by pixel; int where all have the same

    @staticmethod
    def of(parts):
        """Return the parts as one; they are used up."""
        samples = min(part.done for part in parts)
        if len(parts) == 1:
            return Exposure(parts[0].film, samples, samples)
        taken = samples
        if any(part.done != samples for part in parts):
            taken = dr.concat([dr.full(UInt32, part.done, len(part.film.lost)) for part in parts])
            dr.eval(taken)
        return Exposure(joined([part.film for part in parts]), samples, taken)


def refine(view, until, *, variance=False, progress=None, interrupted=None):
    """Return the Exposure; `variance` keeps what estimates that of the samples.

    `progress(done, total)` is called after every pass, then `interrupted()`, which tells whether to stop there.
    """
    error = estimated = None  # relative error, and the samples for which it was estimated
    start, goal, parts = time.perf_counter(), 1, _parts(view, until, variance or until.error is not None)
    while True:
        seconds, before = 0.0, parts[0].done
        for number, part in enumerate(parts, start=1):
            film = view.expose(part.film, part.done, goal, part.pixel)
            dr.eval(film)
            launched = time.perf_counter()  # what came before is tracing and, in the first pass, compilation
            dr.sync_thread()
            now = time.perf_counter()
            part.film, part.done, seconds = film, goal, seconds + now - launched
            done = before + (goal - before) * number / len(parts) if number < len(parts) else goal
            if number == len(parts) and until.error is not None and goal >= LEAST_FOR_ERROR:
                error, estimated = relative_error([part.film for part in parts], goal), goal
            if progress:
                about = None if error is None else error * (estimated / done) ** 0.5
                progress(*until.progress(done, now - start, about))
            out_of_time = until.seconds is not None and now - start >= until.seconds
            if interrupted is not None and interrupted() or out_of_time and parts[-1].done > 0:
                return Exposure.of(parts)
        step = _step(until, goal, error, seconds / (goal - before), len(parts), now - start)
        if step == 0:
            return Exposure.of(parts)
        goal += min(step, LONGEST_GROWTH * goal)


def _parts(view, until, variance):
    """Return the picture's parts, without samples."""
    pixels, signed = view.width * view.height, view.pixel_filter.signed
    if until.samples == 1:
        return [Part(0, Film.empty(pixels, single=True, signed=signed))]
    sizes = [min(PART_PIXELS, pixels - pixel) for pixel in range(0, pixels, PART_PIXELS)]
    # opaque, so that the first pass uses the kernel of the others
    films = (Film.empty(size, signed=signed, variance=variance).opaque() for size in sizes)
    return [Part(k * PART_PIXELS, film) for k, film in enumerate(films)]


def _step(until, done, error, seconds, parts, elapsed):
    """Return the samples a pixel of the next round, 0 for none; the last took `seconds` a sample, over all parts."""
    seconds = max(seconds, LEAST_SECONDS)
    step = max(LEAST_IN_PASS, int(PASS_SECONDS * parts / seconds))
    if error is not None:
        if error <= until.error:
            return 0
        step = min(step, 1 + int(CAUTION * done * ((error / until.error) ** 2 - 1)))
    elif until.error is not None:
        step = min(step, LEAST_FOR_ERROR - done)
    if until.seconds is not None:
        step = min(step, int((until.seconds - elapsed) / seconds))
    return max(0, min(step, until.samples - done))


@dataclass(frozen=True)
class Lost:
    """Samples that were left out because they were NaN or infinite."""

    count: int
    examples: tuple  # of (kind, column, row, sample): `nan` or `inf`, the first of each kind in some pixel


def find_lost(view, exposure):
    """Return the Lost of an Exposure, or None; the samples of a few pixels are followed again."""
    film, taken = exposure.film, exposure.taken
    if not dr.any(film.lost > 0):
        return None
    count = int(dr.sum(Float64(film.lost)).item())
    pixels, examples = dr.compress(film.lost > 0), {}
    for k in range(min(MOST_EXAMPLES, len(pixels))):
        pixel = int(pixels[k])
        samples = taken if isinstance(taken, int) else int(taken[pixel])
        for kind, sample in _first_lost(view, pixel, samples).items():
            examples.setdefault(kind, (kind, pixel % view.width, pixel // view.width, sample))
    return Lost(count, tuple(examples.values()))


def _first_lost(view, pixel, samples):
    """Return {kind: number} of the first samples of a pixel that are NaN or infinite."""
    found = {}
    for first in range(0, samples, SEARCHED_AT_ONCE):
        radiance = view.follow(pixel, first, min(SEARCHED_AT_ONCE, samples - first))
        nan = dr.isnan(radiance.x) | dr.isnan(radiance.y) | dr.isnan(radiance.z)
        for kind, mask in (("nan", nan), ("inf", ~nan & ~is_finite(radiance))):
            places = dr.compress(mask)
            if len(places):
                found.setdefault(kind, first + int(places[0]))
        if found:
            break
    return found
