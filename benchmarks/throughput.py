"""Throughput with many samples a pixel: million samples per CPU second, of all threads together.

Measured around a whole render in this process, from the loaded scene to the finished mean: building the arrays and
tracing the kernels are in it, compiling is not, as one render comes before. `scene glass` is `scene` with its mirror
sphere made of glass, whose rays split in two at every bounce.
"""

from __future__ import annotations

from benchmarks import scenes
from benchmarks.measure import interleaved, result, spread
from benchmarks.targets import HIGHER, Figure
from renderer.engine.render import render

SCENES = (*scenes.LIT, "scene glass")
AT_LEAST = {"scene": 30.0, "simple_phong": 60.0}  # million samples per CPU second
UNIT = "M samples/CPU s"


def measure(effort):
    """Return the throughput of each scene."""
    loaded = {name: scenes.load(name, effort, effort.samples) for name in SCENES}
    seconds = interleaved({name: lambda one=one: render(one) for name, one in loaded.items()}, effort.repeats)
    millions = effort.width * effort.height * effort.samples / 1e6
    rows = [
        {"scene": name, UNIT: spread([millions / time for time in times]), "CPU seconds of a render": spread(times),
         "best public solution": scenes.PUBLIC_THROUGHPUT.get(name)}
        for name, times in seconds.items()
    ]  # fmt: skip
    figures = [
        Figure(f"{row['scene']}, throughput", UNIT, HIGHER, row[UNIT]["median"], AT_LEAST.get(row["scene"]),
               row["best public solution"])
        for row in rows if row["best public solution"]
    ]  # fmt: skip
    return result(figures, throughput=rows)
