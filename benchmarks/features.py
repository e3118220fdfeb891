"""What each feature of the assignment sheets costs: the same scene with it and without it.

CPU time of all threads, in nanoseconds a sample, which is CPU milliseconds for a million samples. A picture is rendered
in one pass with many samples a pixel; recording its kernel is subtracted: the median that a picture of a few pixels
takes. The two sides take turns. What "without" means is said in each row: another scene, or a part of the renderer
left out while the kernel is recorded (benchmarks/feature_patches.py), where the program has no switch for it. Costs are
those of the scene: a mirror's paths go on where those of matt surfaces end, and a hierarchy takes less than nothing.
Shapes are added behind the camera, several at once: each costs its test against every ray, and is never seen.

Mitsuba's times are those of the same pair of scenes with its `path` integrator and `independent` sampler, where it has
the feature. Compiling is the time for all kernels of a picture in a process that began with an empty cache.

A second table has what is done once a picture: tone curves and files, by pixel.
"""

from __future__ import annotations

import json
import sys
import tempfile
from functools import partial
from pathlib import Path

from benchmarks import features_worker, scenes
from benchmarks.feature_scenes import FAMILIES, SCENES, SMALLER
from benchmarks.features_worker import HAVING, SECONDS_TO_NS, WITHOUT
from benchmarks.measure import interleaved, result, run_process, spread

REPEATS = 5  # at most
PICTURE = "scene"  # that is tone mapped and written
CALLS = 4  # of these in one measurement
CURVES = ("linear", "reinhard", "filmic")


def measure(effort):
    """Return the cost of each feature, and what is done once a picture costs."""
    keys = [key for key in SCENES if not effort.scenes or key in effort.scenes]
    size = max(effort.width // SMALLER, 1), max(effort.height // SMALLER, 1)
    rows = []
    for family in FAMILIES:
        some = [key for key in family if key in keys]
        print(f"  {', '.join(some)}", file=sys.stderr)
        found = _measured(some, size, effort) if some else {}
        rows += [row(key, SCENES[key], found[key]) for key in some]
    return result([], features=rows, pictures=[] if effort.scenes else pictures(effort))


def _measured(keys, size, effort):
    """Return what a worker process finds of features."""
    with tempfile.TemporaryDirectory() as cache:
        output = run_process("-m", features_worker.__name__, ",".join(keys), f"{size[0]}x{size[1]}", effort.samples,
                             min(effort.repeats, REPEATS), DRJIT_CACHE_DIR=cache).output  # fmt: skip
    return json.loads(output.splitlines()[-1])


def row(key, feature, found):
    """Return the row of a Feature from what the worker found."""
    having, without = found[HAVING], found[WITHOUT]
    both = list(zip(having["ns"], without["ns"]))
    return {
        "feature": key, "scene": feature.scene, "with": feature.having.said, "without": feature.without.said,
        "ns a sample with": spread(having["ns"]), "ns a sample without": spread(without["ns"]),
        "cost (ns a sample)": spread([(a - b) / feature.pieces for a, b in both]),
        "time, x without": spread([a / b for a, b in both]),
        "Mitsuba's, x without": _ratio(having, without) if feature.mitsuba else None,
        "Mitsuba with, x ours": spread([a / b for a, b in zip(having["theirs"], having["ns"])])
        if feature.mitsuba else None,
        "compile with (s)": having["compile"], "compile without (s)": without["compile"],
        "operations with": having["operations"], "operations without": without["operations"],
    }  # fmt: skip


def _ratio(having, without):
    """Return the spread of Mitsuba's times with, over those without, turn by turn."""
    return spread([a / b for a, b in zip(having["theirs"], without["theirs"])])


def pictures(effort):
    """Return the rows of what is done once a picture."""
    from renderer.engine.render import render
    from renderer.io.image import write_exr, write_png, write_ppm

    rendering = render(scenes.load(PICTURE, effort))
    bytes8, size = rendering.rgb8(), (effort.width, effort.height)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        actions = {("basic.image_ppm", "PPM file"): partial(write_ppm, folder / "a.ppm", bytes8, *size),
                   ("basic.image_png", "PNG file"): partial(write_png, folder / "a.png", bytes8, *size)}  # fmt: skip
        actions |= {(f"basic.tonemap_{curve}", f"curve {curve}, to bytes"): partial(rendering.rgb8, curve)
                    for curve in CURVES}  # fmt: skip
        exr = {("basic.image_exr", "EXR file"): lambda: write_exr(folder / "a.exr", rendering.channels(), {})}
        repeats = min(effort.repeats, REPEATS)
        # by itself, because what its threads still do counts for what comes next
        seconds = interleaved(actions, repeats, CALLS) | interleaved(exr, repeats)
    pixels = effort.width * effort.height
    return [{"feature": key, "what": said, "CPU ns a pixel": spread([SECONDS_TO_NS * one / pixels for one in times])}
            for (key, said), times in seconds.items()]  # fmt: skip
