"""What the report's parts on textures, structures and the older sheet compute themselves, held to closed forms."""

import math

import numpy as np
import pytest

from benchmarks.mesh_scenes import octahedron
from renderer.accel.records import WORDS
from tools.report import acceleration, intermediate, older


def test_rays_read_the_root_and_the_leaf_that_they_hit():
    """An octahedron is four leaves below one root: a miss reads the root alone, a hit at least one leaf too."""
    vertices, faces = octahedron(1)
    geometry = intermediate.geometry_of(vertices.astype(np.float32), faces)
    assert len(geometry.structure._records) == 5 * WORDS
    o = np.array([[0.2, 0.3, 5.0], [9.0, 0.3, 5.0]], np.float32)
    records, leaves = intermediate.walked(geometry, o, np.array([[0, 0, -1.0]] * 2, np.float32))
    assert records[1] == 1 and leaves[1] == 0
    assert 1 <= leaves[0] <= 4 and records[0] == 1 + leaves[0]


def test_points_stand_for_the_lamp():
    """Together they are as bright, lie around its middle, and spread as evenly as a rectangle does."""
    lamp = {"position": [1.0, 2.0, 3.0], "u": [2.0, 0, 0], "v": [0, 0, 0.5], "intensity": [0.8, 0.4, 0.2]}
    points = older.points_of(lamp)
    places = np.array([point["position"] for point in points])
    np.testing.assert_allclose(np.sum([point["intensity"] for point in points], axis=0), lamp["intensity"])
    np.testing.assert_allclose(places.mean(0), lamp["position"])
    share = 1 - 1 / older.POINTS**2  # of a rectangle's variance that the middles of its parts have
    np.testing.assert_allclose(places.var(0), share * np.array([4, 0, 0.25]) / 12, atol=1e-12)


def test_half_of_the_lobe_is_half():
    """The closed form that the report quotes holds to the noise of its samples."""
    share = float(older.half_of_the_lobe()["lobe_share"].split()[0])
    assert share == pytest.approx(50, abs=400 * 0.5 / math.sqrt(older.WALL_SAMPLES))


def test_rows_of_what_was_tried_are_the_documents(root):
    """Every row stands in docs/acceleration.md as it is, but for marks of code."""
    text = (root / "docs" / "acceleration.md").read_text().replace("`", "")
    assert all(f"| {tried} | {brought} |" in text for tried, brought in acceleration.tried())


@pytest.mark.parametrize("count, told", [(9_800, "10,000"), (100_352, "100,000"), (1_002_528, "a million")])
def test_sizes_are_rounded(count, told):
    """Meshes are named by the power of ten that they are near to."""
    assert acceleration.round_size(count) == told
