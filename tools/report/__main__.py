"""`python -m tools.report [PART ...]`: make the report's figures and numbers, and typeset Report/report.pdf.

Each part is a module of this package with `make(folder)`, which writes its figures into out/report/PART and returns
its numbers. They are gathered in out/report/numbers.json, from where docs/report/template.typ takes them. Parts that
are not named stay as they were made last. The same figures and numbers give the same bytes.
"""

from __future__ import annotations

import argparse
import datetime
import hashlib
import importlib
import json
import re
import shutil
import sys
import time
from pathlib import Path

from tools.hard_cases import PAGE
from tools.report.results import RESULTS, ROOT, machine

PARTS = ("basic", "intermediate", "older", "acceleration", "pathtracer", "architecture", "lanes", "error", "stability",
         "gallery", "limits")  # fmt: skip
SOURCES = Path("docs") / "report"
MADE = Path("out") / "report"
NUMBERS = "numbers.json"
MOST_PAGES = 25
MOST_BYTES = 5_000_000
ENDINGS = (".png", ".jpg", ".svg")


class ReportError(Exception):
    """The report cannot be handed in as it is; the text says why."""


def make(part: str, folder: Path) -> dict:
    """Make one part's figures in `folder`, which is emptied first, and return its numbers."""
    if folder.exists():
        shutil.rmtree(folder)
    folder.mkdir(parents=True)
    numbers = importlib.import_module(f"tools.report.{part}").make(folder)
    for key, value in numbers.items():
        if not (isinstance(value, str) or isinstance(value, list) and all(isinstance(row, list) for row in value)):
            raise ReportError(f"{part}.{key} is neither text nor rows of a table, but {value!r}")
    return numbers


def gather(root: Path, parts: dict[str, dict]) -> None:
    """Write numbers.json: what was made now, what is there from before, and where the figures lie."""
    path = root / MADE / NUMBERS
    known = json.loads(path.read_text()) if path.exists() else {}
    figures = {f"{file.parent.name}/{file.stem}": f"/{file.relative_to(root).as_posix()}"
               for file in sorted((root / MADE).glob("*/*")) if file.suffix in ENDINGS}  # fmt: skip
    numbers = {part: parts.get(part) or known.get(part) or {} for part in PARTS}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"figures": figures, **numbers}, indent=1, ensure_ascii=False) + "\n")


def typeset(root: Path = ROOT, format: str = "pdf", density: float | None = None):
    """Return the report as bytes, or with format "png" a list of pages; raises ReportError for what typst refuses."""
    import typst

    day = datetime.datetime.fromisoformat(machine("date")).replace(tzinfo=datetime.UTC)
    try:
        return typst.compile(
            str(root / SOURCES / "report.typ"), root=str(root), ignore_system_fonts=True, format=format, ppi=density,
            timestamp=day, sys_inputs={"digest": digest(root)},
        )  # fmt: skip
    except typst.TypstError as error:
        raise ReportError(f"{error.message}\n{error.diagnostic}") from None


def digest(root: Path = ROOT) -> str:
    """Return a digest of the sources and of the measurements, which the report carries among its keywords."""
    files = [*sorted((root / SOURCES).glob("*.typ")), root / SOURCES / "references.bib", RESULTS, PAGE]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


def page_count(report: bytes) -> int:
    """Return the number of pages of a PDF that typst wrote."""
    return int(re.search(rb"/Type/Pages/Count (\d+)", report)[1])


def check(pages: int, size: int) -> None:
    """Raise ReportError if the report is too long or too large."""
    if pages > MOST_PAGES:
        raise ReportError(f"the report has {pages} pages; {MOST_PAGES} are allowed")
    if size > MOST_BYTES:
        raise ReportError(f"the report has {size / 1e6:.1f} MB; {MOST_BYTES / 1e6:.0f} are allowed")


def main(arguments=None) -> int:
    """Make the parts that are named, typeset the report, and return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.report", description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", choices=[[], *PARTS], metavar="PART", help=f"{', '.join(PARTS)}")
    parser.add_argument("--only-typeset", action="store_true", help="take figures and numbers as they were made last")
    parser.add_argument("--pages", action="store_true", help="also write each page as out/report/page-NUMBER.png")
    options = parser.parse_args(arguments)
    try:
        for part in () if options.only_typeset else options.parts or PARTS:
            begun = time.monotonic()
            numbers = make(part, ROOT / MADE / part)
            gather(ROOT, {part: numbers})
            print(f"{part}: {len(numbers)} numbers, {time.monotonic() - begun:.0f} s", flush=True)
        gather(ROOT, {})
        report = typeset()
        pages = page_count(report)
        if options.pages:
            for number, page in enumerate(typeset(format="png", density=110), 1):
                (ROOT / MADE / f"page-{number:02}.png").write_bytes(page)
        check(pages, len(report))
    except ReportError as error:
        print(error, file=sys.stderr)
        return 1
    path = ROOT / "Report" / "report.pdf"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(report)
    print(f"{path}: {pages} pages, {len(report) / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
