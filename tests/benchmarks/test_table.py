"""The tables: from results alone, and the committed ones from the committed results."""

import json

import pytest

from benchmarks import table

FIGURE = {"name": "start", "unit": "s", "better": "lower", "reached": 0.5, "least": 0.6, "aim": None}
SPREAD = {"median": 2.0, "min": 1.0, "max": 3.0}
MACHINE = {"cpu": "Abacus", "cores": 2, "system": "Linux", "llvm": "19.1.7", "python": "3.11.7", "drjit": "1.5.0",
           "mitsuba": None, "numpy": "2.4", "date": "2026-01-02", "commit": "abc", "load_before": 0.1}  # fmt: skip
EFFORT = {"repeats": 9, "width": 1200, "height": 800, "samples": 64}


@pytest.fixture
def results():
    """Results of one made-up benchmark."""
    rows = [{"scene": "one", "time (s)": SPREAD, "lights": 2, "best": None}]
    found = {"about": "What is measured.", "figures": [FIGURE], "tables": {"times": rows}}
    return {"machine": dict(MACHINE), "effort": EFFORT, "benchmarks": {"whole_process": found}}


def test_table_writes_each_kind_of_cell(results):
    """A spread, a count and a missing value are told apart."""
    rows = results["benchmarks"]["whole_process"]["tables"]["times"]
    assert table.table(rows).splitlines() == [
        "| scene | time (s) | lights | best |", "| --- | --- | --- | --- |", "| one | 2.00 (1.00 to 3.00) | 2 | - |",
    ]  # fmt: skip


def test_equal_spread_is_one_number():
    """A range whose ends look the same says nothing."""
    assert table.cell({"median": 2.0, "min": 1.999, "max": 2.001}) == "2.00"


@pytest.mark.parametrize("column, expected", [
    ("MSE", "1.23e-05 (1.00e-05 to 2.00e-05)"), ("relative MSE, x Mitsuba", "0.000"),
])  # fmt: skip
def test_errors_are_written_in_powers_of_ten(column, expected):
    """Three digits behind the point would leave nothing of them; ratios stay as they are."""
    rows = [{column: {"median": 1.234e-5, "min": 1e-5, "max": 2e-5}}]
    assert table.table(rows).splitlines()[-1] == f"| {expected} |"


def test_page_judges_figures(results):
    """The first table says whether what was asked was reached."""
    assert "| start | 0.500 s | at most 0.600 s: met | - |" in table.page(results)
    results["benchmarks"]["whole_process"]["figures"][0]["reached"] = 0.7
    assert "| start | 0.700 s | at most 0.600 s: missed | - |" in table.page(results)


def test_page_warns_of_a_busy_machine(results):
    """Numbers taken beside other work say so, others do not."""
    assert "not quiet" not in table.page(results)
    results["machine"]["load_before"] = 3.2
    assert "not quiet**: 3.2 processes" in table.page(results)


def test_blocks_of_documents_are_made_anew(results):
    """Only what stands between the marks is replaced."""
    text = "Before.\n<!-- results: whole_process.times -->\nold\n<!-- end of results -->\nAfter.\n"
    filled = table.filled(text, results)
    assert "old" not in filled and "| one | 2.00 (1.00 to 3.00) | 2 | - |\n<!-- end of results -->\nAfter." in filled
    assert table.filled(filled, results) == filled


def test_update_replaces_what_was_measured_and_says_when(results, tmp_path, monkeypatch):
    """The other benchmarks keep their results; the order stays that of the list."""
    other = {"about": "Another.", "figures": [], "tables": {"t": []}}
    committed = json.loads(json.dumps(results)) | {"benchmarks": {"whole_process": {**other}, "meshes": {**other}}}
    monkeypatch.setattr(table, "RESULTS", tmp_path / "results.json")
    table.RESULTS.write_text(json.dumps(committed))
    results["machine"] |= {"date": "2026-02-03", "commit": "def"}
    merged = table.updated(results, ["whole_process", "meshes"])
    assert list(merged["benchmarks"]) == ["whole_process", "meshes"] and merged["machine"] == committed["machine"]
    assert merged["benchmarks"]["meshes"] == other and merged["benchmarks"]["whole_process"]["figures"] == [FIGURE]
    assert "`whole_process` was measured on 2026-02-03, commit def" in table.machine(merged)


@pytest.mark.parametrize("changes, short", [
    ({}, False), ({"repeats": 2}, True), ({"scenes": ["one"]}, True), ({"scenes": []}, False),
])  # fmt: skip
def test_short_run_says_that_it_was_one(results, tmp_path, monkeypatch, changes, short):
    """It stands in for a full one, and must not pass for it."""
    monkeypatch.setattr(table, "RESULTS", tmp_path / "results.json")
    table.RESULTS.write_text(json.dumps(results))
    merged = table.updated(results | {"effort": EFFORT | changes}, ["whole_process"])
    assert ("in a short run" in table.machine(merged)) == short


def test_block_that_does_not_exist_is_an_error(results):
    """A misspelt name must not leave old numbers in place."""
    with pytest.raises(KeyError):
        table.filled("<!-- results: whole_process.time -->\n<!-- end of results -->", results)


def test_committed_tables_come_from_committed_results():
    """results.md is what the table maker makes of results.json, to the letter."""
    assert table.TABLES.read_text() == table.page(json.loads(table.RESULTS.read_text()))


@pytest.mark.parametrize("document", table.DOCUMENTS, ids=lambda path: path.name)
def test_numbers_in_documents_come_from_committed_results(document):
    """No document shows numbers that were measured another time."""
    if not document.exists():
        pytest.skip(f"there is no {document.name}")
    text = document.read_text()
    assert table.filled(text, json.loads(table.RESULTS.read_text())) == text
    assert text.count("<!-- results: ") == len(table.BLOCK.findall(text)), "a block has no end"


def test_committed_results_are_complete():
    """A run of a part, or a quick one, was not taken for the whole."""
    from benchmarks.__main__ import BENCHMARKS
    from benchmarks.measure import FULL

    results = json.loads(table.RESULTS.read_text())
    assert list(results["benchmarks"]) == list(BENCHMARKS)
    assert (results["effort"]["repeats"], results["effort"]["width"]) == (FULL.repeats, FULL.width)
