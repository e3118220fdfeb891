"""The check for falls of ratios against Mitsuba, with made-up results: what is compared, when a ratio has fallen."""

import copy
import json

import pytest

from benchmarks import regression, table
from benchmarks.regression import FALLEN, FELL, FINE, HELD, NOTHING, ROSE, Comparison

EFFORT = {"repeats": 9, "width": 1200, "height": 800, "samples": 64}
MACHINE = {"cpu": "Abacus", "cores": 2, "commit": "abc"}


def spread(median, share=0.02):
    """Return a spread of +- a share."""
    return {"median": median, "min": median * (1 - share), "max": median * (1 + share)}


@pytest.fixture
def results():
    """Made-up results of three benchmarks."""
    rows = [{"scene": name, "speed, x Mitsuba": spread(4.0), "relative MSE, x Mitsuba's independent": 0.5,
             "our M samples/CPU s": spread(10.0)} for name in ("one", "two")]  # fmt: skip
    building = [{"mesh": "bumpy", "triangles": size, "time, x Mitsuba": spread(0.5)} for size in (1000, 10000)]
    equal = [{"scene": "one", "llvm best, x Mitsuba": spread(6.0), "scalar best, x Mitsuba": None}]
    curves = [{"scene": "one", "contender": name, "samples a pixel": samples + more}
              for name, more in (("ours", 0), ("llvm orthogonal", 1), ("llvm independent", 0), ("scalar orthogonal", 2))
              for samples in (4, 16, 64, 256)]  # fmt: skip
    found = {"paths": {"paths": rows}, "meshes": {"building": building},
             "error": {"curves": curves, "at equal error": equal}}  # fmt: skip
    return {"machine": MACHINE, "effort": dict(EFFORT),
            "benchmarks": {name: {"figures": [], "tables": tables} for name, tables in found.items()}}  # fmt: skip


@pytest.fixture
def measured(results):
    """The same, measured again."""
    return copy.deepcopy(results)


def speed(results, row=0):
    """Return the row of a scene's speed."""
    return results["benchmarks"]["paths"]["tables"]["paths"][row]


def test_same_results_hold(results, measured, capsys):
    """Every ratio is compared, and no other number."""
    assert regression.check(measured, results) == FINE
    comparisons, left_out = regression.compare(measured, results)
    assert {one.verdict for one in comparisons} == {HELD} and left_out == []
    assert [one.name for one in comparisons] == [
        "paths, one, speed, x Mitsuba", "paths, two, speed, x Mitsuba", "meshes, bumpy, 1000, time, x Mitsuba",
        "meshes, bumpy, 10000, time, x Mitsuba", "error, one, llvm best, x Mitsuba",
    ]  # fmt: skip
    assert "5 ratios compared, 0 fell" in capsys.readouterr().out


@pytest.mark.parametrize("factor, verdict", [(0.84, FELL), (0.86, HELD), (1.0, HELD), (1.17, HELD), (1.19, ROSE)])
def test_fall_beyond_tolerance_is_one(results, measured, factor, verdict):
    """15 % where spreads are small."""
    speed(measured)["speed, x Mitsuba"] = spread(4.0 * factor)
    assert regression.compare(measured, results)[0][0].verdict == verdict


def test_one_fall_is_told_with_its_numbers(results, measured, capsys):
    """Its name, both values, the tolerance, and the exit status."""
    speed(measured, row=1)["speed, x Mitsuba"] = spread(2.0)
    assert regression.check(measured, results) == FALLEN
    said = capsys.readouterr().out
    assert "| paths, two, speed, x Mitsuba | 4.00 (3.92 to 4.08) | 2.00 (1.96 to 2.04) | 0.500 | 15 % | fell |" in said
    assert said.endswith("5 ratios compared, 1 fell\n  paths, two, speed, x Mitsuba\n")


@pytest.mark.parametrize("factor, verdict", [(1.25, FELL), (1.1, HELD), (0.8, ROSE)])
def test_time_is_better_when_lower(results, measured, factor, verdict):
    """Building in 1.25 times the time is a fall."""
    measured["benchmarks"]["meshes"]["tables"]["building"][1]["time, x Mitsuba"] = spread(0.5 * factor)
    assert regression.compare(measured, results)[0][3].verdict == verdict


@pytest.mark.parametrize("before, after, tolerance", [
    (0.02, 0.03, 0.15), (0.06, 0.08, 0.2), (0.0, 0.02, 0.3), (0.3, 0.4, 0.5),
])  # fmt: skip
def test_tolerance_follows_the_spreads(before, after, tolerance):
    """Twice the spreads of both, within bounds; where one run has none, a fixed share."""
    assert Comparison("x", spread(4.0, before), spread(3.0, after)).tolerance == pytest.approx(tolerance)


def test_half_the_speed_is_always_a_fall():
    """Noise that would hide it is itself a fault."""
    assert Comparison("x", spread(4.0, 0.9), spread(1.9, 0.9)).verdict == FELL


def test_nan_is_a_fall():
    """It compares with nothing, and must not pass for that."""
    assert Comparison("x", spread(4.0), spread(float("nan"))).verdict == FELL


def test_ratio_that_is_reached_no_more_is_a_fall(results, measured):
    """None came of the same measurement that had one."""
    measured["benchmarks"]["error"]["tables"]["at equal error"][0]["llvm best, x Mitsuba"] = None
    assert regression.compare(measured, results)[0][-1].verdict == FELL
    assert regression.check(measured, results) == FALLEN


@pytest.mark.parametrize("key", ["width", "height", "samples"])
def test_other_sizes_are_not_compared(results, measured, key):
    """Ratios of small pictures are others; those at equal error are compared all the same."""
    measured["effort"][key] //= 4
    speed(measured)["speed, x Mitsuba"] = spread(1.0)
    comparisons, left_out = regression.compare(measured, results)
    assert [one.name for one in comparisons] == ["error, one, llvm best, x Mitsuba"]
    assert left_out == [f"{name}: measured at another size than the committed results" for name in ("paths", "meshes")]


def test_repeats_may_differ(results, measured):
    """They change the spread and nothing else."""
    measured["effort"]["repeats"] = 2
    assert len(regression.compare(measured, results)[0]) == 5


def test_only_what_was_measured_is_compared(results, measured):
    """A subset of scenes is held to theirs."""
    measured["benchmarks"] = {"paths": measured["benchmarks"]["paths"]}
    del measured["benchmarks"]["paths"]["tables"]["paths"][0]
    assert [one.name for one in regression.compare(measured, results)[0]] == ["paths, two, speed, x Mitsuba"]


def test_errors_of_other_numbers_of_samples_are_not_compared(results, measured):
    """Where a short run came only to 17 samples, it is at another error; 80 in the place of 65 are the same."""
    rows = measured["benchmarks"]["error"]["tables"]["curves"]
    for row in rows:
        row["samples a pixel"] = {65: 80}.get(row["samples a pixel"], row["samples a pixel"])
    assert regression.compare(measured, results)[1] == []
    rows[:] = [row for row in rows if row["samples a pixel"] < 20]
    comparisons, left_out = regression.compare(measured, results)
    assert not any("error" in one.name for one in comparisons)
    assert left_out == ["error, one, llvm best, x Mitsuba: at the error of 17 samples a pixel, and of 65 before"]


def test_new_scene_is_told_and_not_judged(results, measured, capsys):
    """There is nothing to compare it with."""
    speed(measured)["scene"] = "new"
    assert regression.check(measured, results) == FINE
    assert "paths, new, speed, x Mitsuba: not measured before" in capsys.readouterr().out


def test_nothing_in_common_does_not_pass(results, measured, capsys):
    """A check that compared nothing has found nothing out."""
    measured["benchmarks"] = {"unknown": measured["benchmarks"]["paths"]}
    assert regression.check(measured, results) == NOTHING
    assert "unknown: not measured before" in capsys.readouterr().out


def test_machines_are_named(results, measured, capsys):
    """A fall on another processor says little."""
    measured["machine"] = MACHINE | {"cpu": "Difference Engine"}
    regression.check(measured, results)
    assert capsys.readouterr().out.startswith("measured: Difference Engine, 2 cores, commit abc\ncommitted: Abacus, 2")


def test_committed_results_have_ratios_of_every_benchmark_that_should():
    """Columns were not renamed behind the check's back, and each is compared with itself."""
    from benchmarks.__main__ import NEED_MITSUBA

    results = json.loads(table.RESULTS.read_text())
    comparisons, left_out = regression.compare(copy.deepcopy(results), results)
    assert {one.name.split(",")[0] for one in comparisons} == set(NEED_MITSUBA) & set(results["benchmarks"])
    assert left_out == [] and len({one.name for one in comparisons}) == len(comparisons) > 40
    assert {one.verdict for one in comparisons} == {HELD}
