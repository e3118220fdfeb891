"""docs/stability.md is about the cases that there are; its numbers belong to the machine that took them."""

import pytest

from tests.stability import __main__ as command
from tests.stability import all_cases
from tests.stability.case import Case

MADE_UP = Case("a case", "ulp", 2.0, "two roundings", lambda: [1.0, 0.0], lambda: [float("nan")], "the sum", remark="x")


def test_the_page_has_every_case():
    """With its bound; in the order of the modules."""
    page = command.PAGE.read_text()
    rows = [line for line in page.splitlines() if line.startswith("|")]
    places = [rows.index(row) for case in all_cases() for row in rows if row.startswith(head(case))]
    assert len(places) == len(all_cases()) and places == sorted(places)


def head(case):
    """Return how the row of a case begins."""
    return f"| {case.name} | {case.unit} | {command.short(case.allowed)} |"


def test_pages_tell_worst_and_mean_and_what_is_said():
    """A made-up case has its row under its module's title, and a line of its own below the table."""
    page = command.text([("made_up", "Title.\n\nMore.", [MADE_UP])])
    assert "| a case | ulp | 2 | 1, 0.5 | infinite, infinite | - |" in page and "## Title\n\nMore." in page
    assert "- *a case*: two roundings. Naive: the sum. Mitsuba: x." in page


@pytest.mark.parametrize("words, count", [((), 2), (("CASE",), 1), (("case", "other"), 2), (("none",), 0)])
def test_words_choose_cases(words, count):
    """In any case of letters; without words, all are chosen."""
    others = Case("another", "ulp", 1.0, "", None, None, "")
    assert sum(command._has(case, words) for case in (MADE_UP, others)) == count


def test_a_broken_bound_is_told(monkeypatch, capsys):
    """By name, and by the exit status."""
    broken = Case("broken", "ulp", 0.5, "", lambda: [1.0], lambda: [2.0], "")
    for case, status in ((broken, 1), (MADE_UP, 0)):
        monkeypatch.setattr("tests.stability.modules", lambda case=case: [("made_up", "Title.", [case])])
        assert command.main([]) == status
        assert ("beyond its bound: broken" in capsys.readouterr().err) == (status == 1)
