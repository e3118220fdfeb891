"""What can be read off the coursework's published pictures, at their size."""

import numpy as np
import pytest

from renderer.engine.render import render
from renderer.scene.loader import load


def pixels(path):
    """Return the 8-bit picture of a scene file, (height, width, 3)."""
    picture = render(load(str(path)))
    return np.frombuffer(picture.rgb8(), np.uint8).reshape(picture.height, picture.width, 3)


@pytest.fixture(scope="module")
def hits(root):
    """Where binary_primitives is hit."""
    return pixels(root / "scenes/binary_primitives.json")[..., 0] == 255


def extent(hits, axis):
    """Return the first and the last row (axis 1) or column (axis 0) in which anything is hit."""
    return tuple(np.flatnonzero(hits.any(axis))[[0, -1]])


def test_binary_primitives_hits_as_many_pixels_as_published(hits):
    """326,700 to 326,850 of 960,000."""
    assert hits.size == 960_000 and 326_700 <= hits.sum() <= 326_850


def test_binary_primitives_shapes_lie_where_published(hits):
    """The view is mirrored against world x: cylinder and sphere on the left, the triangle on the right."""
    left, right = hits[:, :560], hits[:, 560:]
    sphere = left[:335]  # above the cylinder
    assert extent(left, 0)[0] == 32, "cylinder's first column"
    assert extent(hits[410:, :], 0) == (32, 515), "cylinder's columns"
    assert extent(sphere, 0) == (92, 503) and extent(sphere, 1)[0] == 8, "sphere's columns and first row"
    assert tuple(560 + np.array(extent(right, 0))) == (600, 1081), "triangle's columns"
    assert extent(right, 1) == (159, 399), "triangle's rows"


def test_background_and_shadow_values(root):
    """The background of 0.25 is 64 of 255; shadows are 0.4 times the diffuse colour, (0.5, 0.8, 0.5) on the floor."""
    picture = pixels(root / "scenes/simple_phong.json").reshape(-1, 3)
    colours, counts = np.unique(picture, axis=0, return_counts=True)
    common = set(map(tuple, colours[counts > 5000].tolist()))
    assert {(64, 64, 64), (51, 82, 51)} <= common
