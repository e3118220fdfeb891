"""The reference page and the JSON Schema say what the loader does."""

import json
from pathlib import Path

import jsonschema
import pytest

from renderer.core.errors import SceneError
from renderer.scene import reference, schema
from renderer.scene.loader import from_dict

DOCS = Path(__file__).resolve().parents[2] / "docs"
SCENES = sorted(path for path in (DOCS.parent / "scenes").rglob("*.json") if path.parent.name != "meshes")


@pytest.mark.parametrize(("name", "made"), [
    ("scene-format.md", reference.reference_page), ("scene.schema.json", reference.schema_json),
])
def test_the_committed_page_is_the_generated_one(name, made):
    """`python -m renderer.scene.reference` writes both anew."""
    assert (DOCS / name).read_text(encoding="utf-8") == made()


def test_every_record_and_key_is_on_the_page():
    """A new kind cannot be forgotten."""
    page = reference.reference_page()
    kinds = {record.node for table in (schema.SHAPE_KINDS, schema.LIGHT_KINDS) for record in table.values()}
    assert kinds <= set(reference.RECORDS)
    for record in reference.RECORDS:
        for name in record.keys:
            assert f"| `{name}` |" in page


def test_the_smallest_file_of_the_page_loads():
    """The example is not made up."""
    example = reference.HEAD.split("```json")[1].split("```")[0]
    assert len(from_dict(json.loads(example), strict=True).shapes) == 1


def judged(document):
    """Return what the committed schema has against a document, in a library's opinion."""
    rules = json.loads((DOCS / "scene.schema.json").read_text(encoding="utf-8"))
    return [str(error) for error in jsonschema.Draft202012Validator(rules).iter_errors(document)]


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_the_schema_accepts_every_shipped_scene(path):
    """An editor shows no false mistakes."""
    assert judged(json.loads(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize(("path", "value"), [
    (("scene", "shapes", 0, "radius"), -1), (("scene", "shapes", 0, "raduis"), 1), (("camera", "fov"), 180),
    (("scene", "shapes", 0, "type"), "sphre"), (("rendermode",), "phng"), (("camera", "position"), [1, 2]),
    (("scene", "shapes", 5, "halfspaces"), [[1, 0, 0, 1]]), (("samples",), 0), (("samples",), 1.5),
])
def test_the_schema_refuses_what_the_loader_refuses(document, path, value):
    """Both come from the same declarations."""
    assert judged(document) == []
    place = document
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    assert judged(document)
    with pytest.raises(SceneError):
        from_dict(document, strict=True)
