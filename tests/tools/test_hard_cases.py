"""The page of hard cases is read as it is written."""

import math

import pytest

from tests.stability import all_cases
from tools import hard_cases

TEXT = """# Numbers

## Far: away

| case | unit | allowed | ours | naive | Mitsuba |
| --- | --- | --- | --- | --- | --- |
| one, of two | ulp | 4.0e-01 | 2e-01, 0.1 | infinite, infinite | - |

- *one, of two*: measured x 2, for a reason.

## Seams

| case | unit | allowed | ours | naive | Mitsuba |
| --- | --- | --- | --- | --- | --- |
| wrong | share | 0 | 0, 0 | 1, 0.24 | 0, 0 |
"""


def test_rows_are_read_with_their_sections():
    """Heads and rules of tables are none; who cannot be asked is left out."""
    far, wrong = hard_cases.read(TEXT)
    assert far == hard_cases.HardCase("Far: away", "one, of two", "ulp", 0.4, (0.2, 0.1), (math.inf, math.inf), None)
    assert (wrong.section, wrong.name, wrong.naive, wrong.mitsuba) == ("Seams", "wrong", (1, 0.24), (0, 0))


def test_errors_are_told_over_their_bounds():
    """Where nothing may be wrong, something wrong is infinitely too much."""
    far, wrong = hard_cases.read(TEXT)
    assert far.strain("ours") == 0.5 and far.strain("naive") == math.inf
    assert wrong.strain("ours") == wrong.strain("mitsuba") == 0 and wrong.strain("naive") == math.inf


def test_a_row_with_a_cell_too_few_is_refused():
    """Nothing is left out in silence."""
    with pytest.raises((TypeError, ValueError)):
        hard_cases.read(TEXT.replace("| 1, 0.24 ", ""))


def test_all_cases_of_the_page_are_read():
    """In the order in which the cases write it."""
    found = hard_cases.read(hard_cases.PAGE.read_text(encoding="utf-8"))
    assert [case.name for case in found] == [case.name for case in all_cases()]
