"""What falls short: figures that missed what was asked of them, and light that is lost."""

from __future__ import annotations

from pathlib import Path

from benchmarks import plots
from benchmarks.error_curves import EQUAL_SAMPLES
from benchmarks.table import figures
from tests.stability.furnace import exact_albedo
from tools.report import results

HEAD_ON = 1.0  # cosine
ROUGH, ROUGHEST = 0.5, 1.0  # alpha
SMALLEST = "binary_primitives"
UNITS = {"x": "", "x Mitsuba": " beside Mitsuba", "x smallest mesh": " beside the smallest mesh"}  # ratios


def make(folder: Path) -> dict[str, str | list]:
    """Return the table of what was missed, and numbers for the text."""
    judged = figures(results.results())
    asked = [figure for figure in judged if figure.least is not None]
    aims = [figure for figure in judged if figure.aim is not None]
    missed = [figure for figure in asked if not figure.holds(figure.least)]
    start = results.row("whole_process", "processes", scene=SMALLEST)
    return {
        "missed": [[name(figure), *(results.digits(value, 3) for value in (figure.reached, figure.least))]
                   for figure in missed],
        "missed_count": results.words(len(missed)), "asked": str(len(asked)), "aims": str(len(aims)),
        "aims_missed": str(sum(not figure.holds(figure.aim) for figure in aims)),
        "lost_rough": lost(ROUGH), "lost_roughest": lost(ROUGHEST),
        "start": results.seconds(results.median(start["warm start (s)"])),
        "start_public": results.seconds(start["fastest public solution (s)"]),
        "caustics": results.times(error("caustics") / error("thin_lens")),
    }  # fmt: skip


def name(figure):
    """Return a figure's name with its unit, and with large numbers in groups of three digits."""
    words = (f"{int(word):,}" if word.isdecimal() else word for word in figure.name.split(" "))
    return " ".join(words).replace(" x ", " × ") + UNITS.get(figure.unit, f", {figure.unit}")


def lost(alpha):
    """Return the share of light that white rough metal loses of what comes straight from above."""
    return results.percent(1 - float(exact_albedo(alpha, HEAD_ON)))


def error(scene):
    """Return our relative error of a scene with as many samples as equal error is taken at."""
    row = results.row("error", plots.CURVES, scene=scene, contender="ours", **{plots.SAMPLES: EQUAL_SAMPLES})
    return results.median(row[plots.ERROR])
