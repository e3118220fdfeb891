"""Every scene file against Mitsuba: the coursework's originals, ours, and the smallest scene of each feature."""

from pathlib import Path

import numpy as np
import pytest
from skimage.metrics import structural_similarity

from renderer.engine.render import render
from tests.oracle.conftest import GEOMETRY
from tests.support import oracle as sides
from tests.support.compare import NO_SHAPE

pytestmark = pytest.mark.oracle

SCENES = Path(__file__).resolve().parents[2] / "scenes"
COURSEWORK = ("binary_primitives", "simple_phong", "scene", "mirror_image")
FEATURES = sorted(
    path.stem for path in (SCENES / "features").glob("*.json") if '"pathtracer"' not in path.read_text()
)
SIZE = 300, 200  # the proportions of the originals


def compare(path, width, height, names, **settings):
    """Demand agreement of the named pictures of a scene file; return (different, uncertain) pixels of the mask."""
    loaded = sides.prepare(path, width, height, **settings)
    oracle = sides.oracle(loaded)
    assert oracle.hit.any(), "an empty picture shows nothing"
    counts = [oracle.check(name, sides.observe(loaded, name)) for name in names]
    return counts[0]


@pytest.mark.parametrize("mode", ["binary", "phong"])
@pytest.mark.parametrize("name", COURSEWORK)
def test_coursework_original(coursework, name, mode):
    """The coursework's own file gives Mitsuba's picture in both modes; masks differ by rounding at silhouettes only.

    In binary_primitives some pixel centres lie exactly on a slanted edge of the triangle, and rounding decides.
    """
    different, uncertain = compare(coursework / f"{name}.json", *SIZE, ("shape", "rgb"), mode=mode)
    assert different <= uncertain <= 0.0015 * SIZE[0] * SIZE[1]


@pytest.mark.parametrize("name", COURSEWORK)
def test_coursework_geometry(name):
    """Hits, depth, normals, texture coordinates, albedo and shape numbers of our four scenes agree."""
    compare(SCENES / f"{name}.json", *SIZE, GEOMETRY)


@pytest.mark.parametrize("name", COURSEWORK)
def test_coursework_picture(name):
    """Our scene files give Mitsuba's picture in their own mode."""
    compare(SCENES / f"{name}.json", *SIZE, ("shape", "rgb"))


@pytest.mark.parametrize("name", FEATURES)
def test_feature(name):
    """The smallest scene of a feature agrees in everything that the camera sees."""
    compare(SCENES / "features" / f"{name}.json", 180, 120, (*GEOMETRY, "rgb"), mode="phong")


@pytest.mark.parametrize("name", COURSEWORK)
def test_coursework_pictures_look_the_same(name):
    """What a person sees, 8 bits after tone mapping, is structurally the same; a shift by one pixel would be seen."""
    loaded = sides.prepare(SCENES / f"{name}.json", 600, 400)
    rendering = render(loaded)
    ours = np.frombuffer(rendering.rgb8(), np.uint8).reshape(400, 600, 3)
    radiance = sides.oracle(loaded).reference["rgb"] * (loaded.description.camera.exposure / 0.1)
    theirs = np.uint8(255 * np.clip(radiance, 0, 1) + 0.5)
    assert similarity(ours, theirs) > 0.9995
    assert similarity(ours, np.roll(theirs, 1, axis=1)) < 0.9995


def similarity(one, other):
    """Return the mean structural similarity of two 8-bit pictures."""
    return structural_similarity(one, other, channel_axis=-1)


def test_every_feature_has_a_scene():
    """The folder of smallest scenes is found, so that the tests above are not silently empty."""
    assert len(FEATURES) > 20


def test_binary_primitives_at_full_size(coursework):
    """At 1200 x 800 both sides hit as many pixels as the published picture, and differ on the slanted edge only."""
    loaded = sides.prepare(coursework / "binary_primitives.json", 1200, 800)
    oracle, ours = sides.Oracle(loaded), sides.observe(loaded, "shape")
    different, uncertain = oracle.check("shape", ours)
    assert different <= uncertain < 300
    for count in (oracle.hit.sum(), (ours != NO_SHAPE).sum()):
        assert 326_700 <= count <= 326_850
