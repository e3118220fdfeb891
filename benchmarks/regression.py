"""Has a ratio against Mitsuba fallen? `python -m benchmarks --check` compares what it measures with results.json.

Only numbers of columns `..., x Mitsuba` are compared, never times: the two renderers took turns on the same machine in
either run, so what differs between machines, or ran beside, mostly cancels. It does not cancel altogether (other
vector units, caches, numbers of cores), so a fall on another kind of processor than that of results.json says little;
the report names both.

Like is compared with like: rows of the same scene or mesh and rays, measured at the same size of pictures and number of
samples. Those of `error` do not depend on the effort, as long as the error was reached with the same number of samples.

Tolerance: a ratio may be worse by LEAST, twice what runs of about the same code on one quiet machine were apart (up to
8 %); by TIMES the spreads of both runs, added as independent errors are, where that is more; and by no more than MOST,
so that half the speed is always told. Where no spread was taken, by NO_SPREAD.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmarks import table
from benchmarks.targets import number

RATIO = "x Mitsuba"  # ends the names of columns of ratios; most say how many times as fast ours is
LOWER_BETTER = ("time",)  # begin the names of those that say how many times as long ours takes
IDENTITY = ("scene", "mesh", "triangles", "rays")  # columns that say what a row is about
SIZE = ("width", "height", "samples")  # of an effort
LEAST, TIMES, MOST, NO_SPREAD = 0.15, 2.0, 0.5, 0.3
CURVES = "curves"  # the table of `error` with the numbers of samples that were rendered
SAME_SAMPLES = 1.3  # numbers of samples up to so many times apart are the same: some samplers round them up
AT_MOST = 64  # samples a pixel of Mitsuba's picture whose error is compared at
HELD, FELL, ROSE = "held", "fell", "rose"
NOTHING, FALLEN, FINE = 2, 1, 0  # exit statuses


@dataclass(frozen=True)
class Comparison:
    """A ratio that was measured twice; both as spreads, `measured` None where it could not be reached any more."""

    name: str
    committed: dict
    measured: dict | None
    lower_better: bool = False

    @property
    def tolerance(self):
        """The share by which the ratio may be worse."""
        both = (self.committed, self.measured or self.committed)
        if any(one["min"] == one["max"] for one in both):
            return NO_SPREAD
        return min(max(LEAST, TIMES * math.hypot(*map(_relative_spread, both))), MOST)

    @property
    def change(self):
        """How many times as good the ratio is as it was."""
        if self.measured is None:
            return 0.0
        factor = self.measured["median"] / self.committed["median"]
        return 1 / factor if self.lower_better else factor

    @property
    def verdict(self):
        """HELD, FELL or ROSE. A NaN has not held."""
        if not self.change >= 1 - self.tolerance:
            return FELL
        return ROSE if self.change > 1 / (1 - self.tolerance) else HELD


def check(measured, committed):
    """Print how each ratio compares and return the exit status: FALLEN if one fell, NOTHING if none was compared."""
    comparisons, left_out = compare(measured, committed)
    for where, results in (("measured", measured), ("committed", committed)):
        machine = results["machine"]
        print(f"{where}: {machine['cpu']}, {machine['cores']} cores, commit {machine['commit']}")
    print(table.table([_row(one) for one in comparisons]))
    print(*left_out, sep="\n")
    fallen = [one.name for one in comparisons if one.verdict == FELL]
    if not comparisons:
        print("nothing was compared: the results have no ratio in common")
        return NOTHING
    print(f"{len(comparisons)} ratios compared, {len(fallen)} fell" + "".join(f"\n  {name}" for name in fallen))
    return FALLEN if fallen else FINE


def compare(measured, committed):
    """Return the Comparisons of two results, and sentences about what was left out of them."""
    comparisons, left_out = [], []
    for name, found in measured["benchmarks"].items():
        old = committed["benchmarks"].get(name)
        if old is None:
            left_out.append(f"{name}: not measured before")
            continue
        if CURVES not in found["tables"] and any(measured["effort"][k] != committed["effort"][k] for k in SIZE):
            left_out.append(f"{name}: measured at another size than the committed results")
            continue
        before, after = ratios(old), ratios(found)
        for key in after:
            told, reason = f"{name}, {', '.join(map(str, key[1:]))}", _unlike(key, found, old)
            if before.get(key) is None:
                left_out += [f"{told}: not measured before"] if after[key] else []
            elif reason:
                left_out.append(f"{told}: {reason}")
            else:
                lower = key[-1].startswith(LOWER_BETTER)
                comparisons.append(Comparison(told, before[key], after[key], lower))
    return comparisons, left_out


def ratios(found):
    """Return {(table, what the row is about ..., column): spread or None} of the ratios that a benchmark found."""
    return {
        (title, *(row[name] for name in IDENTITY if name in row), column): _spread(value)
        for title, rows in found["tables"].items() for row in rows for column, value in row.items()
        if column == RATIO or column.endswith(f", {RATIO}")
    }  # fmt: skip


def _unlike(key, found, old):
    """Return why two ratios of the same name are not of the same thing; None if they are."""
    if CURVES not in found["tables"]:
        return None
    samples = [_samples(one["tables"][CURVES], *key[1:]) for one in (found, old)]
    if None in samples or max(samples) <= SAME_SAMPLES * min(samples):
        return None
    return f"at the error of {samples[0]} samples a pixel, and of {samples[1]} before"


def _samples(curves, scene, column):
    """Return the samples a pixel of the picture of Mitsuba at whose error a ratio was taken; None if there is none."""
    variant, which = column.split(",")[0].split(" ", 1)
    taken = []
    for row in curves:
        its_variant, _, sampler = row["contender"].partition(" ")
        if (row["scene"], its_variant, sampler == "independent") == (scene, variant, which == "independent"):
            taken.append(row["samples a pixel"])
    return max((samples for samples in taken if samples <= AT_MOST * SAME_SAMPLES), default=min(taken, default=None))


def _spread(value):
    """Return a number as a spread without width."""
    return value if value is None or isinstance(value, dict) else {"median": value, "min": value, "max": value}


def _relative_spread(spread):
    """Return how far the farther end is from the median, as a share."""
    return max(spread["max"] - spread["median"], spread["median"] - spread["min"]) / spread["median"]


def _row(one):
    """Return the row of a comparison in the report."""
    return {"ratio": one.name, "committed": one.committed, "measured": one.measured,
            "times as good": number(one.change), "may be worse by": f"{100 * one.tolerance:.0f} %",
            "verdict": one.verdict}  # fmt: skip
