"""The scenes that ship load without a remark, and are what they say."""

import json
from pathlib import Path

import pytest

from renderer.scene import materials, schema
from renderer.scene.loader import load, override

FOLDER = Path(__file__).resolve().parents[2] / "scenes"
SCENES = sorted(path for path in FOLDER.rglob("*.json") if path.parent.name != "meshes")
FEATURES = sorted(FOLDER.glob("features/*.json"))
COURSEWORK = ("binary_primitives", "simple_phong", "mirror_image", "scene")


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_shipped_scene_loads_without_a_remark(path):
    """Also with strict."""
    assert load(path, strict=True).warnings == ()


@pytest.mark.parametrize("name", COURSEWORK)
def test_an_original_loads_unchanged_and_ours_has_the_same_figures(coursework, name):
    """The render mode of the scene picture is ours."""
    original, ours = load(coursework / f"{name}.json", strict=True), load(FOLDER / f"{name}.json")
    assert original.warnings == ()
    assert override(original, mode=ours.description.rendermode).description == ours.description


@pytest.mark.parametrize("path", FEATURES, ids=lambda path: path.stem)
def test_a_feature_scene_is_small(path):
    """So that every check can render it; path-traced ones take many samples, and are smaller."""
    description = load(path).description
    size = (240, 160) if description.rendermode == schema.PATHTRACER else (300, 200)
    assert (description.camera.width, description.camera.height) == size


@pytest.mark.parametrize("kind", schema.SHAPE_KINDS)
def test_every_kind_of_shape_has_its_scenes(kind):
    """One for the shape, one with a texture, named after it and holding it."""
    plain = [path for path in FEATURES if path.stem.startswith(f"shape_{kind}")]
    textured = [path for path in FEATURES if path.stem == f"texture_{kind}"]
    assert plain and textured
    for path in plain + textured:
        assert kind in {shape["type"] for shape in json.loads(path.read_text())["scene"]["shapes"]}


@pytest.mark.parametrize("record", materials.BSDF_RECORDS, ids=lambda record: record.__name__)
def test_every_bsdf_has_its_scene(record):
    """Named after it and holding it."""
    name = record.__name__.lower()
    shapes = load(FOLDER / "features" / f"bsdf_{name}.json").description.scene.shapes
    assert name in {shape.material.bsdf.type for shape in shapes}


@pytest.mark.parametrize("kind", schema.LIGHT_KINDS)
def test_every_light_has_its_scene(kind):
    """Named after it and holding it."""
    lights = load(FOLDER / "features" / f"light_{kind}.json").description.scene.lightsources
    assert {light.type for light in lights} == {kind}


@pytest.mark.parametrize("name", schema.FILTERS)
def test_every_filter_has_its_scene(name):
    """Named after it."""
    assert load(FOLDER / "features" / f"filter_{name}.json").description.filter == name


@pytest.mark.parametrize("mode", [mode for mode in schema.RENDER_MODES if mode != "phong"])
def test_every_mode_has_its_scene(mode):
    """Named after it."""
    assert load(FOLDER / "features" / f"mode_{mode}.json").description.rendermode == mode
