"""What the report tells of hard cases: a row a group, of the page that the cases write."""

import math

import pytest

from tests.stability import all_cases
from tools.report import results, stability

PAGE = """# Numbers

## Cones

| case | unit | allowed | ours | naive | Mitsuba |
| --- | --- | --- | --- | --- | --- |
| easy | relative | 1.0e-06 | 1.0e-07, 1.0e-08 | infinite, infinite | - |
| hard, 1e-4 | relative | 1.0e-06 | 9.0e-07, 1.0e-08 | 0.5, 0.1 | 1.0e-07, 1.0e-08 |

- *easy*: measured x 2, for a reason.

## Seams

| case | unit | allowed | ours | naive | Mitsuba |
| --- | --- | --- | --- | --- | --- |
| met | share | 0 | 0, 0 | 1, 0.25 | 1, 0.001 |
"""


def test_all_cases_of_the_page_are_read():
    found = [line for group in stability.groups(results.STABILITY.read_text()).values() for line in group]
    assert [line.name for line in found] == [case.name for case in all_cases()]


def test_a_group_shows_the_case_nearest_to_its_bound():
    """With powers of ten, and shares as per cent of what was asked."""
    cones, seams = stability.groups(PAGE).values()
    assert [text.replace("\u202f", " ") for text in stability.row(cones)] == [
        "2", "hard, 10⁻⁴", "relative", "1.0 × 10⁻⁶", "9.0 × 10⁻⁷", "0.50", "1.0 × 10⁻⁷"]  # fmt: skip
    assert [text.replace("\u202f", " ") for text in stability.row(seams)] == [
        "1", "met", "share", "0", "0 %", "25 %", "0.10 %"]  # fmt: skip


def test_a_broken_bound_of_nought_comes_first():
    line = stability.Line("broken", "share", 0.0, (1.0, 0.5), None, None)
    assert line.strain == math.inf and not line.within("ours") and line.within("mitsuba") is None


def test_who_is_better_is_judged_as_the_tests_do():
    """By a factor of two, in the worst error or the mean."""
    easy, hard, met = [line for group in stability.groups(PAGE).values() for line in group]
    assert [line.mitsuba_is_better for line in (easy, hard, met)] == [False, True, False]


@pytest.mark.parametrize("number, text", [(math.inf, "∞"), (0.26, "0.26"), (65.0, "65"), (1.7e7, "1.7 × 10⁷")])
def test_large_numbers_have_powers_of_ten(number, text):
    assert stability.value(number).replace("\u202f", " ") == text


def test_what_accuracy_costs_is_found_in_the_page_on_speed():
    assert set(stability.costs()) == {"cost_phong", "cost_paths", "cost_lens", "cost_twice"}
