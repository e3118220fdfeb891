"""Files of many shapes: read by a quick way that must differ from the thorough one in nothing but its speed."""

import json
import time
from pathlib import Path

import pytest

from renderer.core.errors import SceneError
from renderer.scene import checks_shapes, composed, schema
from renderer.scene.findings import NOTHING
from renderer.scene.loader import from_dict

SCENES = sorted((Path(__file__).resolve().parents[2] / "scenes").rglob("*.json"))
GREY = {"kd": 0.5, "diffusecolor": [0.5, 0.5, 0.5]}


def many(document, count):
    """Put triangles of one material in place of the document's shapes."""
    document["scene"]["shapes"] = [
        {"type": "triangle", "v0": [i, 0, 0.5], "v1": [i + 1, 0, 0], "v2": [i, 1, 0.25], "material": dict(GREY)}
        for i in range(count)]
    return document["scene"]["shapes"]


@pytest.mark.parametrize("path", [path for path in SCENES if "camera" in path.read_text()], ids=lambda path: path.stem)
def test_both_ways_read_the_same(monkeypatch, path):
    """On every scene that is here."""
    document, findings = json.loads(path.read_text()), []
    quickly = schema.SCENE.read(document, None, findings)
    monkeypatch.setattr(composed.Record, "_made", lambda record, value: NOTHING)
    schema.MATERIAL._known.clear()
    assert schema.SCENE.read(document, None, findings) == quickly
    assert not findings


def test_equal_materials_are_one_record(document):
    """Which saves the memory of a hundred thousand."""
    many(document, 3)[1]["material"]["kd"] = 0.25
    first, second, third = (shape.material for _, shape in from_dict(document).shapes)
    assert first is third and first is not second and (first.kd, second.kd) == (0.5, 0.25)


@pytest.mark.parametrize("good, bad", [(True, 1), (False, 0), (False, 0.0)])
def test_values_that_compare_equal_are_told_apart(document, good, bad):
    """A flag is no number, also after the same object with a flag was read."""
    shapes = many(document, 2)
    shapes[0]["material"]["isreflective"], shapes[1]["material"]["isreflective"] = good, bad
    with pytest.raises(SceneError, match=r"shapes\[1\].material.isreflective: must be true or false"):
        from_dict(document)


def test_remembered_materials_do_not_pile_up(document, monkeypatch):
    """There is a bound on how many are kept from one file to the next."""
    monkeypatch.setattr(composed, "MAX_SHARED", 10)
    for number, shape in enumerate(many(document, 100)):
        shape["material"]["kd"] = number
    assert [shape.material.kd for _, shape in from_dict(document).shapes] == list(range(100))
    assert len(schema.MATERIAL._known) <= 10


def test_one_mistake_among_many_is_told(document):
    """With its place, and alone."""
    many(document, 1000)[777]["v1"][2] = "up"
    with pytest.raises(SceneError) as caught:
        from_dict(document)
    assert [problem.key_path for problem in caught.value.problems] == ["scene.shapes[777].v1[2]"]


@pytest.mark.parametrize("scale", [1.0, 1e-9, 1e15])
@pytest.mark.parametrize("aspect", [1.0, 1e-3, 1e-5, 1e-6, 1.2e-7, 1e-7, 0.9e-7, 1e-9, 0.0])
@pytest.mark.parametrize("offset", [0.0, 3.0, 1e4, 3e6])
def test_no_triangle_is_kept_by_the_short_test_alone(scale, aspect, offset):
    """What it takes for a triangle, the long one does too."""
    v0, v1, v2 = ((offset * scale, y * scale, x * scale) for x, y in ((0, 0), (1, 0), (0.5, aspect)))
    findings = []
    checks_shapes._check_thin_triangle(schema.Triangle(v0=v0, v1=v1, v2=v2), None, findings)
    if findings:
        assert not checks_shapes._is_clearly_a_triangle(v0, v1, v2)
    elif aspect == 1.0 and offset < 1e3:
        assert checks_shapes._is_clearly_a_triangle(v0, v1, v2)


def test_a_hundred_thousand_triangles_load_in_seconds(document):
    """The time grows with their number, and not faster; it is 0.4 s on the machine this was written on."""
    many(document, 100_000)
    began = time.process_time()
    from_dict(document)
    assert time.process_time() - began < 5
