"""The report: one PDF of its sources and measurements, whose numbers come from modules, and which has both sheets."""

import importlib
import json
import re
import shutil

import numpy as np
import pytest

from renderer.scene.schema import PATHTRACER
from tests.test_feature_list import entries
from tools.report import __main__ as maker
from tools.report import older, pairs, results

SOURCES = sorted((results.ROOT / "docs" / "report").glob("*.typ"))
# what is no prose: comments, maths, code, text in quotes, labels, references, settings of the layout, lengths
NOT_PROSE = re.compile(r"""(?<!:)//.*|(?s:\$.*?\$)|`[^`]*`|"[^"\n]*"|<[\w-]+>|@[\w:-]+
    |\b(?:width|height|columns|size|inset|gutter|above|below|depth|count)\s*:\s*(?:\([^()]*\)|[\d.]+(?:pt|em|%|cm|fr)?)
    |\b[\d.]+(?:pt|em|cm|fr)\b""", re.VERBOSE)  # fmt: skip
NUMBER = re.compile(r"(?<![\w.-])(?:\d+[.,]\d+|\d{2,})(?!\w)")
# of the older sheet's entries: words that say nothing
FILLERS = {"intersection", "tests", "from", "with", "mode", "files", "phong", "infinite", "arbitrary", "texture",
           "coordinates", "accel", "ascii", "binary", "vertices"}  # fmt: skip


def typed_in(text):
    """Return the numbers in the prose of a source that look measured."""
    return NUMBER.findall(NOT_PROSE.sub(" ", without_code(text)))


def without_code(text):
    """Return a source with blocks of code (drawings) reduced to the prose in them."""
    kept, at = "", 0
    for start in re.finditer(r"^#let [^\n]*?= \{", text, re.MULTILINE):
        if start.start() < at:
            continue
        end, depth = start.end(), 1
        while depth:
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
        kept += text[at : start.start()] + " ".join(re.findall(r"\[([^\[\]]*)\]", text[start.end() : end]))
        at = end
    return kept + text[at:]


def flat_pair(loaded):
    """Return what stands for our picture and Mitsuba's in the tests: grey, and a little brighter."""
    size = loaded.description.camera.height, loaded.description.camera.width, 3
    ours, theirs = np.full(size, 0.5), np.full(size, 0.51)
    if loaded.description.rendermode != PATHTRACER:
        return pairs.Both(ours, theirs)
    noise = np.random.default_rng(1).random(size).astype(np.float32)
    return pairs.Both(ours, theirs, noise, noise + 0.01)


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    """A folder with the sources, and the figures and numbers of all parts, flat pictures in the place of renders."""
    root = tmp_path_factory.mktemp("report")
    shutil.copytree(results.ROOT / maker.SOURCES, root / maker.SOURCES)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pairs, "quick", True)
        patch.setattr(pairs, "both", flat_pair)
        patch.setattr(pairs, "alone", lambda loaded: flat_pair(loaded).ours)
        lamps = flat_pair(older._loaded(older.soft_document(), older.SOFT_SIZE, 1)).theirs
        patch.setattr(older, "of_points", lambda: lamps)
        maker.gather(root, {part: maker.make(part, root / maker.MADE / part) for part in maker.PARTS})
    return root


@pytest.fixture(scope="module")
def typeset(flat):
    """The report with flat pictures."""
    return maker.typeset(flat)


def test_report_holds_one_file(root):
    """A PDF of 25 pages or less and below 5 MB, made of the sources and measurements that are here."""
    (path,) = (root / "Report").iterdir()
    report = path.read_bytes()
    assert path.name == "report.pdf" and report.startswith(b"%PDF-")
    maker.check(maker.page_count(report), len(report))
    assert maker.digest().encode() in report, "docs/report or what it reads has changed: make report"


def test_figures_numbers_sources_and_references_are_there(typeset):
    """Typst finds every key of #num and #rows, every figure, every cited source and every label."""
    assert typeset.startswith(b"%PDF-") and maker.page_count(typeset) <= maker.MOST_PAGES


def test_same_figures_give_the_same_bytes(flat, typeset):
    """Neither date nor chance is in the file."""
    assert maker.typeset(flat) == typeset


def test_nobody_is_named(typeset):
    """The report's metadata has a title and no author."""
    assert b"<dc:title>" in typeset and b"<dc:creator>" not in typeset and b"/Author" not in typeset


@pytest.mark.parametrize("used", ['#num("basic.nothing")', '#rows("basic.nothing")', '#plot("basic/nothing.svg")',
                                  "@Nobody1900", "@fig-nothing"])  # fmt: skip
def test_what_is_missing_is_told(flat, tmp_path, used):
    """A name that nothing has made stops typesetting, with that name."""
    shutil.copytree(flat, tmp_path / "copy")
    with open(tmp_path / "copy" / maker.SOURCES / "basic.typ", "a") as source:
        source.write(f"\n{used}\n")
    with pytest.raises(maker.ReportError, match="nothing|Nobody1900"):
        maker.typeset(tmp_path / "copy")


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.stem)
def test_no_measured_number_is_typed_in(source):
    """Prose has numbers from modules only; definitions stand in maths or in code."""
    assert typed_in(source.read_text()) == []


@pytest.mark.parametrize("text, numbers", [
    ("takes 3.2 times as long", ["3.2"]), ("of 16 lanes", ["16"]), ("1,200 rays", ["1,200"]), ("some 40 %", ["40"]),
    ('#num("a.b12") of $255$ and `0.5` in P6', []), ("#trio(\"a/b\", width: 70%)[over 12 pixels]", ["12"]),
    ("#let a = {\n place(dx: 0.06cm + f(12), [over 13 {pixels}])\n}\nand 14", ["13", "14"]),
    ("// 1.5\nfive 8-bit bytes, @Walter2007", []),
])  # fmt: skip
def test_the_lint_has_teeth(text, numbers):
    """What is typed in is found; maths, code and settings are let pass."""
    assert typed_in(text) == numbers


def headings(part):
    """Return the headings of a part's source."""
    text = (results.ROOT / maker.SOURCES / f"{part}.typ").read_text()
    return re.findall(r"^=+ (.*?)(?: <[\w-]+>)?$", text, re.MULTILINE)


def sheets(root):
    """Return {sheet: names of its features} of the feature list."""
    parts = re.split(r"^(.+)\n-+\n", (root / "FeatureList.txt").read_text(), flags=re.MULTILINE)
    return {title: [name for name, _ in entries(body)] for title, body in zip(parts[1::2], parts[2::2])}


@pytest.mark.parametrize("sheet, part", [("Basic raytracer", "basic"), ("Intermediate raytracer", "intermediate"),
                                         ("Pathtracer", "pathtracer")])  # fmt: skip
def test_every_lettered_feature_has_a_section(root, sheet, part):
    """Each letter of a sheet has a section that is named as one of its features."""
    lettered = (re.match(r"(?:\((\w)\) )?(.*)", line).groups() for line in headings(part))
    found = {letter: text.lower() for letter, text in lettered}
    names = sheets(root)[sheet]
    letters = {name[1] for name in names if name.startswith("(")}
    assert letters and not letters - set(found)
    for letter in letters:
        stems = [re.split(r"[:(,]", name[4:])[0].strip().lower() for name in names if name.startswith(f"({letter})")]
        assert any(found[letter].startswith(stem) for stem in stems), (found[letter], stems)


def test_every_feature_of_the_older_sheet_is_told(root):
    """The parts on it name what is in the list."""
    text = " ".join((root / maker.SOURCES / f"{part}.typ").read_text().lower()
                    for part in ("intermediate", "acceleration", "older"))  # fmt: skip
    names = sheets(root)["Older sheet, beyond the above"]
    assert len(names) > 8
    missing = {name: [word for word in re.findall(r"[a-z]{3,}", name.lower())
                      if word not in FILLERS and word not in text]
               for name in names}  # fmt: skip
    assert not {name: words for name, words in missing.items() if words}


@pytest.mark.parametrize("pages, size", [(26, 10), (25, 5_000_001)])
def test_too_long_or_too_large_is_refused(pages, size):
    """The maker does not write what cannot be handed in."""
    maker.check(25, 5_000_000)
    with pytest.raises(maker.ReportError, match="allowed"):
        maker.check(pages, size)


def test_numbers_are_text(tmp_path, monkeypatch):
    """A module that returns a number without its unit is refused, with the key."""
    monkeypatch.setattr(importlib.import_module("tools.report.limits"), "make", lambda folder: {"speed": 3.2})
    with pytest.raises(maker.ReportError, match="limits.speed"):
        maker.make("limits", tmp_path / "limits")


def test_parts_that_are_not_made_stay(tmp_path):
    """Numbers of other parts are kept, and figures found by what is there."""
    (tmp_path / maker.MADE / "error").mkdir(parents=True)
    (tmp_path / maker.MADE / "error" / "curves.svg").touch()
    maker.gather(tmp_path, {"basic": {"a": "1"}})
    maker.gather(tmp_path, {"error": {"b": "2"}})
    made = json.loads((tmp_path / maker.MADE / maker.NUMBERS).read_text())
    assert made["basic"] == {"a": "1"} and made["error"] == {"b": "2"}
    assert made["figures"] == {"error/curves": "/out/report/error/curves.svg"}


def test_agreement_is_counted_in_levels():
    """One pixel of 100 is 20 levels off, and one is off by a single level, which does not count."""
    theirs = np.zeros((10, 10, 3))
    ours = theirs.copy()
    ours[2, 3, 1], ours[4, 4, 0] = 20 / 255, 1 / 255
    told = pairs.agreement("it", ours - theirs, pairs.Both(ours, theirs))
    assert told["it_pixels"] == "1 of 100" and told["it_apart"].startswith("1.0") and told["it_median"].startswith("0")
    assert told["it_greatest"].split() == ["20", "levels"] == told["it_high"].split()


def test_means_are_told_with_their_error():
    """Noise of a known spread: the error is that of the mean of all pixels, and the shift is found."""
    rng = np.random.default_rng(2)
    theirs = np.full((320, 480, 3), 2.0)
    ours = theirs + 0.02 + rng.normal(0, 0.5, (320, 480, 1))
    shift, error = pairs.relative_means(ours, theirs).replace("\u2212", "-").rstrip("%").split("\u00b1")
    expected = 100 / 2 * 0.5 / np.sqrt(320 * 480)
    assert float(error) == pytest.approx(expected, rel=0.1)
    assert abs(float(shift) - 1) < 4 * expected


def test_scale_of_differences_is_fixed():
    """No difference is the map's first colour; its last stands for 1/20 of white and more."""
    shown = pairs.coloured(np.array([[[0, 0, 0], [0, 0.05, 0], [0.02, 0, -1]]]))[0]
    assert shown[0].min() > 0.7 and shown[1].max() < 0.05
    assert (shown[1] == shown[2]).all()


@pytest.mark.parametrize("value, text", [(0, "0"), (0.996, "1.0"), (12.34, "12"), (1234.5, "1,200"), (0.0043, "0.0043"),
                                         (-3.21, "\u22123.2"),
                                          (2.4e-6, "2.4\u202f\u00d7\u202f10\u207b\u2076")])  # fmt: skip
def test_digits_are_as_many_as_count(value, text):
    """Two significant digits, thousands apart, small numbers with a power of ten."""
    assert results.digits(value) == text


@pytest.mark.parametrize("value, text", [(0.2, "200 ms"), (1.5, "1.5 s"), (0.9996, "1.0 s"), (2e-5, "20 \u00b5s")])
def test_times_have_the_unit_that_suits(value, text):
    """Seconds, milli- or microseconds."""
    assert results.seconds(value).split() == text.split()


def test_unknown_results_are_told():
    """A misspelt name of a figure, a table, a row or a hard case is an error."""
    for ask in (lambda: results.figure("error", "no such"), lambda: results.table("error", "no such"),
                lambda: results.row("error", "at equal error", scene="no such"),
                lambda: results.hard_case("no such"), lambda: results.table("no such", "curves")):  # fmt: skip
        with pytest.raises(KeyError, match="no such"):
            ask()


def test_no_semicolon_is_lost():
    """Right after a number, typst takes it for the end of the expression; a backslash before it shows it."""
    for path in (results.ROOT / maker.SOURCES).glob("*.typ"):
        assert not re.findall(r'#num\("[^"]*"\);', path.read_text()), path.name
