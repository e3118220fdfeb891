"""What the decisions behind the renderer's speed are worth: `scene` rendered as it is, and with each of them undone.

Gathers (SELECT_LIMIT 0) read the records of the shapes that were hit, instead of chains of selects. Loops (UNROLL_LIMIT
0) go over the shapes in the kernel, instead of code for each of them. All directions as values: zeros and ones of
normals and axes are read like other numbers, instead of being left out of the kernel. All values as constants:
colours, radii and the rest are compiled into the kernel, and every edit compiles another. FastMath off compiles exact
floating point. One lane a sample: a lane ends with its path instead of starting the pixel's next sample. CPU time of
renders in turns.
"""

from __future__ import annotations

from contextlib import contextmanager, nullcontext
from functools import partial

import drjit as dr

from benchmarks import scenes
from benchmarks.measure import interleaved, result, spread
from renderer.core import rows
from renderer.core.backend import UInt32, Vector3f
from renderer.engine.film import Film
from renderer.engine.loop import pixel_corner, sample_pixels
from renderer.engine.render import render, set_up

SCENE = "scene"
TOGETHER = 16  # samples of a pixel that have lanes of their own at the same time, if each sample has one


def measure(effort):
    """Return the throughput of each variant, and its time as a multiple of the renderer's as it is."""
    loaded = scenes.load(SCENE, effort, effort.samples)
    settings = {
        "as it is": nullcontext,
        "gathers instead of selects": partial(_patched, SELECT_LIMIT=0),
        "loops instead of unrolling": partial(_patched, UNROLL_LIMIT=0),
        "loops and gathers": partial(_patched, SELECT_LIMIT=0, UNROLL_LIMIT=0),
        "all directions as values": partial(_patched, AXIS_VALUES=()),
        "all values as constants": partial(_patched, ALL_CONSTANT=True),
        "FastMath off": partial(dr.scoped_set_flag, dr.JitFlag.FastMath, False),
    }
    actions = {name: partial(_render, loaded, setting) for name, setting in settings.items()}
    actions["one lane a sample"] = partial(lane_per_sample, loaded)
    seconds = interleaved(actions, effort.repeats)
    millions, usual = effort.width * effort.height * effort.samples / 1e6, seconds["as it is"]
    table = [
        {"variant": name, "M samples/CPU s": spread([millions / time for time in times]),
         "time, x as it is": spread([time / base for time, base in zip(times, usual)])}
        for name, times in seconds.items()
    ]  # fmt: skip
    return result([], variants=table)


def _render(loaded, setting):
    """Render with a setting in force."""
    with setting():
        render(loaded)


@contextmanager
def _patched(**limits):
    """Replace limits of renderer.core.rows for a while."""
    before = {name: getattr(rows, name) for name in limits}
    try:
        for name, value in limits.items():
            setattr(rows, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(rows, name, value)


def lane_per_sample(loaded):
    """Return the mean of the same samples that `render` takes (seed 0), each traced by a lane of its own."""
    description, (_, view) = loaded.description, set_up(loaded)
    pixels, together = view.width * view.height, min(TOGETHER, description.spp)
    lane = dr.arange(UInt32, pixels * together)
    pixel = lane // dr.opaque(UInt32, together)
    corner = pixel_corner(pixel, dr.opaque(UInt32, view.width))
    sampler = view.sampler(pixel, dr.opaque(UInt32, view.seed))
    total = dr.zeros(Vector3f, pixels)
    for done in range(0, description.spp, together):
        sample = lane - pixel * together + dr.opaque(UInt32, done)
        film = Film.empty(pixels * together, single=True)
        film = sample_pixels(view.integrator, view.ray, sampler, corner, film, (sample, sample + 1))
        total += dr.block_sum(film.total, together)
        dr.eval(total)
        dr.sync_thread()
    return total / description.spp
