"""Plots for print: the size of a column or of a page, the colours of docs/plots, no date in the file."""

from __future__ import annotations

from contextlib import contextmanager

from benchmarks import plots

COLUMN, PAGE = 3.33, 6.93  # inches across
SIZE = 7.5  # of letters, points
PLAIN = {"font.size": SIZE, "axes.titlesize": SIZE, "axes.titleweight": "normal", "legend.fontsize": 6.5,
         "legend.frameon": False, "axes.labelsize": SIZE, "xtick.labelsize": 6.5, "ytick.labelsize": 6.5,
         "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6, "xtick.major.size": 2.5,
         "ytick.major.size": 2.5, "lines.linewidth": 1.2, "lines.markersize": 3}  # fmt: skip


@contextmanager
def in_print():
    """Draw in the type and the lines of the report."""
    import matplotlib

    with matplotlib.rc_context(plots.SETTINGS | PLAIN):
        yield


def sheet(width, height, **grid):
    """Return a figure of so many inches without a window, and its axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(**grid)


def save(figure, path):
    """Write a figure as SVG; the same figure gives the same bytes."""
    figure.savefig(path, metadata={"Date": None, "Creator": None})
