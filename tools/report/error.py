"""Speed against error: the plots of benchmark `error` for print, and its tables in short."""

from __future__ import annotations

import math
from pathlib import Path

from benchmarks import plots
from benchmarks.error_curves import EQUAL_SAMPLES, MARGIN
from benchmarks.error_scenes import HEIGHT, WIDTH
from benchmarks.table import QUIET_LOAD
from benchmarks.targets import Figure
from tools.report import drawing, results

COLUMNS = 4  # of small plots
DECADES = 9  # of an axis: every one has a line
BEST, PLAIN, SCALAR = "llvm best, x Mitsuba", "llvm independent, x Mitsuba", "scalar best, x Mitsuba"
LEAST = "llvm best, at the least error of both"
OURS, THEIRS = "ours", "llvm independent"
MESHES = "mesh_100k", "mesh_1m"
BY_CHANCE = "glossy", "caustics"  # where only the points of samples make a difference


def make(folder: Path) -> dict[str, str | list]:
    """Write curves.svg and speedup.svg, and return tables and numbers."""
    rows, equal = results.table("error", plots.CURVES), results.table("error", plots.SPEEDUPS)
    with drawing.in_print():
        drawing.save(of_curves(rows, [row["scene"] for row in equal]), folder / "curves.svg")
        drawing.save(of_speedups(equal), folder / "speedup.svg")
    points = max(beside_best(row) for row in equal if row["scene"] in BY_CHANCE)
    return of_table(equal) | extremes(equal) | {"points": results.digits(points)} | references() | missed() | about()


def of_curves(rows, scenes):
    """Return a small plot of error against time for each scene, the contenders named once."""
    from matplotlib.ticker import LogLocator

    lines = math.ceil(len(scenes) / COLUMNS)
    figure, grid = drawing.sheet(drawing.PAGE, 1.25 * lines + 0.55, nrows=lines, ncols=COLUMNS, squeeze=False)
    kinds = {}
    for axes, scene in zip(grid.flat, scenes):
        for contender, (times, errors, _) in plots.curves(rows, scene).items():
            colour, marker, width = plots.style(contender)
            (line,) = axes.plot([t["median"] for t in times], [e["median"] for e in errors], color=colour,
                                marker=marker, linewidth=0.6 * width, markersize=2, zorder=width)  # fmt: skip
            kinds.setdefault(kind(contender), line)
        axes.set(xscale="log", yscale="log", title=plain(scene))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(numticks=DECADES))
        axes.minorticks_off()
        axes.grid(True, color=plots.FAINT, linewidth=0.3)
    for axes in list(grid.flat)[len(scenes) :]:
        axes.remove()
    figure.supxlabel("CPU seconds", fontsize=drawing.SIZE)
    figure.supylabel("relative mean squared error", fontsize=drawing.SIZE)
    figure.legend(kinds.values(), kinds, loc="outside upper center", ncols=len(kinds), columnspacing=1.2,
                  handlelength=1.5)  # fmt: skip
    return figure


def kind(contender):
    """Return what contenders of different scenes have in common: the best sampler is not everywhere the same."""
    variant, _, sampler = contender.partition(" ")
    return contender if not sampler else f"Mitsuba {variant}, {sampler if sampler == 'independent' else 'best sampler'}"


def plain(scene):
    """Return a scene's name without underscores."""
    return scene.replace("_", " ")


def of_speedups(equal):
    """Return bars of how many times as fast ours is at equal error, and marks of how much of that is mere speed."""
    ordered = sorted(equal, key=lambda row: results.median(row[BEST]))
    figure, axes = drawing.sheet(drawing.COLUMN, 2.9)
    for place, row in enumerate(ordered):
        for offset, key, variant in ((0.2, BEST, "llvm"), (-0.2, SCALAR, "scalar")):
            if row[key] is None:
                continue
            ratio, (colour, *_) = row[key], plots.STYLES[variant, False]
            spread = [[ratio["median"] - ratio["min"]], [ratio["max"] - ratio["median"]]]
            axes.barh(place + offset, ratio["median"] - 1, left=1, height=0.36, color=colour, xerr=spread,
                      error_kw={"elinewidth": 0.7, "ecolor": plots.INK})  # fmt: skip
        axes.plot(rate(row["scene"]), place + 0.2, marker="D", color=plots.OURS[0], markersize=3.5, zorder=4)
    axes.axvline(1, color=plots.INK, linewidth=0.6)
    axes.set(xscale="log", xlabel="times as fast as Mitsuba at equal error", yticks=range(len(ordered)),
             yticklabels=[plain(row["scene"]) for row in ordered], ylim=(-0.6, len(ordered) - 0.4),
             xticks=(1, 2, 5, 10, 20, 50, 100), xticklabels=("1", "2", "5", "10", "20", "50", "100"))  # fmt: skip
    axes.minorticks_off()
    axes.grid(True, axis="x", color=plots.FAINT, linewidth=0.3)
    axes.set_axisbelow(True)
    axes.tick_params(axis="y", length=0)
    marks = [axes.bar(1, 0, color=plots.STYLES[variant, False][0]) for variant in ("llvm", "scalar")]
    marks += [axes.plot([], [], marker="D", color=plots.OURS[0], linestyle="", markersize=3.5)[0]]  # fmt: skip
    figure.legend(marks, ("llvm_ad_rgb", "scalar_rgb", "samples per second alone"), loc="outside upper center", ncols=3,
                  columnspacing=1, handlelength=1)  # fmt: skip
    return figure


def _at_equal_samples(scene, contender):
    """Return the time and the error of a contender with as many samples as equal error is taken at."""
    row = results.row("error", plots.CURVES, scene=scene, contender=contender, **{plots.SAMPLES: EQUAL_SAMPLES})
    return results.median(row[plots.TIME]), results.median(row[plots.ERROR])


def rate(scene):
    """Return how many times the samples per second of Mitsuba's plain sampler ours renders."""
    return _at_equal_samples(scene, THEIRS)[0] / _at_equal_samples(scene, OURS)[0]


def gain(scene):
    """Return how many times our error that sampler has with as many samples."""
    return _at_equal_samples(scene, THEIRS)[1] / _at_equal_samples(scene, OURS)[1]


def of_table(equal):
    """Return the table of speed-ups: where they come from, and beside which of Mitsuba's samplers."""
    lines = [[plain(row["scene"]), results.digits(rate(row["scene"])), results.digits(gain(row["scene"])),
              *(results.digits(results.median(row[key])) for key in (PLAIN, BEST, LEAST))]
             for row in equal]  # fmt: skip
    return {"table": lines}


def extremes(equal):
    """Return the least and the most of each column of the table, over all scenes, and over all but meshes."""
    others = [row for row in equal if row["scene"] not in MESHES]
    columns = {"rate": lambda row: rate(row["scene"]), "gain": lambda row: gain(row["scene"]),
               "best": lambda row: results.median(row[BEST]),
               "scalar": lambda row: results.median(row[SCALAR]) if row[SCALAR] else math.nan}  # fmt: skip
    told = {}
    for name, column in columns.items():
        for rows, suffix in ((equal, ""), (others, "_others")):
            found = sorted(value for value in map(column, rows) if not math.isnan(value))
            least, most = results.digits(found[0]), results.digits(found[-1])
            told |= {f"{name}_least{suffix}": least, f"{name}_most{suffix}": most}
        if name != "scalar":
            told |= {f"{name}_{row['scene']}": results.digits(column(row)) for row in equal}
    return told


def beside_best(row):
    """Return the error of Mitsuba's best sampler over ours, with as many samples."""
    best = "llvm " + row["Mitsuba's best other sampler"]
    return _at_equal_samples(row["scene"], best)[1] / _at_equal_samples(row["scene"], OURS)[1]


def references():
    """Return how far the references of both renderers agree."""
    rows = results.table("error", "references")
    return {"apart": results.digits(max(abs(results.median(row["in standard errors"])) for row in rows)),
            "samples": f"{max(row['samples, ours'] for row in rows):,}",
            "scenes": results.words(len(rows)), "margin": results.digits(MARGIN), "equal": str(EQUAL_SAMPLES),
            "size": f"{WIDTH} × {HEIGHT}"}  # fmt: skip


def missed():
    """Return what was asked of path tracing and not reached, a row each: figure, reached, asked."""
    judged = (Figure(**figure) for figure in results.results()["benchmarks"]["paths"]["figures"])
    return {"missed": [[figure.name.replace(" x ", " × "), results.digits(figure.reached), results.digits(figure.least)]
                       for figure in judged if figure.holds(figure.least) is False]}  # fmt: skip


def about():
    """Return how busy the machine was when the benchmark began."""
    measured = results.results()["benchmarks"]["error"].get("measured") or results.results()["machine"]
    quiet = "quiet" if measured["load_before"] <= QUIET_LOAD else "not quite quiet"
    return {"load": results.digits(measured["load_before"]), "quiet": quiet}
