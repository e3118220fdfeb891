"""Tables in Markdown, made from results.json and from nothing else.

`python -m benchmarks.table` makes results.md anew, and the blocks of results in the documents, which begin with
`<!-- results: NAME -->` and end with `<!-- end of results -->`. NAME is `targets`, `machine` or BENCHMARK.TABLE.
"""

from __future__ import annotations

import json
import re
import sys

from benchmarks.measure import ROOT
from benchmarks.targets import Figure, number, quantity, verdict

RESULTS, TABLES = ROOT / "benchmarks" / "results.json", ROOT / "benchmarks" / "results.md"
DOCUMENTS = (*(ROOT / "docs" / f"{name}.md" for name in ("speed", "acceleration", "pathtracing")), ROOT / "README.md")
QUIET_LOAD = 0.5  # processes that ran beside the measurement, above which the tables come with a warning
POWERS_OF_TEN = ("MSE", "relative MSE", "efficiency", "error")  # columns of very small or large numbers
BLOCK = re.compile(r"(<!-- results: ([\w. ]+) -->\n).*?(<!-- end of results -->)", re.DOTALL)


def page(results):
    """Return results.md."""
    made = ("Made by `python -m benchmarks`; every number is the median of repeats, with the smallest and the largest "
            "where the two differ.")
    parts = ["# Speed and memory, measured", made, machine(results), "## Targets", targets(results)]
    for name, found in results["benchmarks"].items():
        parts += [f"## {name.replace('_', ' ').capitalize()}", found["about"]]
        for title, rows in found["tables"].items():
            parts += [f"### {title.capitalize()}", table(rows)] if len(found["tables"]) > 1 else [table(rows)]
    return "\n\n".join(parts) + "\n"


def updated(results, names):
    """Return the committed results with those of some benchmarks in the place of theirs, in the order of `names`."""
    committed = json.loads(RESULTS.read_text())
    measured = {key: results["machine"][key] for key in ("date", "commit", "load_before")}
    fewer = results["effort"]["repeats"] < committed["effort"]["repeats"] or results["effort"].get("scenes")
    measured |= {"short": True} if fewer else {}
    found = {name: one | {"measured": measured} for name, one in results["benchmarks"].items()}
    found = committed["benchmarks"] | found
    return committed | {"benchmarks": {name: found[name] for name in names if name in found}}


def machine(results):
    """Return where, when and with what effort the numbers were taken."""
    m = results["machine"]
    versions = ", ".join(f"{name} {m[name]}" for name in ("drjit", "mitsuba", "numpy") if m[name])
    told = (f"Machine: {m['cpu']}, {m['cores']} cores, {m['system']}; LLVM {m['llvm']}, Python {m['python']}, "
            f"{versions}; {m['date']}, commit {m['commit']}.")
    effort = results["effort"]
    told += (f" Pictures of {effort['width']} x {effort['height']}, {effort['samples']} samples a pixel where many are "
             f"meant, {effort['repeats']} repeats.")
    for name, found in results["benchmarks"].items():
        if "measured" in found:
            other = found["measured"]
            told += (f" `{name}` was measured on {other['date']}, commit {other['commit']}, with "
                     f"{other['load_before']} processes running when it began"
                     + (", in a short run of some scenes." if other.get("short") else "."))
    if m["load_before"] > QUIET_LOAD:
        told += f" **The machine was not quiet**: {m['load_before']} processes ran when the measurements began."
    return told


def figures(results):
    """Return all judged figures."""
    return [Figure(**figure) for found in results["benchmarks"].values() for figure in found["figures"]]


def targets(results):
    """Return the table of the judged figures."""
    rows = [
        {"figure": f.name, "reached": quantity(f.reached, f.unit), "asked": verdict(f, f.least),
         "aim": verdict(f, f.aim)}
        for f in figures(results)
    ]  # fmt: skip
    return table(rows)


def table(rows):
    """Return rows, which have the same keys, as a Markdown table."""
    if not rows:
        return "(nothing measured)"
    lines = [list(rows[0]), ["---"] * len(rows[0])] + [[cell(value, key) for key, value in row.items()] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def cell(value, column=""):
    """Return a value as text: a spread as `median (min to max)`, nothing as a dash."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value.replace("|", "\\|")
    written = "{:.2e}".format if column in POWERS_OF_TEN else number
    if isinstance(value, dict):
        median, low, high = (written(value[part]) for part in ("median", "min", "max"))
        return median if low == high else f"{median} ({low} to {high})"
    return written(value)


def filled(text, results):
    """Return a document with its blocks of results made anew. Raises KeyError for a block that does not exist."""
    return BLOCK.sub(lambda match: f"{match[1]}{_block(match[2], results)}\n{match[3]}", text)


def _block(name, results):
    """Return the content of a block."""
    if name in ("targets", "machine"):
        return {"targets": targets, "machine": machine}[name](results)
    benchmark, _, title = name.partition(".")
    return table(results["benchmarks"][benchmark]["tables"][title])


def write(results):
    """Write results.json, results.md and the documents' blocks."""
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    TABLES.write_text(page(results))
    for document in DOCUMENTS:
        if document.exists():
            document.write_text(filled(document.read_text(), results))


if __name__ == "__main__":
    sys.exit(write(json.loads(RESULTS.read_text())))
