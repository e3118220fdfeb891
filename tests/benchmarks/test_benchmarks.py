"""Every benchmark runs, at the smallest size, and finds what its tables promise; times are not judged here."""

import numpy as np
import pytest

from benchmarks import scenes, table
from benchmarks.measure import Effort

TINY = Effort(repeats=1, width=24, height=16, samples=3)


def checked(found):
    """Return the found tables after a look at what all benchmarks have in common."""
    for rows in found["tables"].values():
        assert table.table(rows).count("\n") == len(rows) + 1
    for figure in found["figures"]:
        assert figure["reached"] > 0 and (figure["least"] or figure["aim"])
    return found["tables"]


def test_whole_process_measures_the_command():
    """The stages add up to the whole, and what was asked for is judged."""
    from benchmarks import whole_process

    found = whole_process.measure(TINY, names=("scene",))
    tables = checked(found)
    assert [figure["name"] for figure in found["figures"]] == [
        "scene, whole process, warm", "scene, whole process, cold", "scene, peak memory"
    ]  # fmt: skip
    (row,), stages = tables["processes"], {row["stage"]: row["warm (s)"]["median"] for row in tables["stages"]}
    assert 20 < row["peak memory (MB)"] < 2000
    total = stages.pop("in all")
    assert sum(stages.values()) == pytest.approx(total, abs=1e-6)


def test_command_is_plain_at_the_scenes_own_size():
    """The figure that is judged is of the command that a user types."""
    from benchmarks.measure import FULL
    from benchmarks.whole_process import command

    assert command("scene", FULL, 1, "x.ppm") == ["-m", "renderer", "scenes/scene.json", "-o", "x.ppm"]
    assert command("scene", TINY, 3, "x.ppm")[5:] == ["--size", "24x16", "--samples", 3]


def test_throughput_measures_every_lit_scene():
    """The public solutions' best stand beside three scenes, and glass is measured too."""
    from benchmarks import throughput

    rows = checked(throughput.measure(TINY))["throughput"]
    assert [row["scene"] for row in rows] == ["simple_phong", "scene", "mirror_image", "scene glass"]
    assert [row["best public solution"] for row in rows] == [16.5, 3.6, 5.8, None]


def test_glass_variant_has_glass():
    """The variant differs from its scene."""
    materials = [shape.material for _, shape in scenes.load("scene glass", TINY).shapes]
    assert sum(material.isrefractive for material in materials) == 1


def test_variants_undo_one_decision_each():
    """All variants are measured, and nothing stays undone afterwards."""
    from benchmarks import variants
    from renderer.core import rows

    names = "SELECT_LIMIT", "UNROLL_LIMIT", "AXIS_VALUES", "ALL_CONSTANT"
    limits = [getattr(rows, name) for name in names]
    found = checked(variants.measure(TINY))["variants"]
    assert [row["variant"] for row in found][0::7] == ["as it is", "one lane a sample"] and len(found) == 8
    assert [getattr(rows, name) for name in names] == limits


def test_lane_per_sample_renders_the_same_picture():
    """The slower way is compared for the same result."""
    from benchmarks.variants import lane_per_sample
    from renderer.engine.render import render

    loaded = scenes.load("scene", TINY, samples=4)
    channels, expected = lane_per_sample(loaded).numpy(), render(loaded).channels()
    picture = np.stack([expected[name].ravel() for name in "RGB"])
    np.testing.assert_allclose(channels, picture, atol=1e-5)
    assert picture.std() > 0.1


def test_mitsuba_is_given_the_same_rays_and_finds_the_same():
    """At this size no ray is near enough to an edge for the two to differ."""
    from benchmarks import against_mitsuba

    for row in checked(against_mitsuba.measure(TINY))["ratios"]:
        assert row["primary rays"] == TINY.width * TINY.height and row["shadow rays"] > 0
        assert row["primary rays that differ"] == row["shadow rays that differ"] == 0


def test_disagreements_are_counted():
    """A hit on one side only, and hits at different distances, count; two misses do not."""
    from benchmarks.against_mitsuba import differing_hits

    ours = np.array([1.0, 1.0, 1e30, 1e30, 2.0], np.float32)
    theirs = np.array([1.00001, 1.01, np.inf, 3.0, np.inf], np.float32)
    assert differing_hits(ours, theirs) == 3


def test_shadow_rays_reach_their_light():
    """A ray's origin plus its distance along it is the light, and it starts on the side it faces."""
    from benchmarks.rays import primary_rays, shadow_rays
    from renderer.scene.tables import compile_camera, compile_scene

    loaded = scenes.load("simple_phong", TINY)
    primary = primary_rays(compile_camera(loaded.description.camera), TINY.width, TINY.height)
    rays = shadow_rays(compile_scene(loaded), primary)
    ends = rays.o + rays.d * rays.distance[:, None]
    lights = np.array([light.position for light in loaded.description.scene.lightsources])
    nearest = np.abs(ends[:, None] - lights).max(axis=2).min(axis=1)
    assert nearest.max() < 1e-4
    assert not rays.left_inwards.any()
