"""Path tracing beside Mitsuba's `path` (`llvm_ad_rgb`): speed, and error at equal time.

Each scene is rendered by both with the same number of samples a pixel, box filter, no Russian roulette, and the same
number of bounces. Time is CPU time of all threads around a whole render, kernels compiled before; ours includes
building the scene's arrays, Mitsuba's scene is loaded beforehand. Error is the relative mean squared error: the mean
over pixels and channels of variance / (mean^2 + 0.01), the variance of a pixel taken between renders with different
seeds, the mean from all renders of both. Speed is beside Mitsuba's `independent` sampler, error x time beside the stock
sampler for which that is smallest; `orthogonal` rounds samples up to a square of a prime, which counts in its time.
Bias: how far the two mean radiances are apart, as a share, and the same in standard errors of their difference.
"""

from __future__ import annotations

import dataclasses
import json
import math
import tempfile
import time
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

from benchmarks import path_scenes
from benchmarks.measure import result, run_process, spread
from benchmarks.targets import HIGHER, LOWER, Figure

mi.set_variant("llvm_ad_rgb")

from converters.mitsuba import to_dict  # noqa: E402
from renderer.engine.render import render  # noqa: E402
from renderer.scene import loader  # noqa: E402

SAMPLERS = ("independent", "stratified", "multijitter", "orthogonal", "ldsampler")
DARK = 0.01  # added to squared means, so that the error of black pixels stays finite
HALVED = 2  # sides of all pictures but the first scene's
REPEATS = 4  # at most, with a seed each
SEEDS = 1000  # Mitsuba's begin here: equal seeds must not meet
COURSEWORK, MESH = "coursework, area lights", "mesh of 100,000 triangles"
LEAST, AIM = {COURSEWORK: 6.0, MESH: 1.5}, {COURSEWORK: 12.0, MESH: 3.0}
LEAST_ELSEWHERE, AIM_ELSEWHERE = 4.0, 10.0
LEAST_SPEED, AIM_SPEED = 6.0, 10.0
MEMORY, FIRST_PICTURE = (500.0, 250.0), (1.5, 0.7)  # MB, s: at most, and aim


def measure(effort):
    """Return speed and error x time of each scene beside Mitsuba's, and what a process takes."""
    rows, samplers = [], []
    for name, make in path_scenes.SCENES.items():
        if effort.scenes and name not in effort.scenes:
            continue
        with tempfile.TemporaryDirectory() as folder:
            row, table = _compare(name, make(Path(folder)), folder, effort)
        rows.append(row)
        samplers += table
    process = _process(effort)
    figures = [
        Figure(f"{COURSEWORK}, samples per second beside Mitsuba", "x", HIGHER,
               row["speed with Mitsuba's estimator, x Mitsuba"]["median"], LEAST_SPEED, AIM_SPEED)
        for row in rows if row["scene"] == COURSEWORK
    ]  # fmt: skip
    figures += [
        Figure(f"{row['scene']}, error x time beside Mitsuba's best sampler", "x", HIGHER,
               row["error x time, x Mitsuba"], LEAST.get(row["scene"], LEAST_ELSEWHERE),
               AIM.get(row["scene"], AIM_ELSEWHERE))
        for row in rows
    ]  # fmt: skip
    peak, first = (process[key]["median"] for key in ("peak memory, many samples (MB)", "first picture, warm (s)"))
    figures.append(Figure("path-traced picture, peak memory", "MB", LOWER, peak, *MEMORY))
    figures.append(Figure("path-traced picture, first one, warm", "s", LOWER, first, *FIRST_PICTURE))
    return result(figures, paths=rows, processes=[process], **{"Mitsuba's samplers": samplers})


def _compare(name, document, folder, effort):
    """Return the row of one scene, and those of Mitsuba's samplers on it."""
    share = 1 if name == COURSEWORK else HALVED
    width, height = effort.width // share, effort.height // share
    document["roulette"] = False
    loaded = loader.override(loader.from_dict(document, directory=folder), width=width, height=height,
                             samples=effort.samples)  # fmt: skip
    plain = dataclasses.replace(loaded, description=dataclasses.replace(loaded.description, mirrorlight=False))
    sides = {"ours": Ours(loaded), "plain": Ours(plain)} | {name: Theirs(loaded, name) for name in SAMPLERS}
    for side in sides.values():
        side.render(0)
    runs = {side: [] for side in sides}
    for seed in range(1, max(min(effort.repeats, REPEATS), 2) + 1):
        for side, renderer in sides.items():
            runs[side].append(_timed(renderer, seed))
    mean = np.mean([picture for pairs in runs.values() for _, picture in pairs], axis=0)
    found = {side: _judged(pairs, mean) for side, pairs in runs.items()}
    best = min(SAMPLERS, key=lambda sampler: found[sampler]["error x time"])
    ours, plain, theirs = found["ours"], found["plain"], found[SAMPLERS[0]]
    millions = width * height * effort.samples / 1e6
    apart, errors = _apart([picture for _, picture in runs["ours"]],
                           [picture for sampler in SAMPLERS for _, picture in runs[sampler]])  # fmt: skip
    row = {
        "scene": name, "speed, x Mitsuba": _ratio(theirs, ours),
        "speed with Mitsuba's estimator, x Mitsuba": _ratio(theirs, plain),
        "error x time, x Mitsuba": found[best]["error x time"] / ours["error x time"],
        "the same with Mitsuba's estimator": found[best]["error x time"] / plain["error x time"],
        "Mitsuba's best sampler": best,
        "our M samples/CPU s": float(millions / np.median(ours["times"])), "our relative MSE": f"{ours['error']:.2e}",
        f"relative MSE, x Mitsuba's {SAMPLERS[0]}": ours["error"] / theirs["error"],
        "means apart": f"{apart:.1e}", "in standard errors": errors,
    }  # fmt: skip
    table = [{"scene": name, "sampler": sampler,
              "M samples/CPU s": float(millions / np.median(found[sampler]["times"])),
              "relative MSE": f"{found[sampler]['error']:.2e}", "error x time": f"{found[sampler]['error x time']:.2e}"}
             for sampler in SAMPLERS]  # fmt: skip
    return row, table


def _ratio(theirs, ours):
    """Return the spread of the ratios of times, turn by turn."""
    return spread([b / a for a, b in zip(ours["times"], theirs["times"])])


def _process(effort):
    """Return how long a whole process takes to its first picture, and how much memory."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        scene = folder / "scene.json"
        document = path_scenes.coursework(folder)
        document["camera"] |= {"width": effort.width, "height": effort.height}
        scene.write_text(json.dumps(document))

        def run(samples):
            return run_process("-m", "renderer", scene, "--mode", "pathtracer", "--samples", samples, "-o",
                               folder / "picture.ppm")

        run(1)
        first = [run(1) for _ in range(effort.repeats)]
        many = [run(effort.samples) for _ in range(2)]
    return {
        "scene": COURSEWORK, "first picture, warm (s)": spread([one.wall for one in first]),
        "peak memory, one sample (MB)": spread([one.peak for one in first]),
        "peak memory, many samples (MB)": spread([one.peak for one in many]), "samples a pixel": effort.samples,
    }  # fmt: skip


def _timed(renderer, seed):
    """Return (CPU seconds, picture) of a render."""
    start = time.process_time()
    picture = renderer.render(seed)
    return time.process_time() - start, renderer.as_array(picture)


def _judged(runs, mean):
    """Return times, error and their product."""
    times = [seconds for seconds, _ in runs]
    variance = np.var([picture for _, picture in runs], axis=0, ddof=1)
    error = float((variance / (mean**2 + DARK)).mean())
    return {"times": times, "error": error, "error x time": error * float(np.median(times))}


def _apart(ours, theirs):
    """Return the difference of two means of renders as a share, and in its own standard errors."""
    means = [np.array([picture.mean() for picture in side]) for side in (ours, theirs)]
    difference = means[0].mean() - means[1].mean()
    error = math.sqrt(sum(side.var(ddof=1) / len(side) for side in means))
    return float(difference / means[1].mean()), float(difference / max(error, 1e-12))


class Ours:
    """Our renderer."""

    def __init__(self, loaded):
        self._loaded = loaded

    def render(self, seed):
        """Return the finished Rendering."""
        return render(self._loaded, seed=seed)

    @staticmethod
    def as_array(rendering):
        """Return (H, W, 3) float64."""
        channels = rendering.channels()
        return np.stack([channels[c] for c in "RGB"], axis=-1).astype(np.float64)


class Theirs:
    """Mitsuba with one of its samplers."""

    def __init__(self, loaded, sampler):
        self._samples = loaded.description.spp
        scene = to_dict(loaded, exact=True)
        scene["sensor"]["sampler"] = {"type": sampler, "sample_count": self._samples}
        self._scene = mi.load_dict(scene)

    def render(self, seed):
        """Return the finished picture."""
        picture = mi.render(self._scene, spp=self._samples, seed=SEEDS + seed)
        dr.eval(picture)
        dr.sync_thread()
        return picture

    @staticmethod
    def as_array(picture):
        """Return (H, W, 3) float64."""
        return picture.numpy().astype(np.float64)
