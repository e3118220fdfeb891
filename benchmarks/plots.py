"""Plots of speed against error, made from results.json and from nothing else.

`python -m benchmarks.plots` writes to docs/plots: a plot of error against CPU time for each scene (`error_SCENE.svg`),
all of them small on one page (`errors.png`), and the speed-up at equal error as bars (`speedup.svg`). The same results
give the same bytes. Each file tells the digest of the rows it was made from, so that a test finds plots out of date.

Colours are those of Okabe and Ito, which people with any colour vision tell apart; markers differ as well.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import sys

from benchmarks.measure import ROOT
from benchmarks.table import RESULTS
from benchmarks.targets import number

FOLDER = ROOT / "docs" / "plots"
BENCHMARK, CURVES, SPEEDUPS = "error", "curves", "at equal error"
TIME, CLOCK, ERROR, SAMPLES = "CPU time (s)", "wall time (s)", "relative MSE", "samples a pixel"
GPU = "cuda"  # in the names of contenders whose time is that of the clock
INK, FAINT = "#222222", "#cccccc"
OURS = ("#d55e00", "o", 2.0)  # colour, marker, width of the line
STYLES = {("llvm", True): ("#56b4e9", "s", 1.2), ("llvm", False): ("#0072b2", "D", 1.2),
          ("scalar", True): ("#a0a0a0", "^", 1.2), ("scalar", False): ("#6b6b6b", "v", 1.2),
          ("cuda", True): ("#7fd1b9", "<", 1.2), ("cuda", False): ("#009e73", ">", 1.2)}  # fmt: skip
BARS = {"llvm best, x Mitsuba": ("llvm, best sampler", STYLES["llvm", False][0]),
        "scalar best, x Mitsuba": ("scalar, best sampler", STYLES["scalar", False][0]),
        "cuda best, x Mitsuba": ("CUDA, ours too", STYLES["cuda", False][0])}  # fmt: skip
COLUMNS = 3  # of small plots on a page
DENSITY, COLOURS = 130, 96  # of PNG files: pixels an inch, entries of the palette
LINE = 0.075  # height of a label beside a plot, as a share of the plot's
SETTINGS = {"svg.hashsalt": "plots", "svg.fonttype": "path", "font.family": "DejaVu Sans", "font.size": 9,
            "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": INK, "axes.labelcolor": INK,
            "text.color": INK, "xtick.color": INK, "ytick.color": INK, "axes.titlelocation": "left",
            "axes.titlesize": 10, "axes.titleweight": "bold", "lines.markersize": 4, "figure.dpi": 100}  # fmt: skip


def write(results, folder=FOLDER):
    """Write all plots and return their paths; those of scenes that are no longer measured are removed."""
    import matplotlib

    tables = results["benchmarks"][BENCHMARK]["tables"]
    scenes = list(dict.fromkeys(row["scene"] for row in tables[CURVES]))
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("error_*.svg"):
        old.unlink()
    with matplotlib.rc_context(SETTINGS):
        made = {folder / f"error_{scene}.svg": _of_scene(scene, tables[CURVES]) for scene in scenes}
        made[folder / "errors.png"] = _of_all(scenes, tables[CURVES])  # as SVG it would be three times as large
        made[folder / "speedup.svg"] = _of_speedups(tables[SPEEDUPS])
        for path, figure in made.items():
            _save(figure, path, f"benchmarks/results.json, rows {digest(results)}")
    return list(made)


def _save(figure, path, source):
    """Write a figure without a date; PNG files get a palette, with which they are a quarter as large."""
    if path.suffix == ".svg":
        return figure.savefig(path, metadata={"Date": None, "Creator": None, "Description": source})
    from PIL import Image, PngImagePlugin

    figure.savefig(pixels := io.BytesIO(), format="png", dpi=DENSITY)
    told = PngImagePlugin.PngInfo()
    told.add_text("Description", source)
    few = Image.open(pixels).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    few.save(path, pnginfo=told, optimize=True)


def digest(results):
    """Return a digest of all that the plots are made of."""
    tables = results["benchmarks"][BENCHMARK]["tables"]
    rows = json.dumps([tables[CURVES], tables[SPEEDUPS]], sort_keys=True)
    return hashlib.sha256(rows.encode()).hexdigest()[:16]


def curves(rows, scene):
    """Return {contender: (times, errors, samples)} of a scene, times and errors as spreads, samples rising."""
    found = {}
    for row in rows:
        time = row[CLOCK if GPU in row["contender"] else TIME]
        if row["scene"] == scene and time and row[ERROR]:
            found.setdefault(row["contender"], []).append((row[SAMPLES], _spread(time), _spread(row[ERROR])))
    ordered = {name: sorted(points, key=lambda point: point[0]) for name, points in found.items()}
    return {name: ([p[1] for p in points], [p[2] for p in points], [p[0] for p in points])
            for name, points in ordered.items()}  # fmt: skip


def style(contender):
    """Return (colour, marker, width) of a contender's line: by whose it is, and whether its sampler is plain."""
    if contender.startswith("ours"):
        return OURS if contender == "ours" else ("#cc79a7", "p", 2.0)
    variant, _, sampler = contender.partition(" ")
    return STYLES[variant, sampler == "independent"]


def placed(wanted, least):
    """Return heights near the wanted ones, which rise, and at least `least` apart: those that meet share the way."""
    groups = [[height] for height in wanted]

    def bottom(group):
        return sum(group) / len(group) - least * (len(group) - 1) / 2

    k = 1
    while k < len(groups):
        if bottom(groups[k]) < bottom(groups[k - 1]) + least * len(groups[k - 1]):
            groups[k - 1 : k + 1] = [groups[k - 1] + groups[k]]
            k = max(k - 1, 1)
        else:
            k += 1
    return [bottom(group) + least * place for group in groups for place in range(len(group))]


def _spread(value):
    """Return a number or a spread as a spread."""
    return value if isinstance(value, dict) else {"median": value, "min": value, "max": value}


def _figure(width, height, **grid):
    """Return a figure without a window, and its axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(**grid)


def _of_scene(scene, rows):
    """Return the plot of one scene, its lines named beside it."""
    figure, axes = _figure(6.4, 4.0)
    drawn = _draw(axes, scene, rows)
    axes.set_xlabel(_seconds(drawn))
    axes.set_ylabel("relative mean squared error")
    _name(axes, drawn)
    return figure


def _of_all(scenes, rows):
    """Return a page of small plots, the contenders named once."""
    lines = math.ceil(len(scenes) / COLUMNS)
    figure, grid = _figure(9.0, 2.3 * lines + 0.5, nrows=lines, ncols=COLUMNS, squeeze=False)
    kinds = {}
    for axes, scene in zip(grid.flat, scenes):
        for name, (line, _) in _draw(axes, scene, rows, small=True).items():
            kinds.setdefault(_kind(name), line)
    for axes in list(grid.flat)[len(scenes) :]:
        axes.remove()
    figure.supxlabel(_seconds(kinds), fontsize=9)
    figure.supylabel("relative mean squared error", fontsize=9)
    figure.legend(kinds.values(), kinds, loc="outside upper center", ncols=COLUMNS, frameon=False)
    return figure


def _seconds(contenders):
    """Return the name of the axis of time."""
    return "seconds (CPU time; with CUDA by the clock)" if any(GPU in name for name in contenders) else "CPU seconds"


def _kind(contender):
    """Return what contenders of different scenes have in common: the best sampler is not everywhere the same."""
    if contender.startswith("ours"):
        return contender
    variant, _, sampler = contender.partition(" ")
    return f"Mitsuba {variant}, {'independent' if sampler == 'independent' else 'best sampler'}"


def _draw(axes, scene, rows, small=False):
    """Draw a scene's lines and return {contender: (line, its last point)}."""
    drawn = {}
    for name, (times, errors, samples) in curves(rows, scene).items():
        colour, marker, width = style(name)
        x, y = [t["median"] for t in times], [e["median"] for e in errors]
        order = 3 if name.startswith("ours") else 2
        (line,) = axes.plot(x, y, color=colour, marker=marker, linewidth=width * (0.8 if small else 1),
                            markersize=2.5 if small else 4, zorder=order)  # fmt: skip
        axes.plot(*_crosses(times, errors), color=colour, linewidth=0.7, zorder=order)
        drawn[name] = line, (x[-1], y[-1])
        if name == "ours" and not small:
            for k in (0, -1):
                told = f"{samples[k]} sample" + "s" * (samples[k] > 1)
                _tell(axes, told, (x[k], y[k]), (-3, -9) if k == 0 else (-6, -4), colour, "right")
    axes.set(xscale="log", yscale="log", title=scene.replace("_", " "))
    axes.grid(True, which="major", color=FAINT, linewidth=0.4)
    axes.margins(x=0.05 if small else 0.14, y=0.08)
    axes.tick_params(which="minor", length=0 if small else 2)
    if small:
        axes.minorticks_off()
    return drawn


def _crosses(times, errors):
    """Return the spreads of points as one broken line: one path in the file instead of two a point."""
    x, y = [], []
    for time, error in zip(times, errors):
        x += [time["min"], time["max"], math.nan, time["median"], time["median"], math.nan]
        y += [error["median"], error["median"], math.nan, error["min"], error["max"], math.nan]
    return x, y


def _tell(axes, text, place, offset, colour, side):
    """Write a few small words beside a point, `offset` in points."""
    axes.annotate(text, place, xytext=offset, textcoords="offset points", ha=side, va="center", color=colour,
                  fontsize=7)  # fmt: skip


def _bars(spreads):
    """Return the lengths of error bars, below and above, as matplotlib takes them."""
    return [[s["median"] - s["min"] for s in spreads], [s["max"] - s["median"] for s in spreads]]


def _name(axes, drawn):
    """Write the contenders' names to the right of a plot, each at the height at which its line ends."""
    axes.figure.draw_without_rendering()  # limits are known from here on
    to_axes = axes.transData + axes.transAxes.inverted()
    ends = {name: to_axes.transform(end) for name, (_, end) in drawn.items()}
    names = sorted(ends, key=lambda name: ends[name][1])
    for name, height in zip(names, placed([ends[name][1] for name in names], LINE)):
        colour = style(name)[0]
        told = name if name.startswith("ours") else f"Mitsuba {name}"
        axes.plot([ends[name][0], 1.02], [ends[name][1], height], transform=axes.transAxes, color=colour,
                  linewidth=0.5, linestyle=":", clip_on=False)  # fmt: skip
        axes.text(1.03, height, told, transform=axes.transAxes, color=colour, va="center",
                  fontweight="bold" if name == "ours" else "normal")  # fmt: skip


def _of_speedups(rows):
    """Return bars of how much less time ours needs for the same error, the greatest on top."""
    first = next(iter(BARS))
    rows = sorted(rows, key=lambda row: _spread(row[first] or 0)["median"])
    bars = {key: look for key, look in BARS.items() if any(row.get(key) for row in rows)}
    thick = 0.76 / max(len(bars), 1)
    figure, axes = _figure(6.4, 0.21 * max(len(bars), 2) * len(rows) + 1.1)
    for k, row in enumerate(rows):
        for place, (key, (_, colour)) in enumerate(bars.items()):
            if row.get(key) is not None:
                _bar(axes, k + thick * ((len(bars) - 1) / 2 - place), _spread(row[key]), colour, 0.9 * thick)
    axes.axvline(1, color=INK, linewidth=0.8)
    axes.set(xscale="log", xlabel="times as fast as Mitsuba at equal error (CPU time, logarithmic)",
             yticks=range(len(rows)), yticklabels=[row["scene"].replace("_", " ") for row in rows])  # fmt: skip
    ends = [_spread(row[key])[end] for row in rows for key in bars if row.get(key) for end in ("min", "max")]
    axes.set_xlim(min([0.9, *(end / 1.5 for end in ends if end < 1)]), 1.5 * max([1.0, *ends]))
    axes.tick_params(axis="y", length=0)
    axes.xaxis.set_major_formatter(lambda x, _: number(int(x) if x >= 1 else x))
    axes.spines["left"].set_visible(False)
    names = [axes.bar(1, 0, color=colour) for _, colour in bars.values()]
    figure.legend(names, [f"beside Mitsuba {told}" for told, _ in bars.values()], loc="outside upper center",
                  ncols=2, frameon=False)  # fmt: skip
    return figure


def _bar(axes, place, ratio, colour, thick):
    """Draw one bar from 1, with its spread and its number."""
    middle = ratio["median"]
    axes.barh(place, middle - 1, left=1, height=thick, color=colour, xerr=_bars([ratio]),
              error_kw={"elinewidth": 0.8, "ecolor": INK})  # fmt: skip
    end, side = (ratio["max"], 1) if middle >= 1 else (ratio["min"], -1)
    _tell(axes, number(middle), (end, place), (4 * side, 0), INK, "left" if side > 0 else "right")


if __name__ == "__main__":
    print(*write(json.loads(RESULTS.read_text())), sep="\n")
    sys.exit(0)
