"""FeatureList.txt says what is so: its pictures, scenes and tests exist, and nothing that exists is missing."""

import ast
import re
from pathlib import Path

import pytest

from renderer.scene.materials import BSDF
from renderer.scene.schema import DEBUG_MODES, FILTERS, LIGHT_KINDS, SAMPLERS, SHAPE_KINDS, TONEMAPS

ENTRY = re.compile(r"^(?P<name>\S.*)\n((?:    \w+: .*\n)+)", re.MULTILINE)
DEMONSTRATED, MISSING = "implemented and demonstrated", "not implemented"
SCENES = Path(__file__).resolve().parent.parent / "scenes" / "features"


def entries(text):
    """Return [(name, {field: value})] of a feature list."""
    found = []
    for match in ENTRY.finditer(text):
        found.append((match["name"], dict(re.findall(r"^    (\w+): +(.*)$", match[2], re.MULTILINE))))
    return found


def complaints(name, fields, root):
    """Return what is not so about one entry."""
    wrong = []
    if fields.get("status") == MISSING:
        return wrong if set(fields) == {"status"} else [f"{name}: not implemented, and yet shown"]
    if fields.get("status") != DEMONSTRATED or set(fields) != {"status", "picture", "scene", "test"}:
        return [f"{name}: needs status, picture, scene and test"]
    wrong += [f"{name}: no {fields[kind]}" for kind in ("picture", "scene") if not (root / fields[kind]).is_file()]
    path, _, function = fields["test"].partition("::")
    function, _, case = function.rstrip("]").partition("[")
    if not (root / path).is_file() or function not in functions(root / path) or case and not has(root / path, case):
        wrong.append(f"{name}: no test {fields['test']}")
    return wrong


def has(path, case):
    """Return whether a file of tests names a case, or takes the scenes among which it is."""
    text = path.read_text()
    numbered = re.fullmatch(r"(\w+_)(\d+)", case)  # named by a format string
    return (f'"{case}"' in text or 'glob("*.json")' in text and (SCENES / f"{case}.json").is_file()
            or numbered is not None and f'"{numbered[1]}{{' in text and numbered[2] in text)


def functions(path):
    """Return the names of the functions in a Python file."""
    return {node.name for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.FunctionDef)}


@pytest.fixture(scope="module")
def listed(root):
    """The entries of the file that is handed in."""
    return entries((root / "FeatureList.txt").read_text())


def test_every_entry_is_so(listed, root):
    """Pictures, scenes and tests are there."""
    assert len(listed) > 40
    assert not [wrong for name, fields in listed for wrong in complaints(name, fields, root)]


def test_every_line_belongs_to_an_entry(root):
    """A misspelt entry does not slip through the pattern."""
    text = (root / "FeatureList.txt").read_text()
    assert len(re.findall(r"^    status: ", text, re.MULTILINE)) == len(entries(text))


def test_every_feature_scene_is_listed(listed, root):
    """Each smallest scene shows a listed feature; of the textured and the plain shapes one a kind suffices."""
    scenes = {fields.get("scene") for _, fields in listed}
    missing = {f"scenes/features/{path.name}" for path in (root / "scenes/features").glob("*.json")} - scenes
    named = re.compile(r"(shape|texture|mode|material|tonemap)_\w+|shadow")
    assert not [path for path in missing if not named.search(path)]


def test_every_kind_is_listed(listed):
    """What a scene file can name and the renderer has is in the list, by scene or by name."""
    text = " ".join(name.lower() + " " + fields.get("scene", "") for name, fields in listed)
    for kind in (*SHAPE_KINDS, *TONEMAPS, *LIGHT_KINDS, *BSDF.kinds, *FILTERS, *SAMPLERS):
        assert kind in text, kind
    assert len([name for name, _ in listed if name.startswith("Debug mode")]) == len(DEBUG_MODES)


SOUND = {"status": DEMONSTRATED, "picture": "TestSuite/simple_phong.ppm", "scene": "scenes/scene.json",
         "test": "tests/io/test_image.py::test_ppm_is_the_plainest_form"}  # fmt: skip


@pytest.mark.parametrize("spoilt", [
    {"status": "done"}, {"picture": "TestSuite/nothing.ppm"}, {"scene": "scenes/nothing.json"},
    {"test": "tests/io/test_image.py::test_nothing"}, {"test": "tests/oracle/test_paths_bsdfs.py::test_bsdf[nothing]"},
    {"test": "tests/oracle/test_paths_scenes.py::test_scene[bounces_77]"}, {"test": "tests/nothing.py::test_nothing"},
    {"status": MISSING},
])  # fmt: skip
def test_a_false_entry_is_found(spoilt, root):
    """The check has teeth."""
    assert not complaints("sound", SOUND, root)
    assert complaints("spoilt", SOUND | spoilt, root)
