"""Every hard case: our error within its bound, the naive formula's beyond it, and Mitsuba's not clearly smaller."""

import numpy as np
import pytest

from tests.stability import all_cases
from tests.stability.case import Case, Errors, relative, spacing, ulps

ALL = all_cases()
NAMES = [case.name for case in ALL]


@pytest.mark.parametrize("case", ALL, ids=NAMES)
def test_our_error_is_within_its_bound(case):
    """The worst of ours is no worse than its roundings explain."""
    assert case.found["ours"].worst <= case.allowed, case.found


@pytest.mark.parametrize("case", ALL, ids=NAMES)
def test_the_naive_formula_is_beyond_it(case):
    """Otherwise the case is not hard, and says nothing."""
    assert case.found["naive"].worst > case.allowed, case.found


@pytest.mark.oracle
@pytest.mark.parametrize("case", [case for case in ALL if case.mitsuba], ids=lambda case: case.name)
def test_mitsuba_is_not_clearly_better(case):
    """Unless the case says why."""
    assert case.remark or not case.mitsuba_is_better(), case.found


def test_names_are_unique():
    """A case is told by its name, on the page and on the command line."""
    assert len(set(NAMES)) == len(NAMES)


def test_errors_are_judged():
    """Signs do not count, what is not finite counts as infinite, and no error at all is a mistake."""
    found = Errors.of([[1, -3], [0, 0]])
    assert (found.worst, found.mean, found.count) == (3, 1, 4)
    assert Errors.of([True, False]).mean == 0.5
    assert Errors.of([0, np.nan]).worst == np.inf == Errors.of([-np.inf, 1]).mean
    with pytest.raises(ValueError, match="nothing"):
        Errors.of([])


def test_units_are_float32s():
    """An ulp is the distance to the next float32, that of subnormal numbers at the least."""
    values = np.array([1.0, 1.5, 3.0, 1e-3, 1e20, 0.0], np.float32)
    above = np.nextafter(values, np.float32(np.inf))
    np.testing.assert_array_equal(ulps(above, values), 1)
    assert spacing(1.0) == 2.0**-23 and spacing(2.0**-140) == 2.0**-149
    assert relative(1.1, 1.0) == pytest.approx(0.1) and relative(1e-320, 0.0) < 1


@pytest.mark.parametrize("ours, theirs, better", [(3.0, 1.0, True), (1.5, 1.0, False), (0.9, 0.1, False)])
def test_better_means_clearly(ours, theirs, better):
    """By a factor of two at the worst, and by more than a rounding."""
    case = Case("x", "ulp", 9, "", lambda: [ours], lambda: [10], "", lambda: [theirs])
    assert case.mitsuba_is_better() == better
