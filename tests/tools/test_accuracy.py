"""The plot of the hard cases: what is drawn is what was measured, and the committed plot is of the committed page."""

import math

import pytest

from tools import accuracy

TEXT = """## Far: away

| case | unit | allowed | ours | naive | Mitsuba |
| --- | --- | --- | --- | --- | --- |
| one, of two | ulp | 4.0e-01 | 2e-01, 0.1 | infinite, infinite | - |
| wrong | share | 0 | 0, 0 | 1, 0.24 | 0, 0 |
"""


@pytest.fixture
def cases():
    """The rows of a made-up page."""
    return accuracy.rows(TEXT)


def test_rows_are_read_with_their_sections(cases):
    """Heads and rules of tables are none; who cannot be asked is left out."""
    assert [(case.section, case.case, case.allowed) for case in cases] == [
        ("Far: away", "one, of two", 0.4), ("Far: away", "wrong", 0.0)]  # fmt: skip
    assert cases[0].worst == {"ours": 0.2, "naive": math.inf}


def test_errors_are_told_over_their_bounds(cases):
    """Where nothing may be wrong, something wrong is infinitely too much."""
    assert cases[0].ratio("ours") == 0.5 and cases[0].ratio("naive") == math.inf
    assert cases[1].ratio("ours") == cases[1].ratio("mitsuba") == 0 and cases[1].ratio("naive") == math.inf


@pytest.mark.parametrize("ratio, place", [(0, accuracy.NONE), (3.0, 3.0), (math.inf, accuracy.WRONG)])
def test_place_on_the_axis(ratio, place):
    """No error and infinite ones have places of their own."""
    assert accuracy.position(ratio) == place


def test_every_case_has_a_dot(cases):
    """Each side has as many as it was asked."""
    lines = {line.get_label(): line for line in accuracy.figure(cases).axes[0].lines}
    assert [len(lines[label].get_xdata()) for label, _, _ in accuracy.SIDES.values()] == [2, 1, 2]
    assert list(lines["ours"].get_xdata()) == [0.5, accuracy.NONE]


def test_committed_plot_is_of_the_committed_page():
    """Else `python -m tools.accuracy` is due."""
    cases = accuracy.rows(accuracy.PAGE.read_text(encoding="utf-8"))
    assert len(cases) > 50
    assert f"rows {accuracy.digest(cases)}" in accuracy.PLOT.read_text(encoding="utf-8")


def test_same_page_gives_the_same_bytes(tmp_path):
    """No date and no random names of parts."""
    paths = [accuracy.write(tmp_path / name) for name in ("a.svg", "b.svg")]
    assert paths[0].read_bytes() == paths[1].read_bytes()
