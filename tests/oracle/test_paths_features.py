"""The smallest scene of every feature of mode `pathtracer`, as it is in the folder, against Mitsuba."""

from dataclasses import replace
from pathlib import Path

import pytest

from renderer.scene.loader import load, override
from tests.support.paths import ours, theirs
from tests.support.stats import P_LEAST, compare, demand_equal

pytestmark = pytest.mark.oracle

FOLDER = Path(__file__).resolve().parents[2] / "scenes" / "features"
SCENES = sorted(path.stem for path in FOLDER.glob("*.json") if '"pathtracer"' in path.read_text())
SIZE, SAMPLES = (36, 24), 128
EDGE = 2  # pixels: nearer to it, wide filters lack samples in Mitsuba
HORIZON = {"material_bumpmap": 5, "material_normalmap": 5}  # rows dropped: far away Mitsuba's plane has no map
BOUND = 0.02  # the features by themselves are bounded more tightly, in the other modules


@pytest.mark.parametrize("name", SCENES)
def test_scene_file(name):
    """The scene file's picture has Mitsuba's expectation."""
    loaded = flat_lights(override(load(FOLDER / f"{name}.json"), width=SIZE[0], height=SIZE[1]))
    pictures = (side(loaded, SAMPLES)[:, HORIZON.get(name, EDGE):-EDGE, EDGE:-EDGE] for side in (ours, theirs))
    if "filter" in name:  # whose tails bring a sample to a dark pixel so rarely that most such pixels have none
        verdict = compare(*pictures)
        assert verdict.coarse_p >= P_LEAST and verdict.bound < BOUND, verdict
    else:
        demand_equal(*pictures, bound=BOUND)


def flat_lights(loaded):
    """Return the scene with flat shading of meshes that shine: by vertex normals Mitsuba decides which side does."""
    shapes = tuple((k, replace(shape, normals="flat") if shape.type == "mesh" and max(shape.emission) > 0 else shape)
                   for k, shape in loaded.shapes)
    return replace(loaded, shapes=shapes)


def test_scenes_are_found():
    """The folder is where it is looked for."""
    assert len(SCENES) > 15
