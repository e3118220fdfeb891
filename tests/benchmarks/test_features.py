"""What features cost: both sides of each are what they say, and costs are of the right sign and size."""

import json
import statistics

import pytest

from benchmarks import feature_patches, feature_scenes, features, features_worker, table
from benchmarks.feature_scenes import SCENES, document, folder, is_path_traced
from benchmarks.features_worker import HAVING, WITHOUT, Ours
from benchmarks.measure import Effort
from renderer.integrators import path, phong
from renderer.scene import loader
from renderer.scene.compiled import CompiledScene

TINY, SAMPLES = (12, 8), 3
SHEETS = {"basic", "intermediate", "pathtracer", "older"}


def loaded(feature, side):
    """Return a side's LoadedScene."""
    return loader.from_dict(document(feature, side, TINY, SAMPLES), directory=folder(feature))


@pytest.mark.parametrize("key", SCENES)
def test_sides_differ(key):
    """Each loads, and differs from its other side in the document, in a patch or in the structure."""
    feature = SCENES[key]
    sides = [(document(feature, side, TINY, SAMPLES), side.patch, side.accel)
             for side in (feature.having, feature.without)]  # fmt: skip
    assert sides[0] != sides[1] and key.split(".")[0] in SHEETS
    for side in (feature.having, feature.without):
        assert loaded(feature, side).shapes
        assert side.patch in feature_patches.PATCHES
    assert is_path_traced(feature) == key.startswith("pathtracer.") or key == "pathtracer.samples_phong"


def test_every_kind_of_bsdf_and_light_is_measured():
    """Kinds are those of the registries: a new one has to find its place here; `diffuse` is what others are beside."""
    from renderer.bsdfs import KINDS as BSDFS
    from renderer.lights import KINDS as LIGHTS

    measured = {key.partition(".")[2] for key in SCENES}
    assert {f"bsdf_{kind}" for kind in BSDFS} - measured == {"bsdf_diffuse"}
    assert {f"light_{kind}" for kind in LIGHTS} <= measured


@pytest.mark.parametrize("patch, owner, name", [
    ("no shadows", CompiledScene, "occluded"), ("no highlight", phong, "highlight"), ("lights alone", path, "_weight"),
])  # fmt: skip
def test_patches_are_undone(patch, owner, name):
    """Also where a class only inherits what is replaced."""
    before = getattr(owner, name), name in vars(owner)
    with feature_patches.patched(patch):
        assert getattr(owner, name) is not before[0]
    assert (getattr(owner, name), name in vars(owner)) == before


@pytest.mark.parametrize("key", ["basic.camera", "basic.phong", "basic.highlight", "basic.shadows", "pathtracer.mis"])
def test_patches_leave_code_out(key):
    """A patch that changed nothing would be told as a feature without cost."""
    operations = {}
    for name, side in ((HAVING, SCENES[key].having), (WITHOUT, SCENES[key].without)):
        made = document(SCENES[key], side, TINY, SAMPLES)
        operations[name] = Ours(made, folder(SCENES[key]), side).compiled()["operations"]
    assert operations[HAVING] > 1.01 * operations[WITHOUT]


def test_added_shapes_are_never_seen():
    """They lie behind the camera: what is measured is their test alone."""
    from renderer.engine.render import render

    for key in ("basic.cylinder", "older.convex", "older.plane"):
        having, without = (render(loaded(SCENES[key], side)).rgb8()
                           for side in (SCENES[key].having, SCENES[key].without))  # fmt: skip
        assert having == without and len(set(having)) > 3


def test_cost_is_the_difference_of_a_piece():
    """Of what is added four times, the cost of one; ratios are of the whole."""
    found = {HAVING: {"ns": [10.0, 12.0, 11.0], "compile": 0.2, "operations": 9},
             WITHOUT: {"ns": [2.0, 4.0, 2.0], "compile": 0.1, "operations": 5}}  # fmt: skip
    row = features.row("basic.sphere", SCENES["basic.sphere"], found)
    assert row["cost (ns a sample)"] == {"median": 2.0, "min": 2.0, "max": 2.25}
    assert row["time, x without"]["median"] == 5.0 and row["Mitsuba's, x without"] is None


def test_recording_is_subtracted(monkeypatch):
    """Of half a second for a million samples, two tenths are recording."""
    times = lambda actions, repeats: {key: [0.2 if key[1] else 0.5] * repeats for key in actions}
    monkeypatch.setattr(features_worker, "interleaved", times)

    class Picture:
        def render(self, small=False):
            return 1_000_000

    (spent,) = features_worker._each_sample({"it": Picture()}, 3).values()
    assert statistics.median(spent) == pytest.approx(300.0)


@pytest.mark.oracle
def test_features_are_measured_in_a_process(monkeypatch):
    """One of mode phong and one that Mitsuba has, at the smallest size; then what is done once a picture."""
    keys = ("basic.shadows", "pathtracer.lens")
    found = features.measure(Effort(repeats=1, width=40, height=30, samples=4, scenes=keys))["tables"]
    assert [row["feature"] for row in found["features"]] == list(keys) and not found["pictures"]
    assert table.table(found["features"]).count("\n") == len(keys) + 1
    assert found["features"][0]["Mitsuba with, x ours"] is None and found["features"][1]["Mitsuba with, x ours"]
    assert all(row["compile with (s)"] > 0.005 for row in found["features"]), "kernels came from a cache"
    assert json.dumps(found)


def test_pictures_are_measured():
    """Every tone curve, and every format of files."""
    rows = features.pictures(Effort(repeats=1, width=24, height=16, samples=1))
    expected = [f"basic.tonemap_{curve}" for curve in features.CURVES]
    expected += [f"basic.image_{end}" for end in ("ppm", "png", "exr")]
    assert {row["feature"] for row in rows} == set(expected)
    assert all(row["CPU ns a pixel"]["median"] > 0 for row in rows)


def test_families_are_all_that_there_is():
    """Every key once."""
    assert sum(map(len, feature_scenes.FAMILIES)) == len(SCENES) > 50
