"""The plot of the hard cases: what is drawn is what was measured, and the committed plot is of the committed page."""

import math

import pytest

from tools import accuracy
from tools.hard_cases import PAGE, HardCase, read

CASES = [HardCase("Far: away", "one, of two", "ulp", 0.4, (0.2, 0.1), (math.inf, math.inf), None),
         HardCase("Far: away", "wrong", "share", 0.0, (0.0, 0.0), (1.0, 0.24), (0.0, 0.0))]  # fmt: skip


@pytest.mark.parametrize("ratio, place", [(0, accuracy.NONE), (3.0, 3.0), (math.inf, accuracy.WRONG)])
def test_place_on_the_axis(ratio, place):
    """No error and infinite ones have places of their own."""
    assert accuracy.position(ratio) == place


def test_every_case_has_a_dot():
    """Each side has as many as it was asked."""
    lines = {line.get_label(): line for line in accuracy.figure(CASES).axes[0].lines}
    assert [len(lines[label].get_xdata()) for label, _, _ in accuracy.SIDES.values()] == [2, 1, 2]
    assert list(lines["ours"].get_xdata()) == [0.5, accuracy.NONE]


def test_committed_plot_is_of_the_committed_page():
    """Else `python -m tools.accuracy` is due."""
    cases = read(PAGE.read_text(encoding="utf-8"))
    assert len(cases) > 50
    assert f"rows {accuracy.digest(cases)}" in accuracy.PLOT.read_text(encoding="utf-8")


def test_same_page_gives_the_same_bytes(tmp_path):
    """No date and no random names of parts."""
    paths = [accuracy.write(tmp_path / name) for name in ("a.svg", "b.svg")]
    assert paths[0].read_bytes() == paths[1].read_bytes()
