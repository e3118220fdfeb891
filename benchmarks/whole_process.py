"""The command as a user types it: wall time and memory of the whole process.

Warm: Dr.Jit's kernel cache holds the kernels. Cold: the cache is empty; the files of Python and of the libraries are
in the system's memory in both cases. The caches are folders of this benchmark's own, and runs of all scenes take turns.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from benchmarks import scenes
from benchmarks.measure import ROOT, result, run_process, spread
from benchmarks.targets import LOWER, Figure

STAGES = Path(__file__).with_name("stages.py")
JUDGED = "scene"
IMPORTED = ("sys", "renderer.cli", "drjit", "numpy", "mitsuba")  # sys is always there: nothing but the interpreter
WARM_AT_MOST, COLD_AT_MOST, PEAK_AT_MOST = 0.6, 1.5, 400.0  # s, s, MB


def measure(effort, names=scenes.COURSEWORK):
    """Return wall times, memory, the cost of a further sample, and what the time of a start consists of."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        runs = {name: _Runs(name, effort, folder) for name in names}
        for one in runs.values():
            one.fill_cache()
        for _ in range(effort.repeats):
            for one in runs.values():
                one.repeat()
        stages = _stages(JUDGED, effort, folder)
    rows = [one.row() for one in runs.values()]
    figures = _figures({row["scene"]: row for row in rows})
    return result(figures, processes=rows, stages=stages, imports=_imports(effort))


class _Runs:
    """All runs of one scene."""

    def __init__(self, name, effort, folder):
        self._name, self._effort, self._folder = name, effort, folder
        self._cache = folder / "kernels"
        self._warm, self._cold, self._many = [], [], []

    def fill_cache(self):
        """Make the warm runs warm."""
        self._run(1, self._cache)
        self._run(self._effort.samples, self._cache)

    def repeat(self):
        """Run the command once in each way."""
        self._warm.append(self._run(1, self._cache))
        self._many.append(self._run(self._effort.samples, self._cache))
        with tempfile.TemporaryDirectory(dir=self._folder) as cache:
            self._cold.append(self._run(1, cache))

    def _run(self, samples, cache):
        """Return the Finished run of the command."""
        arguments = command(self._name, self._effort, samples, self._folder / "picture.ppm")
        return run_process(*arguments, DRJIT_CACHE_DIR=cache)

    def row(self):
        """Return what was found as a row of the table."""
        further = self._effort.samples - 1
        marginal = [(many.wall - one.wall) / further * 1000 for one, many in zip(self._warm, self._many)]
        return {
            "scene": self._name,
            "warm start (s)": spread([run.wall for run in self._warm]),
            "cold start (s)": spread([run.wall for run in self._cold]),
            "CPU time, warm (s)": spread([run.cpu for run in self._warm]),
            "a further sample (ms)": spread(marginal),
            "peak memory (MB)": max(run.peak for run in self._warm + self._cold),
            f"peak memory, {self._effort.samples} samples (MB)": max(run.peak for run in self._many),
            "fastest public solution (s)": scenes.PUBLIC_WALL[self._name],
        }


def command(name, effort, samples, picture):
    """Return the arguments of Python that render a scene: at its own size and samples just the plain command."""
    arguments = ["-m", "renderer", scenes.path(name), "-o", picture]
    loaded = scenes.loader.load(ROOT / scenes.path(name))
    camera = loaded.description.camera
    if (effort.width, effort.height) != (camera.width, camera.height):
        arguments += ["--size", f"{effort.width}x{effort.height}"]
    if samples != loaded.description.spp:
        arguments += ["--samples", samples]
    return arguments


def _stages(name, effort, folder):
    """Return rows of seconds by stage of a process that does what the command does, warm and cold."""
    arguments = STAGES, scenes.path(name), f"{effort.width}x{effort.height}", folder / "picture.ppm"
    run_process(*arguments, DRJIT_CACHE_DIR=folder / "kernels")
    warm, cold = [], []
    for _ in range(effort.repeats):
        warm.append(_stage_seconds(run_process(*arguments, DRJIT_CACHE_DIR=folder / "kernels")))
        with tempfile.TemporaryDirectory(dir=folder) as cache:
            cold.append(_stage_seconds(run_process(*arguments, DRJIT_CACHE_DIR=cache)))
    return [
        {"stage": stage, "warm (s)": spread([run[stage] for run in warm]),
         "cold (s)": spread([run[stage] for run in cold])}
        for stage in warm[0]
    ]  # fmt: skip


def _stage_seconds(run):
    """Return {stage: seconds} of a run of stages.py, from the start of the process to its end."""
    told = json.loads(run.output)
    seconds = {"start of the interpreter": told["started"] - run.spawned, **told["stages"]}
    return seconds | {"end of the process": run.ended - told["done"], "in all": run.wall}


def _imports(effort):
    """Return rows of seconds that processes need which only import something: what a start can save or must pay."""
    rows = []
    for name in IMPORTED:
        program = f"import {name}, os; os._exit(0)"
        walls = [run_process("-c", program).wall for _ in range(effort.repeats + 1)]
        rows.append({"a process that imports": name, "wall (s)": spread(walls[1:])})  # the first reads the files
    return rows


def _figures(rows):
    """Return the judged figures; the other scenes are held to the fastest public solution only."""
    judged = rows[JUDGED]
    yield Figure(f"{JUDGED}, whole process, warm", "s", LOWER, judged["warm start (s)"]["median"], WARM_AT_MOST,
                 scenes.PUBLIC_WALL[JUDGED])
    yield Figure(f"{JUDGED}, whole process, cold", "s", LOWER, judged["cold start (s)"]["median"], COLD_AT_MOST)
    yield Figure(f"{JUDGED}, peak memory", "MB", LOWER, judged["peak memory (MB)"], PEAK_AT_MOST)
    for name, row in rows.items():
        if name != JUDGED:
            yield Figure(f"{name}, whole process, warm", "s", LOWER, row["warm start (s)"]["median"],
                         aim=scenes.PUBLIC_WALL[name])
