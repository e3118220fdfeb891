"""`python -m benchmarks`: arguments, what is written where, and statuses. Nothing is measured here."""

import json

import pytest

import benchmarks.__main__ as command
from benchmarks import measure, table


@pytest.fixture
def measured(monkeypatch):
    """A stand-in for measuring; returns the list of what was asked for."""
    asked = []

    def run(names, effort):
        asked.append((names, effort))
        return {"told": names}

    monkeypatch.setattr(command, "run", run)
    monkeypatch.setattr(table, "page", lambda results: "the page")
    monkeypatch.setattr(table, "figures", lambda results: [])
    monkeypatch.setattr(table, "write", lambda results: asked.append("written"))
    return asked


@pytest.mark.parametrize("arguments, told", [
    (["throughputs"], "unknown benchmark 'throughputs', did you mean 'throughput'?"),
    (["everything"], "unknown benchmark 'everything' (there are: whole_process,"),
    (["throughput", "--json", "/no/such/folder/x.json"], "cannot write to '/no/such/folder/x.json'"),
    (["throughput", "--json", "/"], "cannot write to '/'"),
    (["--update"], "--update goes with names of benchmarks"),
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
    assert measured == [(list(command.BENCHMARKS), measure.FULL), "written"]


@pytest.mark.parametrize("arguments, names, effort", [
    (["--quick"], list(command.BENCHMARKS), measure.QUICK),
    (["variants", "throughput"], ["throughput", "variants"], measure.FULL),
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


def test_json_goes_where_it_is_told(measured, tmp_path):
    """--json writes there and nowhere else."""
    assert command.main(["--json", str(tmp_path / "x.json")]) == 0
    assert json.loads((tmp_path / "x.json").read_text()) == {"told": list(command.BENCHMARKS)}
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
