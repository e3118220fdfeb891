"""What a hard case is: the errors of our formula, of the naive one beside it, and of Mitsuba's on the same input.

A module of this folder that measures has a docstring (what is hard there) and `CASES`. `test_cases.py` judges them,
`python -m tests.stability` makes the table of docs/stability.md.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

ULP = 2.0**-24  # largest relative error of one rounding to float32
CLEARLY = 2.0  # Mitsuba is called better where its worst error, and its mean one, are smaller by this factor


@dataclass(frozen=True)
class Errors:
    """Worst and mean of errors; NaN and infinity among them make both infinite."""

    worst: float
    mean: float
    count: int

    @classmethod
    def of(cls, errors):
        """Judge errors of any shape, signed or not, or masks of what is wrong. Raises ValueError if there is none."""
        errors = np.abs(np.asarray(errors, np.float64)).ravel()
        if errors.size == 0:
            raise ValueError("nothing was measured")
        errors = np.where(np.isfinite(errors), errors, np.inf)
        return cls(float(errors.max()), float(errors.mean()), errors.size)


@dataclass(frozen=True)
class Case:
    """One hard case. The callables take nothing and return errors, one for each input, in `unit`."""

    name: str
    unit: str  # `ulp`, `relative`, `share` (of wrong answers), or words
    allowed: float  # worst error, ours
    because: str  # where the bound comes from, in a clause
    ours: Callable
    naive: Callable
    naive_name: str  # which formula that is, in a few words
    mitsuba: Callable | None = None
    remark: str = ""  # why Mitsuba cannot be asked, or why it may be better

    @functools.cached_property
    def found(self):
        """Return {"ours", "naive", "mitsuba"} -> Errors, None for a Mitsuba that cannot be asked. Measured once."""
        sides = {"ours": self.ours, "naive": self.naive, "mitsuba": self.mitsuba}
        return {side: measure and Errors.of(measure()) for side, measure in sides.items()}

    def mitsuba_is_better(self):
        """Return whether Mitsuba's errors are clearly smaller, the worst or the mean, and ours more than a rounding."""
        ours, theirs = self.found["ours"], self.found["mitsuba"]
        if theirs is None:
            return False
        floor = {"ulp": 1.0, "relative": ULP}.get(self.unit, 0.0)
        return any(a > max(CLEARLY * b, floor) for a, b in ((ours.worst, theirs.worst), (ours.mean, theirs.mean)))


def mitsuba():
    """Return the module `mitsuba` in the variant that all tests use."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    return mi


def ulps(value, exact):
    """Return the errors of float32 values against exact float64 ones, in spacings of float32 there."""
    exact = np.asarray(exact, np.float64)
    return np.abs(np.asarray(value, np.float64) - exact) / spacing(exact)


def spacing(exact):
    """Return the distance of float32 numbers at float64 values: float32's spacing, the subnormals' at the least."""
    exact = np.abs(exact)
    _, exponent = np.frexp(exact)
    return np.where(exact == 0, 2.0**-149, np.ldexp(1.0, np.maximum(exponent - 24, -149)))


def relative(value, exact, floor=1e-300):
    """Return the errors of values relative to exact float64 ones."""
    exact = np.asarray(exact, np.float64)
    return np.abs(np.asarray(value, np.float64) - exact) / np.maximum(np.abs(exact), floor)
