"""`python -m tests.stability [WORD ...]`: measure the hard cases whose names have the words, print the table.

With `--write` all are measured and docs/stability.md is made.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent.parent / "docs" / "stability.md"
INTRODUCTION = """# Numerical stability on hard cases

Made by `python -m tests.stability --write`; `pytest tests/stability` judges the same cases.

Each case is one hard input, or many of them. *Ours* is what the renderer computes, *naive* the textbook's formula in
the same precision, *Mitsuba* what Mitsuba {mitsuba} answers on the same input, where it can be asked. Errors are taken
against closed forms, the same formula in double precision, or exact arithmetic. Of each: the worst error, then the
mean. `ulp` is the spacing of float32 numbers at the exact value, `share` the part of the answers that is wrong.
"""
HEAD = ("case", "unit", "allowed", "ours", "naive", "Mitsuba")


def main(arguments=None):
    """Measure, print or write, and return the exit status: 1 where a bound is broken."""
    parser = argparse.ArgumentParser(prog="python -m tests.stability", allow_abbrev=False,
                                     description="Measure numerical stability on hard cases.")
    parser.add_argument("words", nargs="*", metavar="WORD", help="only cases with one of these in their names")
    parser.add_argument("--write", action="store_true", help=f"measure all and write {PAGE.name}")
    options = parser.parse_args(arguments)
    from tests.stability import modules

    wanted = [(name, about, [case for case in cases if options.write or _has(case, options.words)])
              for name, about, cases in modules()]
    page = text(wanted)
    if options.write:
        PAGE.write_text(page)
    print(page)
    cases = [case for _, _, cases in wanted for case in cases]
    broken = [case.name for case in cases if not case.found["ours"].worst <= case.allowed]
    print(*(f"beyond its bound: {name}" for name in broken), sep="\n", file=sys.stderr)
    return 1 if broken else 0


def _has(case, words):
    """Return whether a case's name has one of the words, or none is asked for."""
    return not words or any(word.lower() in case.name.lower() for word in words)


def text(parts):
    """Return the page of [(module, docstring, cases)]."""
    import mitsuba

    lines = [INTRODUCTION.format(mitsuba=mitsuba.__version__)]
    for _, about, cases in parts:
        if cases:
            title, _, rest = about.partition("\n")
            lines += [f"## {title.rstrip('.')}", rest.strip(), _table(cases), _notes(cases)]
    return "\n\n".join(line.strip() for line in lines if line.strip()) + "\n"


def _table(cases):
    """Return the table of cases, in Markdown."""
    rows = [HEAD, ["---"] * len(HEAD)]
    for case in cases:
        sides = (_errors(case.found[side]) for side in ("ours", "naive", "mitsuba"))
        rows.append((case.name, case.unit, short(case.allowed), *sides))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _notes(cases):
    """Return what each bound comes from, which naive formula was taken, and what is to say of Mitsuba.

    Cases of which the same is to be said share a line.
    """
    named = {}
    for case in cases:
        said = f"{case.because}. Naive: {case.naive_name}." + (f" Mitsuba: {case.remark}." if case.remark else "")
        named.setdefault(said, []).append(f"*{case.name}*")
    return "\n".join(f"- {'; '.join(names)}: {said}" for said, names in named.items())


def _errors(found):
    """Return the worst error and the mean one as text."""
    return "-" if found is None else f"{short(found.worst)}, {short(found.mean)}"


def short(value):
    """Return a number with two significant digits."""
    if not math.isfinite(value):
        return "infinite"
    return f"{value:.2g}" if value == 0 or 1e-3 <= value < 1e4 else f"{value:.1e}"


if __name__ == "__main__":
    from renderer.core import llvm

    llvm.prepare()
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault("DRJIT_CACHE_DIR", folder)
        sys.exit(main())
