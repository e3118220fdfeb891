"""`python -m benchmarks`: arguments, what is written where, and statuses. Nothing is measured here."""

import dataclasses
import json

import pytest

import benchmarks.__main__ as command
from benchmarks import measure, plots, regression, table


@pytest.fixture
def measured(monkeypatch):
    """A stand-in for measuring; returns the list of what was asked for."""
    asked = []

    def run(names, effort):
        asked.append((names, effort))
        return {"told": names, "benchmarks": dict.fromkeys(names)}

    monkeypatch.setattr(command, "run", run)
    monkeypatch.setattr(table, "page", lambda results: "the page")
    monkeypatch.setattr(table, "figures", lambda results: [])
    monkeypatch.setattr(table, "write", lambda results: asked.append("written"))
    monkeypatch.setattr(plots, "write", lambda results: asked.append("plotted"))
    monkeypatch.setattr(command, "WITH_SCENES", {"paths": "benchmarks.path_scenes"})
    monkeypatch.setattr(command, "PLOTTED", "paths")
    return asked


@pytest.mark.parametrize("arguments, told", [
    (["throughputs"], "unknown benchmark 'throughputs', did you mean 'throughput'?"),
    (["everything"], "unknown benchmark 'everything' (there are: whole_process,"),
    (["throughput", "--json", "/no/such/folder/x.json"], "cannot write to '/no/such/folder/x.json'"),
    (["throughput", "--json", "/"], "cannot write to '/'"),
    (["--update"], "--update goes with names of benchmarks"),
    (["paths", "--update", "--check"], "--update goes with names of benchmarks"),
    (["paths", "--update", "--scene", "thin lens"], "--update goes with names of benchmarks"),
    (["--scene", "thin lens"], "--scene goes with names of benchmarks that have scenes: paths"),
    (["paths", "throughput", "--scene", "thin lens"], "--scene goes with names of benchmarks that have scenes: paths"),
    (["paths", "--scene", "thinlens"], "unknown scene of paths 'thinlens', did you mean 'thin lens'?"),
    (["--measured", "x.json"], "--measured goes with --check"),
    (["throughput", "--check"], "--check goes with benchmarks that have ratios against Mitsuba: against_mitsuba,"),
    (["throughput", "--update", "--quick"], "--update goes with names of benchmarks"),
])  # fmt: skip
def test_bad_arguments_are_told_before_measuring(arguments, told, measured, capsys):
    """A mistake costs no minutes, and its message names what was wrong."""
    assert command.main(arguments) == command.BAD_INPUT
    assert told in capsys.readouterr().err
    assert measured == []


def test_missing_mitsuba_is_told_before_measuring(measured, monkeypatch, capsys):
    """Only the comparison needs Mitsuba."""
    monkeypatch.setattr(command.importlib.util, "find_spec", lambda name: None)
    assert command.main([]) == command.BAD_INPUT
    assert "Mitsuba is not installed" in capsys.readouterr().err
    assert command.main(["throughput"]) == 0


def test_full_run_writes_the_committed_results(measured):
    """Without arguments everything is measured in full and written."""
    assert command.main([]) == 0
    assert measured == [(list(command.BENCHMARKS), measure.FULL), "written", "plotted"]


@pytest.mark.parametrize("arguments, names, effort", [
    (["--quick"], list(command.BENCHMARKS), measure.QUICK),
    (["variants", "throughput"], ["throughput", "variants"], measure.FULL),
    (["paths", "--scene", "thin lens", "--scene", "1,000 lights"], ["paths"],
     dataclasses.replace(measure.FULL, scenes=("thin lens", "1,000 lights"))),
])  # fmt: skip
def test_partial_run_leaves_the_committed_results(arguments, names, effort, measured):
    """What is not the whole is only printed."""
    assert command.main(arguments) == 0
    assert measured == [(names, effort)]


def test_update_writes_what_was_named(measured, monkeypatch):
    """Beside the committed results of the others."""
    monkeypatch.setattr(table, "updated", lambda results, names: results | {"beside": names})
    assert command.main(["throughput", "--update"]) == 0
    assert measured == [(["throughput"], measure.FULL), "written"]


def test_update_draws_the_plots_anew(measured, monkeypatch):
    """Those of the benchmark that has some."""
    monkeypatch.setattr(table, "updated", lambda results, names: results)
    assert command.main(["paths", "--update"]) == 0
    assert measured[1:] == ["written", "plotted"]


def test_json_goes_where_it_is_told(measured, tmp_path):
    """--json writes there and nowhere else."""
    assert command.main(["--json", str(tmp_path / "x.json")]) == 0
    assert json.loads((tmp_path / "x.json").read_text())["told"] == list(command.BENCHMARKS)
    assert "written" not in measured


def test_list_names_every_benchmark(measured, capsys):
    """--list measures nothing."""
    assert command.main(["--list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(command.BENCHMARKS)
    assert measured == []


def test_failed_measurement_is_told_in_words(monkeypatch, capsys):
    """No traceback for a process that could not be measured, but what it said."""

    def run(names, effort):
        measure.run_process("-c", "import sys; sys.exit('no such luck')")

    monkeypatch.setattr(command, "run", run)
    assert command.main(["throughput"]) == command.FAILED
    assert "ended with status 1: " in (told := capsys.readouterr().err) and "no such luck" in told


@pytest.mark.parametrize("arguments, names, effort", [
    ([], list(command.NEED_MITSUBA), measure.FULL), (["paths", "--quick"], ["paths"], measure.QUICK),
])  # fmt: skip
def test_check_measures_what_has_ratios_and_writes_nothing(arguments, names, effort, measured, monkeypatch):
    """Its status is that of the command."""
    compared = []
    monkeypatch.setattr(regression, "check", lambda now, before: compared.append((now, before)) or regression.FALLEN)
    assert command.main([*arguments, "--check"]) == regression.FALLEN
    assert measured == [(names, effort)]
    assert compared[0][0]["told"] == names and compared[0][1] == json.loads(table.RESULTS.read_text())


def test_check_takes_results_made_before(measured, monkeypatch, tmp_path):
    """Of the named benchmarks, and nothing is measured."""
    committed = json.loads(table.RESULTS.read_text())
    (tmp_path / "x.json").write_text(json.dumps(committed))
    compared = []
    monkeypatch.setattr(regression, "check", lambda now, before: compared.append(list(now["benchmarks"])) or 0)
    assert command.main(["--check", "--measured", str(tmp_path / "x.json"), "paths"]) == 0
    assert compared == [["paths"]] and measured == []


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"benchmarks": []}', None])
def test_file_without_results_is_told_in_words(text, tmp_path, capsys):
    """Nothing is compared with it."""
    if text is not None:
        (tmp_path / "x.json").write_text(text)
    assert command.main(["--check", "--measured", str(tmp_path / "x.json")]) == command.FAILED
    assert "x.json' has no results: " in capsys.readouterr().err


@pytest.mark.parametrize("name", command.WITH_SCENES)
def test_names_of_scenes_are_known_without_measuring(name):
    """The module that is asked has them, and leaves it to measuring to choose a backend."""
    module = command.WITH_SCENES[name]
    assert len(command.importlib.import_module(module).SCENES) > 3
    program = f"import sys, {module}; print('drjit' in sys.modules)"
    assert measure.run_process("-c", program).output == "False"
