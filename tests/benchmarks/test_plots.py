"""Plots of speed against error: what is drawn was measured, and the committed ones are of the committed results."""

import json
import re
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from benchmarks import plots, table

CONTENDERS = {"ours": 1, "llvm independent": 4, "llvm multijitter": 3, "scalar independent": 20,
              "scalar multijitter": 15}  # fmt: skip
SAMPLES = (4, 16, 64)


def row(scene, contender, samples):
    """Return one made-up row of the table of curves."""
    time, error = 0.001 * CONTENDERS[contender] * samples, 0.5 / samples
    return {"scene": scene, "contender": contender, "samples a pixel": samples,
            "CPU time (s)": {"median": time, "min": 0.9 * time, "max": 1.2 * time}, "wall time (s)": time / 2,
            "MSE": error, "relative MSE": {"median": error, "min": 0.8 * error, "max": 1.1 * error}}  # fmt: skip


@pytest.fixture
def results():
    """Made-up results that a test may change."""
    return made_up()


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The paths of plots of made-up results, written into a folder with older files."""
    folder = tmp_path_factory.mktemp("plots")
    (folder / "error_old.svg").touch()
    (folder / "other.svg").touch()
    return plots.write(made_up(), folder)


def made_up():
    """Return results of two scenes; on one, scalar rendering did not reach the error of ours."""
    rows = [row(scene, name, samples) for scene in ("plain", "thin_lens") for name in CONTENDERS for samples in SAMPLES]
    ratio = {"median": 4.0, "min": 3.0, "max": 5.0}
    equal = [{"scene": "plain", "llvm best, x Mitsuba": {"median": 0.5, "min": 0.5, "max": 0.5},
              "scalar best, x Mitsuba": None},
             {"scene": "thin_lens", "llvm best, x Mitsuba": ratio, "scalar best, x Mitsuba": 12.0}]  # fmt: skip
    return {"benchmarks": {"error": {"tables": {"curves": rows, "at equal error": equal}}}}


def test_every_scene_has_its_plot_with_all_contenders(written):
    """Labels are drawn as outlines; their words stand in comments."""
    assert [path.name for path in written] == ["error_plain.svg", "error_thin_lens.svg", "errors.png", "speedup.svg"]
    words = re.findall(r"<!-- (.*?) -->", written[1].read_text())
    assert {"ours", "Mitsuba llvm multijitter", "Mitsuba scalar independent"} <= set(words)
    assert {"4 samples", "64 samples", "thin lens"} <= set(words)


def test_same_results_give_the_same_bytes(results, written, tmp_path):
    """No date, no version, no random names of parts."""
    again = plots.write(json.loads(json.dumps(results)), tmp_path)
    assert [path.read_bytes() for path in written] == [path.read_bytes() for path in again]


def test_plots_are_small(written):
    """They are kept in the repository."""
    assert max(path.stat().st_size for path in written) < 100_000


def test_plot_of_a_scene_that_has_gone_goes(written):
    """An old plot beside new ones would be taken for one of them."""
    there = {path.name for path in written[0].parent.iterdir()}
    assert there == {path.name for path in written} | {"other.svg"}


def test_points_are_medians_in_the_order_of_samples(results):
    """Time to the right, error upwards, both logarithmic, with their spreads."""
    rows = results["benchmarks"]["error"]["tables"]["curves"]
    axes = Figure().subplots()
    line, end = plots._draw(axes, "plain", rows[::-1])["llvm multijitter"]
    assert list(line.get_xdata()) == pytest.approx([0.003 * samples for samples in SAMPLES])
    assert list(line.get_ydata()) == pytest.approx([0.5 / samples for samples in SAMPLES])
    assert end == (line.get_xdata()[-1], line.get_ydata()[-1])
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    crosses = axes.lines[axes.lines.index(line) + 1]
    assert list(crosses.get_xdata()[:2]) == pytest.approx([0.9 * 0.012, 1.2 * 0.012])
    assert list(crosses.get_ydata()[3:5]) == pytest.approx([0.8 * 0.125, 1.1 * 0.125])


def test_level_without_an_error_is_left_out(results):
    """Where the reference was not good enough, there is no point."""
    rows = results["benchmarks"]["error"]["tables"]["curves"]
    next(r for r in rows if r["scene"] == "plain" and r["contender"] == "ours")["relative MSE"] = None
    _, _, samples = plots.curves(rows, "plain")["ours"]
    assert samples == [16, 64]


def test_time_on_a_gpu_is_that_of_the_clock(results):
    """Its CPU only waits."""
    rows = results["benchmarks"]["error"]["tables"]["curves"]
    rows.append(rows[0] | {"contender": "ours cuda"})
    (time,), _, _ = plots.curves(rows, "plain")["ours cuda"]
    assert time["median"] == pytest.approx(0.002)
    rows[-1]["scene"] = "other"
    assert "ours cuda" not in plots.curves(rows, "plain")


def test_bars_are_as_long_as_the_speed_up(results):
    """From 1, to the left where Mitsuba is faster; the greatest stands on top, and what is not known has none."""
    rows = results["benchmarks"]["error"]["tables"]["at equal error"]
    (axes,) = plots._of_speedups(rows).axes
    bars = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in axes.patches if bar.get_height() > 0.1]
    assert sorted(bars) == [(1, 0.5), (1, 4), (1, 12)]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["plain", "thin lens"]


@pytest.mark.parametrize("wanted, expected", [
    ([0.1, 0.5, 0.9], [0.1, 0.5, 0.9]), ([0.5, 0.5], [0.45, 0.55]), ([0.1, 0.5, 0.52, 0.54], [0.1, 0.42, 0.52, 0.62]),
    ([0.3, 0.39, 0.39], [0.26, 0.36, 0.46]), ([], []),
])  # fmt: skip
def test_labels_that_meet_share_the_way(wanted, expected):
    """They keep 0.1 apart, around the mean of where they belong."""
    assert plots.placed(wanted, 0.1) == pytest.approx(expected)


@pytest.mark.parametrize("contenders", [
    ("llvm independent", "llvm multijitter"), ("scalar ldsampler", "llvm ldsampler"), ("ours", "ours cuda"),
    ("cuda independent", "cuda stratified"),
])  # fmt: skip
def test_contenders_are_told_apart_without_colour(contenders):
    """Markers differ where colours do."""
    (colour, marker, _), (other, another, _) = map(plots.style, contenders)
    assert colour != other and marker != another


def test_digest_sees_every_number(results):
    """A plot of other numbers is told from this one."""
    before = plots.digest(results)
    results["benchmarks"]["error"]["tables"]["curves"][3]["relative MSE"]["max"] *= 1.0001
    assert plots.digest(results) != before


def test_committed_plots_are_of_the_committed_results():
    """Each tells the digest of the rows that it was made from; accuracy.svg has a test of its own."""
    results = json.loads(table.RESULTS.read_text())
    scenes = {row["scene"] for row in results["benchmarks"][plots.BENCHMARK]["tables"][plots.CURVES]}
    expected = {f"error_{scene}.svg" for scene in scenes} | {"errors.png", "speedup.svg"}
    assert {path.name for path in Path(plots.FOLDER).iterdir()} == expected | {"accuracy.svg"}
    for name in expected:
        assert f"rows {plots.digest(results)}".encode() in (plots.FOLDER / name).read_bytes(), name
