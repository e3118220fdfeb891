"""Judging: which side of a limit counts as met, and how figures are written."""

import math

import pytest

from benchmarks.targets import HIGHER, LOWER, Figure, number, sentence, verdict


@pytest.mark.parametrize("better, reached, met", [
    (LOWER, 0.59, True), (LOWER, 0.6, True), (LOWER, 0.61, False), (LOWER, math.nan, False),
    (HIGHER, 0.59, False), (HIGHER, 0.6, True), (HIGHER, 0.61, True), (HIGHER, math.nan, False),
])  # fmt: skip
def test_limit_is_met_up_to_itself_on_the_better_side(better, reached, met):
    """The limit itself counts as met, and what was not measured does not."""
    assert Figure("start", "s", better, reached, 0.6).holds(0.6) is met


def test_figure_without_limit_is_not_judged():
    """Where nothing is asked nothing can be missed."""
    figure = Figure("start", "s", LOWER, 5.0)
    assert (figure.holds(None), verdict(figure, None)) == (None, "-")


def test_sentence_tells_reached_least_and_aim():
    """The line that ends a run has all three, each judged by itself."""
    line = sentence(Figure("scene, warm", "s", LOWER, 0.45, least=0.6, aim=0.36))
    assert line == "scene, warm: 0.450 s (asked: at most 0.600 s: met; aim: at most 0.360 s: missed)"


@pytest.mark.parametrize("value, text", [
    (0.0, "0.000"), (0.1234, "0.123"), (1.234, "1.23"), (12.34, "12.3"), (123.4, "123"), (-6.284, "-6.28"),
    (960000, "960000"),
])  # fmt: skip
def test_numbers_have_three_digits(value, text):
    """Numbers are short, and counts are in full."""
    assert number(value) == text
