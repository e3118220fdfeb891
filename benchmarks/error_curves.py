"""What follows from times and errors at rising numbers of samples: which of them count, and speeds at equal error."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmarks.measure import spread

MARGIN = 10.0  # times the reference's own error that a measured one must have: else it tells of the reference
EQUAL_SAMPLES = 64  # a pixel, of the other side, whose error both are to reach


@dataclass(frozen=True)
class Run:
    """One picture: what was asked for, and what came of it."""

    level: int  # samples a pixel that were asked for
    samples: int  # that were taken
    repeat: int
    cpu: float  # seconds, all threads
    wall: float
    mse: float
    relative_mse: float
    ssim: float
    flip: float | None  # None where its package is not there
    on_gpu: bool = False

    @property
    def seconds(self):
        """The time that is judged: of the CPU, which other work on the machine changes least; on a GPU by the clock."""
        return self.wall if self.on_gpu else self.cpu


def told_apart(runs, reference):
    """Return the runs of those levels whose errors are MARGIN times the reference's `error` and `mse` or more."""
    levels = {}
    for run in runs:
        levels.setdefault(run.level, []).append(run)
    kept = {
        level for level, group in levels.items()
        if spread([run.relative_mse for run in group])["median"] >= MARGIN * reference["error"]
        and spread([run.mse for run in group])["median"] >= MARGIN * reference["mse"]
    }  # fmt: skip
    return [run for run in runs if run.level in kept]


def curve(runs, repeat):
    """Return [(seconds, relative MSE)] of one repeat by rising level, without points no better than an earlier one.

    So errors fall along it, and there is one time for each.
    """
    points = []
    for run in sorted((run for run in runs if run.repeat == repeat), key=lambda run: run.level):
        if not points or run.relative_mse < points[-1][1]:
            points.append((run.seconds, run.relative_mse))
    return points


def time_for(points, error):
    """Return the seconds that a curve takes to an error: a straight line between points on logarithmic scales.

    A larger error than that of the first point takes the time of the first point: there is no picture of fewer samples.
    Raises ValueError for an error that the curve does not reach.
    """
    if error >= points[0][1]:
        return points[0][0]
    for (t0, e0), (t1, e1) in zip(points, points[1:]):
        if e1 <= error:
            share = math.log(error / e0) / math.log(e1 / e0)
            return t0 * (t1 / t0) ** share
    raise ValueError(f"error {error} is not reached")


def equal_error(ours, theirs, samples=EQUAL_SAMPLES):
    """Return (ratio, error): how many times our time the other side takes to the same relative MSE, and to which.

    That is its error with so many samples a pixel, or with the most that it has where those are fewer; where ours does
    not come so far, the least error of ours. Both are runs; the ratio is a spread over the repeats.
    """
    ratios, errors = [], []
    for repeat in sorted({run.repeat for run in ours} & {run.repeat for run in theirs}):
        level = max((run.level for run in theirs if run.level <= samples), default=min(run.level for run in theirs))
        reached = next(run.relative_mse for run in theirs if run.level == level and run.repeat == repeat)
        mine, other = curve(ours, repeat), curve(theirs, repeat)
        error = max(reached, mine[-1][1], other[-1][1])
        ratios.append(time_for(other, error) / time_for(mine, error))
        errors.append(error)
    return spread(ratios), spread(errors)["median"]
