"""From a loaded scene to a picture: builds, renders in passes, and hands out 8-bit and linear results."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import drjit as dr

from renderer.core import backend
from renderer.core.backend import Float, UInt32, Vector2f, Vector3f
from renderer.core.records import Ray
from renderer.core.tones import NEUTRAL_EXPOSURE
from renderer.engine import tonemap as tonemapping
from renderer.engine.filters import FILTERS
from renderer.engine.loop import pixel_corner
from renderer.engine.passes import LEAST_SECONDS, Lost, Until, View, find_lost, refine
from renderer.integrators import first_hit, integrator_of
from renderer.samplers import KINDS as SAMPLERS
from renderer.scene.arrange import AUTO
from renderer.scene.schema import DEBUG_MODES, PATHTRACER, SHADED_MODES, encoding_of
from renderer.scene.tables import compile_camera, compile_scene


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
    samples: int  # a pixel, rendered
    timings: Timings
    lost: Lost | None  # samples that were left out
    _colour: Vector3f  # linear, one lane a pixel, mean over the samples; of debug modes the picture in [0, 1]
    _named: dict  # raw channels of debug modes
    _beside: Callable  # () -> further channels, for who wants them
    _tonemap: str
    _exposure: float

    @property
    def samples_per_second(self):
        """Samples of all pixels together over the time spent rendering."""
        return self.width * self.height * self.samples / max(self.timings.render, LEAST_SECONDS)

    def with_colour(self, colour):
        """Return the rendering with another picture: a (height, width, 3) float32 array of linear radiance."""
        channels = (backend.from_host(Float, colour[..., k].reshape(-1).copy()) for k in range(3))
        return replace(self, _colour=Vector3f(*channels))

    def rgb8(self, tonemap=None, exposure=None, encoding=None):
        """Return the picture as bytes, three a pixel, rows from the top; None stands for the scene's own setting.

        Path-traced pictures are encoded by the sRGB curve unless told otherwise. Pictures that show facts, not light,
        are neither tone mapped nor encoded.
        """
        scale, curve, coding = 1.0, "linear", "linear"
        if self.mode in SHADED_MODES:
            exposure = self._exposure if exposure is None else exposure
            scale, curve = exposure / NEUTRAL_EXPOSURE, tonemap or self._tonemap
            coding = encoding or encoding_of(self.mode)
        channels = [tonemapping.to_bytes(c, dr.opaque(Float, scale), curve, coding) for c in self._colour]
        dr.eval(channels)
        picture = bytearray(3 * self.width * self.height)
        for offset, channel in enumerate(channels):
            picture[offset::3] = backend.host_bytes(channel)
        return bytes(picture)

    def channels(self, beside=False):
        """Return {EXR channel name: (height, width) array}: linear R, G, B, and the raw values of debug modes.

        `beside` adds, where light is shown, what the rays through the pixels' middles hit, and the samples' number and
        variance.
        """
        named = dict(zip("RGB", self._colour)) | self._named | (self._beside() if beside else {})
        return {name: lanes.numpy().reshape(self.height, self.width) for name, lanes in named.items()}


def render(loaded, *, seed=0, accel=AUTO, until=None, variance=False, progress=None, interrupted=None):
    """Return the Rendering of a LoadedScene.

    `accel` is one of arrange.STRUCTURES; `until` (Until) takes the place of the scene's number of samples; `variance`
    has that of the samples estimated. `progress(done, total)` is called between passes with samples a pixel, or shares
    of 1 where `until` has other limits; `interrupted()` is asked there whether to stop. Raises SceneError where a file
    that the scene names cannot be used.
    """
    description = loaded.description
    mode, size = description.rendermode, (description.camera.width, description.camera.height)
    start = time.perf_counter()
    scene, view = set_up(loaded, seed, accel, single=until is None and description.spp == 1)
    built = time.perf_counter()

    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        if mode in DEBUG_MODES:
            samples, exposure, beside = 1, None, dict
            colour, named = _first_hits(mode, scene, view)
        else:
            until = until or Until(description.spp)
            exposure = refine(view, until, variance=variance, progress=progress, interrupted=interrupted)
            samples, colour, named = exposure.samples, exposure.film.mean(exposure.taken), {}
            dr.eval(colour)

            def beside():
                return _beside(scene, view, exposure) if mode in SHADED_MODES else {}

        dr.sync_thread()
        history = dr.kernel_history()
    compiling = sum(kernel["codegen_time"] + kernel["backend_time"] for kernel in history if "backend_time" in kernel)
    rendered = time.perf_counter() - built
    timings = Timings(built - start, compiling / 1000, rendered - compiling / 1000)
    lost = None if exposure is None else find_lost(view, exposure)
    return Rendering(
        mode, *size, samples, timings, lost, colour, named, beside, description.tonemap, description.camera.exposure
    )


def replay(loaded, pixel, sample, *, seed=0, accel=AUTO):
    """Return the radiance of one sample of the picture, (R, G, B), whatever it is; `pixel` is (column, row).

    Raises ValueError for debug modes, which have no samples.
    """
    if loaded.description.rendermode in DEBUG_MODES:
        raise ValueError("no samples")
    _, view = set_up(loaded, seed, accel, single=loaded.description.spp == 1)
    radiance = view.follow(pixel[0] + pixel[1] * view.width, sample)
    return tuple(float(channel[0]) for channel in radiance)


def set_up(loaded, seed=0, accel=AUTO, single=False):
    """Return the compiled scene and the View of it; `single` samples go through the middle of their pixels."""
    description, mode = loaded.description, loaded.description.rendermode
    shows_bsdfs = mode == "albedo" and any(shape.material.bsdf is not None for _, shape in loaded.shapes)
    if mode == PATHTRACER or shows_bsdfs:
        from renderer.scene.paths import compile_paths  # the other modes start faster without

        scene = compile_paths(replace(loaded, description=replace(description, rendermode=PATHTRACER)), accel)
    else:
        scene = compile_scene(loaded, accel)
    centred = mode in DEBUG_MODES or single and mode != PATHTRACER
    camera = description.camera
    return scene, View(
        None if mode in DEBUG_MODES else integrator_of(mode)(scene, description.nbounces), compile_camera(camera),
        SAMPLERS[description.sampler], camera.width, camera.height, seed, centred,
        FILTERS["box" if centred else description.filter](),
    )


def _centre_hits(scene, view):
    """Return the rays through the pixels' middles and what they hit."""
    kind, row = view.camera
    corner = pixel_corner(dr.arange(UInt32, view.width * view.height), dr.opaque(UInt32, view.width))
    ray = Ray(*kind.ray(row, corner + Vector2f(0.5)))
    if scene.structure is None:
        return ray, scene.intersect(ray)
    from renderer.engine import queries  # small scenes start faster without

    return ray, queries.closest(scene, ray, coherent=True)


def _first_hits(mode, scene, view):
    """Return the picture and the raw channels of a debug mode."""
    named, colour = first_hit.channels(mode, scene, *_centre_hits(scene, view))
    pixels = view.width * view.height
    # values that are the same everywhere, as in an empty scene, are spread over all pixels
    named = {name: value + dr.zeros(type(value), pixels) for name, value in named.items()}
    colour += dr.zeros(Vector3f, pixels)
    dr.eval(named, colour)
    return colour, named


def _beside(scene, view, exposure):
    """Return the channels of first hits, and the number and the variance of samples where they were kept."""
    pixels, (ray, hit), named = view.width * view.height, _centre_hits(scene, view), {}
    film, taken = exposure.film, exposure.taken
    for mode in ("albedo", "normals", "depth", "shapes"):
        named |= first_hit.channels(mode, scene, ray, hit)[0]
    named["SampleCount"] = film.count(taken)
    if film.squares is not None:
        named["Variance"] = Float(film.variance(taken))
    named = {name: value + dr.zeros(type(value), pixels) for name, value in named.items()}
    dr.eval(named)
    return named
