"""What the report tells of speed at equal error, and of what was missed."""

import pytest

from benchmarks import plots
from benchmarks.targets import Figure
from tools.report import error, limits, results


def row(contender, samples, seconds, mse):
    """Return a row of the benchmark's curves."""
    return {"scene": "box", "contender": contender, plots.SAMPLES: samples, plots.TIME: {"median": seconds},
            plots.ERROR: {"median": mse}}  # fmt: skip


def figure(name, better, reached, least, aim=None, unit="x Mitsuba"):
    """Return a judged figure."""
    return {"name": name, "unit": unit, "better": better, "reached": reached, "least": least, "aim": aim}


@pytest.fixture
def measured(monkeypatch):
    """Made-up results in the place of the repository's."""
    curves = [row("ours", 64, 0.5, 1e-4), row("ours", 16, 0.1, 1e-3), row("llvm independent", 64, 2.0, 3e-4),
              row("llvm stratified", 64, 2.5, 2e-4)]  # fmt: skip
    judged = [figure("box, rate", "higher", 3.0, 4.0, 5.0), figure("box, memory", "lower", 3.0, 4.0, 1.0),
              figure("soup, 1000000 triangles, rate x log", "higher", 2.0, 2.0)]  # fmt: skip
    found = {"error": {"tables": {plots.CURVES: curves}, "figures": []}, "paths": {"tables": {}, "figures": judged}}
    monkeypatch.setattr(results, "results", lambda: {"benchmarks": found})


def test_speed_and_error_are_compared_at_equal_samples(measured):
    assert error.rate("box") == pytest.approx(4) and error.gain("box") == pytest.approx(3)
    assert error.beside_best({"scene": "box", "Mitsuba's best other sampler": "stratified"}) == pytest.approx(2)


def test_only_what_missed_what_was_asked_is_told(measured):
    """Neither an aim that was missed nor a limit that was just kept."""
    assert error.missed() == {"missed": [["box, rate", "3.0", "4.0"]]}


@pytest.mark.parametrize("contender, kind", [
    ("ours", "ours"), ("llvm independent", "Mitsuba llvm, independent"),
    ("scalar orthogonal", "Mitsuba scalar, best sampler"),
])  # fmt: skip
def test_contenders_of_all_scenes_have_one_name(contender, kind):
    assert error.kind(contender) == kind


@pytest.mark.parametrize("name, unit, told", [
    ("soup, 1000000 triangles, memory", "bytes/triangle", "soup, 1,000,000 triangles, memory, bytes/triangle"),
    ("box, rate x log", "x Mitsuba", "box, rate × log beside Mitsuba"),
    ("box, speed beside Mitsuba", "x", "box, speed beside Mitsuba"),
])  # fmt: skip
def test_missed_figures_have_names_and_units(name, unit, told):
    assert limits.name(Figure(**figure(name, "lower", 1.0, 1.0, unit=unit))) == told


def test_light_that_is_lost_is_that_of_the_page_on_furnaces():
    """31 and 69 per cent."""
    assert [limits.lost(alpha).split("\u202f")[0] for alpha in (0.5, 1.0)] == ["31", "69"]
