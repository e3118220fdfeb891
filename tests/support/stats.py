"""Gates for noisy pictures: whether two sets of independently rendered batches can have the same expectation.

Each side is K >= LEAST_BATCHES pictures made with different seeds. Four statistics see different mistakes:

- `pixel`: the most unlikely pixel (a wrong edge, a missing highlight),
- `block`: the most unlikely square of BLOCK x BLOCK pixels (a local error),
- `chi2`: the sum of squares over the squares (many small errors),
- `scale`: a weighted mean of the whole picture (a common factor).

The first two are Welch's t-tests with Sidak's correction for the number of pixels. The gate refuses where the joint
p-value is below P_LEAST, or where the statistics could not have seen a common error of BOUND: more samples are due.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from tests.support.compare import Mismatch

LEAST_BATCHES = 16  # fewer have a heavier tail of false alarms
BLOCK = 8  # pixels; found best of 1 to 32 for the power of `chi2`
P_LEAST = 1e-4  # false alarms in one of 10,000 comparisons
BOUND = 0.005  # relative: a common error that must be excluded with 99 %
RELATIVE_FLOOR, ABSOLUTE_FLOOR = 1e-4, 1e-6  # rounding, which counts beside the noise: else noise-free pixels decide
FREE = 1e6  # degrees of freedom where rounding is all that there is


@dataclass(frozen=True)
class Verdict:
    """What a comparison says."""

    pixel: float  # p-values
    block: float
    chi2: float
    scale: float
    error: float  # relative difference of the weighted means
    bound: float  # of that difference, with 99 %

    @property
    def p(self):
        """The joint p-value: Bonferroni's correction of the least."""
        return min(1.0, 4 * min(self.pixel, self.block, self.chi2, self.scale))

    @property
    def coarse_p(self):
        """The same without the pixels: where bright samples are so rare that most pixels of a side have none.

        Such pixels look free of noise, and the t-test takes what they lack for certain.
        """
        return min(1.0, 3 * min(self.block, self.chi2, self.scale))

    @property
    def refused(self):
        """Whether the two sides differ."""
        return self.p < P_LEAST


def demand_equal(ours, theirs, bound=BOUND):
    """Return the Verdict on two (K, H, W, C) sets of batches; raises Mismatch unless they pass the gate."""
    verdict = compare(ours, theirs)
    if verdict.refused:
        raise Mismatch(f"the pictures differ: {verdict}, p = {verdict.p:.2g}")
    if verdict.bound > bound:
        raise Mismatch(f"too few samples to tell: {verdict}")
    return verdict


def compare(one, other):
    """Return the Verdict on two (K, H, W, C) sets of batches."""
    one, other = _batches(one), _batches(other)
    channels = one.shape[-1]
    pixel = _sidak(_welch(one, other).p)
    one, other = _squares(one), _squares(other)
    test = _welch(one, other)
    score = stats.norm.isf(np.clip(test.p, 1e-300, 1) / 2) ** 2
    by_channel = [stats.chi2.sf(score[..., c].sum(), score[..., c].size) for c in range(channels)]
    scale, error, bound = _scale(one, other, test)
    return Verdict(pixel, _sidak(test.p), min(1.0, channels * min(by_channel)), scale, error, bound)


def _batches(pictures):
    """Return pictures as float64; they must be enough, and finite."""
    pictures = np.asarray(pictures, np.float64)
    assert pictures.ndim == 4 and len(pictures) >= LEAST_BATCHES, "(K, H, W, C) with K batches"
    assert np.isfinite(pictures).all(), "not finite"
    return pictures


@dataclass(frozen=True)
class _Test:
    """A t-test of each pixel and channel."""

    p: np.ndarray
    freedom: np.ndarray
    difference: np.ndarray
    error: np.ndarray  # standard error of the difference, with the floor for rounding


def _welch(one, other):
    """Return Welch's t-test along the first axis."""
    mean, count = [a.mean(0) for a in (one, other)], [len(a) for a in (one, other)]
    square = [a.var(0, ddof=1) / len(a) for a in (one, other)]
    floor = (RELATIVE_FLOOR * np.maximum(*map(np.abs, mean)) + ABSOLUTE_FLOOR) ** 2
    both = square[0] + square[1]
    parts = sum(s**2 / (k - 1) for s, k in zip(square, count))
    freedom = np.where(both > floor, np.maximum(both**2 / np.maximum(parts, 1e-300), 1), FREE)
    difference, error = mean[0] - mean[1], np.sqrt(both + floor)
    return _Test(2 * stats.t.sf(np.abs(difference) / error, freedom), freedom, difference, error)


def _sidak(p):
    """Return the probability that the least of so many independent p-values is as small as it is."""
    return float(-np.expm1(p.size * np.log1p(-min(p.min(), 1 - 1e-16))))


def _squares(pictures):
    """Return the means of BLOCK x BLOCK pixels; what is left over at the edges is dropped."""
    count, height, width, channels = pictures.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = pictures[:, :rows * BLOCK, :columns * BLOCK]
    return cut.reshape(count, rows, BLOCK, columns, BLOCK, channels).mean((2, 4))


def _scale(one, other, test):
    """Return p-value, relative error and its bound for a common factor, weighted nearly optimally."""
    mean = (one.mean(0) + other.mean(0)) / 2
    relative = test.error / np.maximum(np.abs(mean), 1e-12)
    noisy = (relative > 3 * RELATIVE_FLOOR) & (mean > 0)
    typical = np.median(relative[noisy]) if noisy.any() else RELATIVE_FLOOR
    # The median keeps a few squares, whose noise was underestimated, from deciding alone.
    weight = np.where(noisy if noisy.any() else mean > 0, mean / (mean**2 * (relative**2 + typical**2) + 1e-300), 0)
    weight /= max((weight * mean).sum(), 1e-300)
    total = _welch(*((a * weight).sum((1, 2, 3))[:, None] for a in (one, other)))
    p, error, deviation, freedom = (float(v[0]) for v in (total.p, total.difference, total.error, total.freedom))
    return p, error, abs(error) + float(stats.t.ppf(0.995, freedom)) * deviation
