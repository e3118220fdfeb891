"""What the README says is done: its commands run, its steps render, its figures were measured, its files are there."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.table import RESULTS
from renderer.core import llvm
from renderer.scene.loader import from_dict
from scenes import making
from tools import guide, hard_cases

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```sh\n(.*?)^```(?:\n+```text\n(.*?)^```)?", TEXT, re.DOTALL | re.MULTILINE)
MAKE = [line for block, _ in BLOCKS for line in block.splitlines() if line.startswith("make ")]
SCRIPTS = [(block, told) for block, told in BLOCKS if not block.startswith("make ")]
STEPS = guide.steps(TEXT)
SMALL = 60, 40  # pixels of pictures here, and one sample a pixel where the commands do not say more
CORNER = 8  # rows of such a picture in which the page has the number of the step
LIMIT = 240  # seconds for a block of commands
SQUARE = 4  # pixels of such a picture along the sides of squares that are compared: their means have less noise
SAME = 0.1  # of 1, greatest difference of a square: noise, and white that is cut off before or after averaging
TOOLS = {"python": '"$@"', "mitsuba": '-c "from mitsuba.cli import _main; import sys; sys.exit(_main())" "$@"'}


def preceding_steps(block):
    """Return how many steps of the guide come before a block of commands."""
    return TEXT[: TEXT.index(block)].count("```json\n")


def as_typed(count):
    """Return the file of whoever has followed the first steps, its picture made small."""
    text = guide.written(TEXT)[0] if count == 1 else making.text(STEPS[count - 1])
    return text.replace('"width": 600, "height": 400', '"width": {}, "height": {}'.format(*SMALL))


@pytest.fixture
def checkout(tmp_path):
    """A folder like a checkout after `make test`, whose scenes make small pictures."""
    scenes, tools = tmp_path / "scenes", tmp_path / ".venv/bin"
    scenes.mkdir()
    (tmp_path / "mine").mkdir()
    tools.mkdir(parents=True)
    for path in (ROOT / "scenes").iterdir():
        if path.suffix != ".json":
            (scenes / path.name).symlink_to(path)
            continue
        document = json.loads(path.read_text(encoding="utf-8"))
        document["camera"] |= dict(zip(("width", "height"), SMALL))
        (scenes / path.name).write_text(json.dumps(document | {"samples": 1}), encoding="utf-8")
    for name, arguments in TOOLS.items():
        (tools / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {arguments}\n')
        (tools / name).chmod(0o755)
    (tmp_path / ".venv" / llvm.RECORD).write_text(f"{llvm.prepare()}\n")
    return tmp_path


def run(script, folder):
    """Run lines of the README in a folder and return what came of it; the first that fails ends them."""
    return subprocess.run(["bash", "-ec", script], cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}, text=True,
                          timeout=LIMIT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip


@pytest.mark.parametrize("script, told", SCRIPTS, ids=[block.splitlines()[-1][:60] for block, _ in SCRIPTS])
def test_commands_run(script, told, checkout):
    """They write the files that they name, and print what is shown below them."""
    count = preceding_steps(script)
    if count:
        (checkout / "mine/scene.json").write_text(as_typed(count), encoding="utf-8")
    done = run(script, checkout)
    if told:
        assert done.stdout == told
        return
    assert done.returncode == 0, done.stdout
    for name in re.findall(r" -o (\S+)", script):
        assert (checkout / name).stat().st_size > 0


def test_failing_commands_are_noticed(checkout):
    """Also those before the last."""
    assert run(".venv/bin/python -m renderer nowhere.json\ntrue", checkout).returncode == 2


@pytest.mark.parametrize("line", MAKE)
def test_make_target_exists(line):
    """Each target can be planned."""
    assert subprocess.run(["bash", "-c", f"{line.split('#')[0]} -n"], cwd=ROOT, capture_output=True).returncode == 0


def test_no_command_is_left_out():
    """Blocks are of commands that these tests run, or of targets of make."""
    assert MAKE and SCRIPTS and not any("make " in block for block, _ in SCRIPTS)
    assert len(MAKE) == sum(len(block.splitlines()) for block, _ in BLOCKS if block.startswith("make "))


@pytest.fixture(scope="module")
def shown():
    """The committed page of all steps, (height, width, 3) in [0, 1]."""
    return np.asarray(Image.open(guide.FOLDER / "steps.jpg")) / 255


def cell(page, number):
    """Return the picture of a step, from 0, on the page, as large as SMALL; the number in its corner is left out."""
    x, y = guide.place(number)
    side = guide.CELL[0] // SMALL[0]
    picture = page[y : y + guide.CELL[1], x : x + guide.CELL[0]]
    return picture.reshape(SMALL[1], side, SMALL[0], side, 3).mean((1, 3))[CORNER:]


@pytest.mark.parametrize("number", range(len(STEPS)))
def test_step_is_what_is_shown(number, shown):
    """Each step is read with strict, and its picture, alone of all steps, is that on the page."""
    samples = STEPS[number].get("samples", 16)
    picture = guide.rendered(STEPS[number], width=SMALL[0], height=SMALL[1], samples=samples)
    ours = np.asarray(picture)[CORNER:] / 255
    away = [distance(ours, cell(shown, other)) for other in range(len(STEPS))]
    assert away[number] < SAME and away[number] == min(away), away


def distance(picture, other):
    """Return the greatest difference of the means of squares of two pictures."""
    height, width, _ = picture.shape
    squares = (picture - other).reshape(height // SQUARE, SQUARE, width // SQUARE, SQUARE, 3).mean((1, 3))
    return float(np.abs(squares).max())


@pytest.mark.parametrize("number", [1, 4, 7])
def test_step_with_another_colour_is_not_what_is_shown(number, shown):
    """The red ball in blue: a page that was made before such a change is found out."""
    step = guide.grown(STEPS[number], {})
    red = {**step["scene"]["shapes"][1], "material": {"diffusecolor": [0.05, 0.1, 0.8]}}
    step["scene"] = {**step["scene"], "shapes": [step["scene"]["shapes"][0], red, *step["scene"]["shapes"][2:]]}
    changed = guide.rendered(step, width=SMALL[0], height=SMALL[1], samples=16)
    assert distance(np.asarray(changed)[CORNER:] / 255, cell(shown, number)) > 1.5 * SAME


def test_front_picture_is_that_of_the_first_command():
    """Its scene, rendered small, is what is shown on top."""
    scene = re.search(r"SCENE=(\S+)", MAKE[0])[1]
    shown = Image.open(ROOT / re.search(r"!\[.*?\]\((.*?)\)", TEXT)[1])
    front = np.asarray(shown.resize(SMALL, Image.Resampling.BOX))
    document = json.loads((ROOT / scene).read_text(encoding="utf-8"))
    picture = guide.rendered(document, width=guide.CELL[0], height=guide.CELL[1], samples=32)
    ours = np.asarray(picture.resize(SMALL, Image.Resampling.BOX))  # lanterns are cut off at white before that
    assert distance(ours / 255, front / 255) < SAME < distance(ours[:, ::-1] / 255, front / 255)


def test_page_has_a_place_for_every_step(shown):
    """Two rows of four, no more and no less."""
    assert shown.shape == (2 * guide.CELL[1] + guide.GAP, 4 * guide.CELL[0] + 3 * guide.GAP, 3) and len(STEPS) == 8


def test_last_picture_is_that_of_the_page(shown):
    """Large and small, made by one command."""
    large = Image.open(guide.FOLDER / "last.jpg").resize(guide.CELL, Image.Resampling.BOX)
    page = np.zeros_like(shown)
    x, y = guide.place(len(STEPS) - 1)
    page[y : y + guide.CELL[1], x : x + guide.CELL[0]] = np.asarray(large) / 255
    assert distance(cell(page, len(STEPS) - 1), cell(shown, len(STEPS) - 1)) < SAME / 5


@pytest.mark.parametrize("name", ["steps", "last"])
def test_pictures_are_of_these_steps(name):
    """Else `python -m tools.guide` is due: the smallest change of a step counts."""
    with Image.open(guide.FOLDER / f"{name}.jpg") as picture:
        assert picture.info["comment"].decode() == guide.digest(STEPS)


def test_steps_grow():
    """Shapes come after those of the step before; what is asked for by number is what is rendered."""
    counts = [len(step["scene"]["shapes"]) for step in STEPS]
    assert counts == sorted(counts) and counts[0] == 1 and counts[-1] > counts[0]
    for step, later in zip(STEPS, STEPS[1:]):
        assert later["scene"]["shapes"][: len(step["scene"]["shapes"])] == step["scene"]["shapes"]
    for step in STEPS:
        again = from_dict(json.loads(making.text(step)), directory=guide.SCENES, strict=True)
        assert again.description == from_dict(step, directory=guide.SCENES, strict=True).description


def test_figures_of_speed_are_the_benchmarks():
    """The slowest and the fastest scene beside Mitsuba's best sampler, and a whole run of the coursework's scene."""
    benchmarks = json.loads(RESULTS.read_text(encoding="utf-8"))["benchmarks"]
    rows = benchmarks["error"]["tables"]["at equal error"]
    ratios = [row["llvm best, x Mitsuba"]["median"] for row in rows]
    said = " ".join(TEXT.split())
    assert f"between {min(ratios):.1f} and {max(ratios):.0f} times" in said and len(rows) == 12
    whole = {figure["name"]: figure["reached"] for figure in benchmarks["whole_process"]["figures"]}
    assert f"takes {whole['scene, whole process, warm']:.1f} seconds" in said


def test_figures_of_accuracy_are_those_of_the_hard_cases():
    """How many there are, and how many break the bound."""
    cases = hard_cases.read(hard_cases.PAGE.read_text(encoding="utf-8"))
    asked = [case for case in cases if case.mitsuba is not None]
    assert all(case.strain("ours") <= 1 < case.strain("naive") for case in cases)
    broken = sum(case.strain("mitsuba") > 1 for case in asked)
    said = " ".join(TEXT.split())
    assert f"in all {len(cases)} cases" in said and f"Mitsuba in {broken} of the {len(asked)} that" in said


@pytest.mark.parametrize("name", sorted(set(re.findall(r"\]\(([^)#]+)\)", TEXT) + re.findall(r"^(\w+/) ", TEXT, re.M))))
def test_named_file_is_there(name):
    """Links, pictures and the folders of the tree lead somewhere; the report's is made by a target of make."""
    assert (ROOT / name).exists()


@pytest.mark.parametrize("anchor", re.findall(r"\]\(#([^)]+)\)", TEXT))
def test_named_section_is_there(anchor):
    """Links within the page lead to headings, by GitHub's rule for their names."""
    headings = re.findall(r"^#+ (.*)$", TEXT, re.MULTILINE)
    assert anchor in {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}
