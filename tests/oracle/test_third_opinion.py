"""Mitsuba's counterpart against a float64 numpy renderer: is the oracle itself right?

When the renderer and Mitsuba disagree, these tell which of them to doubt first.
"""

import pytest

from tests.oracle.conftest import GEOMETRY
from tests.support import oracle as sides
from tests.support import twin
from tests.support.compare import Mismatch
from tests.support.documents import GLASS, GROUND, MIRROR, SHAPES, SHINY, changed, scene, shape, write_texture

pytestmark = pytest.mark.oracle

BALL = {"type": "sphere", "center": [-1.2, 0.1, -0.5], "radius": 0.5, "material": MIRROR}
TEXTURED = {**SHINY, "texture": "texture.png", "scaleU": 0.4, "scaleV": 0.3}


def both(folder, document):
    """Return Mitsuba's view of a document, and the twin's pictures."""
    write_texture(folder / "texture.png")
    loaded = sides.prepare(sides.write(folder, document), 150, 100)
    return sides.Oracle(loaded), twin.render(loaded)


@pytest.mark.parametrize("name", SHAPES)
def test_oracle_of_shape_agrees_with_float64(tmp_path, name):
    """Mitsuba's stand-in of each shape, textured, is the shape that the formulas describe."""
    oracle, pictures = both(tmp_path, scene(shape(name, TEXTURED), GROUND))
    for picture in (*GEOMETRY, "rgb"):
        oracle.check(picture, pictures[picture])


@pytest.mark.parametrize("material", [MIRROR, GLASS])
@pytest.mark.parametrize("name", SHAPES)
def test_oracle_of_mirror_and_glass_agrees_with_float64(tmp_path, name, material):
    """Reflection, refraction and Fresnel agree with recursion in float64."""
    oracle, pictures = both(tmp_path, scene(shape(name, material), BALL, GROUND, nbounces=3))
    oracle.check("rgb", pictures["rgb"])


def test_twin_is_refused_for_a_wrong_scene(tmp_path):
    """The twin is compared as strictly as the renderer: one percent of kd is found."""
    document = scene(shape("sphere"), GROUND)
    oracle, _ = both(tmp_path, document)
    _, wrong = both(tmp_path, changed(document, "scene.shapes.0.material.kd", lambda kd: 1.01 * kd))
    with pytest.raises(Mismatch):
        oracle.check("rgb", wrong["rgb"])
