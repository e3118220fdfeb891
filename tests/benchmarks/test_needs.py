"""What a scene's kernel has, beside everything: the inert things are there, and the picture stays the same."""

import dataclasses
import json

import numpy as np
import pytest

from benchmarks import inert, needs, needs_scenes, needs_worker
from benchmarks.measure import BenchmarkError, Effort
from benchmarks.needs_worker import Picture, compiled_in
from renderer.bsdfs import KINDS as BSDFS
from renderer.lights import KINDS as LIGHTS
from renderer.scene import loader
from renderer.shapes import KINDS as SHAPES

TINY = Effort(repeats=1, width=90, height=60, samples=12)
PHONG, PATHS, OUTSIDE = "simple_phong", "Cornell box, glass and mirror", "coursework, area lights"
EVERYTHING = needs.VARIANTS[needs.WITH_MESH]


def picture(name, folder, parts):
    """Return the Picture of a scene with some parts."""
    document = needs_scenes.document(name, folder, TINY)
    return Picture(loader.from_dict(inert.with_parts(document, folder, parts), directory=folder))


def has(name, folder, parts):
    """Return {what: set of names} of what is compiled in."""
    told = compiled_in(picture(name, folder, parts))
    return {key: set(names.split(", ")) if names else set() for key, names in told.items()}


def test_scene_has_what_it_needs(tmp_path):
    """Told by the compiled scene; the document has no lens, no textures, no mirrors."""
    expected = {"mode": {"phong"}, "shapes": {"cylinder", "sphere", "triangle"}, "lights": {"pointlight"},
                "materials": {"Blinn-Phong"}, "else": set()}  # fmt: skip
    assert has(PHONG, tmp_path, ()) == expected


def test_everything_has_every_kind_in_phong_mode(tmp_path):
    """Kinds are those of the registries: a new one has to find its place here."""
    found = has(PHONG, tmp_path, EVERYTHING)
    assert found["shapes"] == (set(SHAPES) - {"triangle"}) | {"triangles"}
    assert found["lights"] == set(LIGHTS) | {"environment"}
    assert found["materials"] == {"Blinn-Phong", "mirrors", "rough mirrors", "glass"}
    assert found["else"] == {"textures", "hierarchy (Bvh)", "thinlens"}  # a picture has one camera; this one costs most
    assert len(picture(PHONG, tmp_path, EVERYTHING).scene.texture._lookups) == 3


def test_everything_has_every_kind_in_path_tracing(tmp_path):
    """Materials with all that their instances can have in a kernel."""
    scene = picture(PATHS, tmp_path, EVERYTHING).scene
    groups = {group.kind.name: set(group.has) for group in scene.scattering.groups}
    assert set(groups) == set(BSDFS)
    assert {"mirror", "glass", "blurred"} <= groups["coursework"] and len(groups["principled"]) == 6
    assert {"ggx"} <= groups["roughconductor"] and {"beckmann", "tinted"} <= groups["roughdielectric"]
    found = has(PATHS, tmp_path, EVERYTHING)
    sampled = {"sheet", "sphere", "environment", "shapes that shine"}
    assert found["lights"] == {name for name, kind in LIGHTS.items() if kind.direct} | sampled
    assert {"textures", "tangents", "roulette"} <= found["else"]


@pytest.mark.parametrize("name", needs_scenes.SCENES)
def test_every_scene_can_have_everything(name, tmp_path):
    """Without a mesh, few enough shapes that they are tested in turn, unless the scene has many itself."""
    own, full = picture(name, tmp_path, ()), picture(name, tmp_path, inert.PARTS)
    assert (own.scene.structure is None) == (full.scene.structure is None)
    assert full.scene.shape_count >= own.scene.shape_count + 8


@pytest.mark.slow
@pytest.mark.parametrize("name", [PHONG, PATHS])
def test_each_part_adds_to_the_kernel(name, tmp_path, capsys):
    """Nothing that is said to be compiled in is optimised away."""
    operations = {}
    for part, parts in needs.ALONE.items():
        document = inert.with_parts(needs_scenes.document(name, tmp_path, TINY), tmp_path, parts)
        (tmp_path / "scene.json").write_text(json.dumps(document))
        needs_worker.main(tmp_path / "scene.json")
        operations[part] = json.loads(capsys.readouterr().out)["operations"]
    own = operations.pop(needs.AS_IT_IS)
    assert own > 300 and all(more > 1.05 * own for more in operations.values()), operations


@pytest.mark.parametrize("name", [PHONG, *(pytest.param(name, marks=pytest.mark.slow) for name in (PATHS, OUTSIDE))])
def test_picture_stays_the_same(name, tmp_path):
    """Without noise up to rounding, else within it."""
    own, full = picture(name, tmp_path, ()), picture(name, tmp_path, EVERYTHING)
    assert needs.same_picture(own, full) < (0.1 if name == PHONG else 1)
    if name == PHONG:
        np.testing.assert_allclose(full.render(0), own.render(0), atol=1e-5)


def test_another_picture_is_noticed(tmp_path):
    """Here: a background that is a tenth brighter."""
    own, document = picture(PHONG, tmp_path, ()), needs_scenes.document(PHONG, tmp_path, TINY)
    document["scene"]["backgroundcolor"] = [0.275] * 3
    assert needs.same_picture(own, Picture(loader.from_dict(document))) > needs.MOST_APART


def test_measuring_ends_with_another_picture(tmp_path, monkeypatch):
    """A comparison of different pictures would be worth nothing."""
    monkeypatch.setattr(needs, "STARTS", 1)
    monkeypatch.setattr(needs, "same_picture", lambda own, other: 7.0)
    with pytest.raises(BenchmarkError, match="simple_phong, lens: another picture, 7.0 standard errors away"):
        needs.of_scene(PHONG, tmp_path, TINY, {needs.AS_IT_IS: (), "lens": ("lens",)})


def test_rows_tell_kernels_and_times(tmp_path, monkeypatch):
    """The scene as it is comes first, and is what times are multiples of."""
    monkeypatch.setattr(needs, "STARTS", 1)
    told, (own, lens) = needs.of_scene(PHONG, tmp_path, TINY, {needs.AS_IT_IS: (), "lens": ("lens",)})
    assert told["scene"] == PHONG and told["lights"] == "pointlight"
    assert own["time, x as it is"]["median"] == 1 and own["means apart"] is None
    assert lens["operations"] > own["operations"] and lens["code (kB)"] > own["code (kB)"]
    assert own["compile (s)"]["median"] > 0.01, "kernels came from a cache"


def test_only_named_scenes_are_measured(monkeypatch):
    """--scene reaches the benchmark; those that are taken apart fill another table."""
    rows = lambda name, folder, effort, variants: ({"scene": name}, [{}] * len(variants))  # noqa: E731
    monkeypatch.setattr(needs, "of_scene", rows)
    tables = needs.measure(dataclasses.replace(TINY, scenes=("scene", PHONG)))["tables"]
    assert [row["scene"] for row in tables["what is compiled in"]] == [PHONG, "scene"]
    assert (len(tables["kernels"]), len(tables["each part alone"])) == (6, 8)
