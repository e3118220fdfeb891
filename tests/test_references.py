"""Sources that code and report name are in the bibliography, and nothing else is."""

import re

CITATION = re.compile(r"\[([A-Z][A-Za-z]+[12][0-9]{3})\b[^\]]*\]")
IN_REPORT = re.compile(r"@([A-Z][A-Za-z]+[12][0-9]{3})\b")


def cited(root):
    """Return {key: first file that names it} over the code and the report."""
    found = {}
    for folder in ("renderer", "converters", "benchmarks", "tools"):
        for path in sorted((root / folder).rglob("*.py")):
            for key in CITATION.findall(path.read_text()):
                found.setdefault(key, path)
    for path in sorted((root / "docs" / "report").glob("*.typ")):
        for key in IN_REPORT.findall(path.read_text()):
            found.setdefault(key, path)
    return found


def listed(root):
    """Return the keys of the bibliography, in its order."""
    return re.findall(r"^@\w+\{(\w+),", (root / "docs/report/references.bib").read_text(), re.MULTILINE)


def test_every_cited_source_is_listed(root):
    """A formula's source can be looked up."""
    assert len(cited(root)) > 5
    assert not {key: path for key, path in cited(root).items() if key not in listed(root)}


def test_every_listed_source_is_cited(root):
    """The bibliography does not boast, and is sorted."""
    assert set(listed(root)) == set(cited(root))
    assert listed(root) == sorted(listed(root))
