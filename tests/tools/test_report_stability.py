"""What the report tells of hard cases: a row a group, of the page that the cases write."""

import math

import pytest

from tools.hard_cases import read
from tools.report import stability

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


def test_a_group_shows_the_case_nearest_to_its_bound():
    """With powers of ten, and shares as per cent of what was asked."""
    cones, seams = stability.groups(read(PAGE))
    assert [text.replace("\u202f", " ") for text in stability.row(cones)] == [
        "2", "hard, 10⁻⁴", "relative", "1.0 × 10⁻⁶", "9.0 × 10⁻⁷", "0.50", "1.0 × 10⁻⁷"]  # fmt: skip
    assert [text.replace("\u202f", " ") for text in stability.row(seams)] == [
        "1", "met", "share", "0", "0 %", "25 %", "0.10 %"]  # fmt: skip


def test_who_is_better_is_judged_as_the_tests_do():
    """By a factor of two, in the worst error or the mean."""
    assert [stability.mitsuba_is_better(case) for case in read(PAGE)] == [False, True, False]


@pytest.mark.parametrize("number, text", [(math.inf, "∞"), (0.26, "0.26"), (65.0, "65"), (1.7e7, "1.7 × 10⁷")])
def test_large_numbers_have_powers_of_ten(number, text):
    assert stability.value(number).replace("\u202f", " ") == text


def test_what_accuracy_costs_is_found_in_the_page_on_speed():
    assert set(stability.costs()) == {"cost_phong", "cost_paths", "cost_lens", "cost_twice"}
