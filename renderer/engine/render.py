"""From a loaded scene to a picture: builds, renders in passes, and hands out 8-bit and linear results."""

from __future__ import annotations

import time
from dataclasses import dataclass

import drjit as dr

from renderer.core import backend
from renderer.core.backend import Float, UInt32, Vector2f, Vector3f
from renderer.core.records import Ray
from renderer.engine import tonemap as tonemapping
from renderer.engine.film import Film
from renderer.engine.loop import pixel_corner, sample_pixels
from renderer.integrators import INTEGRATORS, first_hit
from renderer.samplers import KINDS as SAMPLERS
from renderer.scene.tables import compile_camera, compile_scene
from renderer.scene.arrange import AUTO
from renderer.scene.schema import DEBUG_MODES, PATHTRACER

PASS_SECONDS = 0.5  # aim for the length of a pass: often enough for progress and Ctrl-C
FIRST_PASS_SAMPLES = 4
LONGEST_GROWTH = 8  # a pass is at most this many times the one before


@dataclass(frozen=True)
class Timings:
    """Wall-clock seconds."""

    build: float  # scene to device arrays
    compile: float  # kernels; 0 where they came from the cache
    render: float


@dataclass(frozen=True)
class Rendering:
    """A finished picture."""

    mode: str
    width: int
    height: int
    samples: int
    timings: Timings
    _colour: Vector3f  # linear, one lane a pixel, mean over the samples; of debug modes the picture in [0, 1]
    _named: dict  # raw channels of debug modes
    _tonemap: str
    _exposure: float

    @property
    def samples_per_second(self):
        """Samples of all pixels together over the time spent rendering."""
        return self.width * self.height * self.samples / max(self.timings.render, 1e-9)

    def rgb8(self, tonemap=None, exposure=None, encoding="linear"):
        """Return the picture as bytes, three a pixel, rows from the top; None stands for the scene's own setting.

        Only phong pictures are tone mapped: the others show facts, not light.
        """
        scale, curve, coding = 1.0, "linear", "linear"
        if self.mode == "phong":
            exposure = self._exposure if exposure is None else exposure
            scale, curve, coding = exposure / tonemapping.NEUTRAL_EXPOSURE, tonemap or self._tonemap, encoding
        channels = [tonemapping.to_bytes(c, dr.opaque(Float, scale), curve, coding) for c in self._colour]
        dr.eval(channels)
        picture = bytearray(3 * self.width * self.height)
        for offset, channel in enumerate(channels):
            picture[offset::3] = backend.host_bytes(channel)
        return bytes(picture)

    def channels(self):
        """Return {EXR channel name: (height, width) array}: linear R, G, B, and the raw values of debug modes."""
        named = dict(zip("RGB", self._colour)) | self._named
        return {name: lanes.numpy().reshape(self.height, self.width) for name, lanes in named.items()}


def render(loaded, *, seed=0, accel=AUTO, progress=None):
    """Return the Rendering of a LoadedScene.

    `accel` is one of arrange.STRUCTURES. `progress(done, total)` is called between passes with samples a pixel. Raises SceneError where a file that the
    scene names cannot be used.
    """
    description = loaded.description
    size = description.camera.width, description.camera.height
    start = time.perf_counter()
    scene = _compiled(loaded, accel)
    camera = compile_camera(description.camera)
    built = time.perf_counter()

    mode, samples = description.rendermode, description.spp
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        if mode in DEBUG_MODES:
            samples = 1
            colour, named = _first_hits(mode, scene, camera, *size)
        else:
            integrator = INTEGRATORS[mode](scene, description.nbounces)
            sampler = SAMPLERS[description.sampler]
            centred = samples == 1 and mode != PATHTRACER
            colour, named = _sampled(integrator, camera, sampler, *size, samples, seed, centred, progress), {}
        dr.sync_thread()
        history = dr.kernel_history()
    compiling = sum(kernel["codegen_time"] + kernel["backend_time"] for kernel in history if "backend_time" in kernel)
    rendered = time.perf_counter() - built
    timings = Timings(built - start, compiling / 1000, rendered - compiling / 1000)
    return Rendering(
        mode, *size, samples, timings, colour, named, description.tonemap, description.camera.exposure
    )


def _compiled(loaded, accel):
    """Return the scene as its mode sees it."""
    if loaded.description.rendermode == PATHTRACER:
        from renderer.scene.paths import compile_paths  # the other modes start faster without

        return compile_paths(loaded, accel)
    return compile_scene(loaded, accel)


def _first_hits(mode, scene, camera, width, height):
    """Return the picture and the raw channels of a debug mode."""
    kind, row = camera
    corner = pixel_corner(dr.arange(UInt32, width * height), dr.opaque(UInt32, width))
    ray = Ray(*kind.ray(row, corner + Vector2f(0.5)))
    if scene.structure is None:
        hit = scene.intersect(ray)
    else:
        from renderer.engine import queries  # small scenes start faster without

        hit = queries.closest(scene, ray, coherent=True)
    named, colour = first_hit.channels(mode, scene, ray, hit)
    # values that are the same everywhere, as in an empty scene, are spread over all pixels
    named = {name: value + dr.zeros(type(value), width * height) for name, value in named.items()}
    colour += dr.zeros(Vector3f, width * height)
    dr.eval(named, colour)
    return colour, named


def _sampled(integrator, camera, sampler, width, height, samples, seed, centred, progress):
    """Return the mean of the samples; a pass renders a few of them, so many that it takes about PASS_SECONDS."""
    pixel = dr.arange(UInt32, width * height)
    corner = pixel_corner(pixel, dr.opaque(UInt32, width))
    sampler = sampler(pixel, dr.opaque(UInt32, seed))
    film, done, count = Film.empty(width * height, samples == 1), 0, min(samples, FIRST_PASS_SAMPLES)
    if samples > count:
        dr.make_opaque(film)  # so that the first pass uses the same kernel as the others
    while done < samples:
        start, end = time.perf_counter(), min(done + count, samples)
        film = sample_pixels(
            integrator, camera, sampler, corner, film, dr.opaque(UInt32, done), dr.opaque(UInt32, end), centred
        )
        dr.eval(film)
        dr.sync_thread()
        if progress:
            progress(end, samples)
        seconds = max(time.perf_counter() - start, 1e-6)
        count = max(1, int(count * min(LONGEST_GROWTH, PASS_SECONDS / seconds)))
        done = end
    colour = film.mean(samples)
    dr.eval(colour)
    return colour
