"""`python -m tools.accuracy`: the plot of docs/stability.md, from its tables and nothing else.

A dot is the worst error in one hard case, over the error that the roundings of a good formula explain. `python -m
tests.stability --write` measures the tables anew; the plot (docs/plots/accuracy.svg) tells the digest of the rows it
was made from, so that a test finds it out of date.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from benchmarks.plots import FAINT, FOLDER, INK, OURS, SETTINGS, STYLES
from tools.hard_cases import PAGE, HardCase, read

PLOT = FOLDER / "accuracy.svg"
SIDES = {"naive": ("the textbook's formula", "#8a8a8a", "v"), "mitsuba": ("Mitsuba", STYLES["llvm", False][0], "D"),
         "ours": ("ours", OURS[0], "o")}  # fmt: skip
SHIFT = {"naive": -0.24, "ours": 0.0, "mitsuba": 0.24}  # of the dots of one side, in rows
NONE, LEAST, MOST, WRONG = 2e-4, 1e-3, 1e8, 1e9  # places on the axis: no error, its ends, and infinite errors


def digest(cases: list[HardCase]) -> str:
    """Return a digest of what is drawn."""
    return hashlib.sha256(repr(cases).encode()).hexdigest()[:16]


def position(ratio: float) -> float:
    """Return where on the axis a ratio is drawn."""
    return WRONG if ratio > MOST else NONE if ratio < LEAST else ratio


def figure(cases: list[HardCase]):
    """Return the plot: a line for each section, a dot for each case and side."""
    from matplotlib.figure import Figure

    sections = list(dict.fromkeys(case.section for case in cases))
    drawing = Figure(figsize=(8.2, 0.235 * len(sections) + 1.2), layout="constrained")
    axes = drawing.subplots()
    for side, (label, colour, marker) in SIDES.items():
        there = [case for case in cases if getattr(case, side) is not None]
        axes.plot([position(case.strain(side)) for case in there],
                  [sections.index(case.section) + SHIFT[side] for case in there], linestyle="none", label=label,
                  marker=marker, markersize=4.5, color=colour, alpha=0.8, markeredgewidth=0)  # fmt: skip
    axes.axvspan(NONE / 3, 1, color="#fdf1e6", zorder=0)
    axes.axvline(1, color=INK, linewidth=0.8)
    ticks = [NONE, *(10.0**power for power in range(-2, 7, 2)), WRONG]
    axes.set(xscale="log", xlim=(NONE / 3, WRONG * 3), ylim=(len(sections) - 0.4, -0.6), yticks=range(len(sections)),
             yticklabels=[_short(section) for section in sections], xticks=ticks,
             xlabel="worst error, in units of what rounding explains")  # fmt: skip
    powers = [f"$10^{{{power}}}$" if power else "1" for power in range(-2, 7, 2)]
    axes.set_xticklabels(["none", *powers, "infinite,\nor wrong"])
    axes.minorticks_off()
    axes.tick_params(axis="y", length=0)
    axes.grid(True, color=FAINT, linewidth=0.4)
    axes.set_axisbelow(True)
    drawing.legend(loc="outside upper center", ncols=len(SIDES), frameon=False)
    return drawing


def _short(section):
    """Return the first words of a section's title."""
    return section.partition(": ")[0].partition(", ")[0]


def write(path: Path = PLOT) -> Path:
    """Write the plot and return its path; the same tables give the same bytes."""
    import matplotlib

    cases = read(PAGE.read_text(encoding="utf-8"))
    with matplotlib.rc_context(SETTINGS):
        told = f"docs/stability.md, rows {digest(cases)}"
        figure(cases).savefig(path, metadata={"Date": None, "Creator": None, "Description": told})
    return path


if __name__ == "__main__":
    print(write())
