"""Debug modes against closed forms; the oracle compares their pictures."""

import numpy as np
import pytest

from renderer.engine.render import render
from tests.support.scenes import MATT, loaded

BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": MATT}
PANEL = {"type": "box", "min": [-9, -9, 2], "max": [0, 9, 3], "material": MATT | {"diffusecolor": [0.1, 0.2, 0.3]}}
CENTRE = (6, 8)  # row, column of a pixel that sees the ball


def channels(tmp_path, mode, shapes=(PANEL, BALL)):
    """Return the raw channels of a debug mode in which the ball is shape 1 of the file."""
    return render(loaded(tmp_path, shapes, rendermode=mode)).channels()


def test_depth_is_measured_along_the_ray(tmp_path):
    """The panel's depth grows towards the corner like the length of the ray, not like z."""
    depth = channels(tmp_path, "depth")["Z"]
    assert depth[CENTRE] == pytest.approx(3, abs=0.02)
    step = 2 * np.tan(np.radians(20)) / 12
    x, y = -7.5 * step, 5.5 * step
    assert depth[0, 0] == pytest.approx(6 * np.sqrt(1 + x * x + y * y), rel=1e-6)
    assert depth[0, 15] == np.float32(1e30), "nothing there"


def test_normals_point_outwards(tmp_path):
    """Also where the viewer is inside: the mode shows the shape, not the shading."""
    n = channels(tmp_path, "normals")
    assert n["N.Z"][CENTRE] == pytest.approx(-1, abs=0.01)
    inside = channels(tmp_path, "normals", [BALL | {"radius": 10}])
    assert inside["N.Z"][CENTRE] == pytest.approx(1, abs=0.01)
    assert inside["N.X"][6, 0] < 0 < inside["N.X"][6, 15], "screen x is world x here"


def test_shape_numbers_are_those_of_the_file(tmp_path):
    """Not those of the compiled order, which goes by kind; a miss is the greatest number."""
    picture = channels(tmp_path, "shapes")["Shape"]
    assert picture.dtype == np.uint32
    assert picture[CENTRE] == 1 and picture[0, 0] == 0 and picture[0, 15] == 0xFFFFFFFF


def test_albedo_is_the_diffuse_colour_without_kd(tmp_path):
    """What a texture or diffusecolor gives, before any weight."""
    albedo = channels(tmp_path, "albedo")
    assert [albedo[f"Albedo.{c}"][CENTRE] for c in "RGB"] == pytest.approx([0.8, 0.5, 0.25])
    assert [albedo[f"Albedo.{c}"][0, 0] for c in "RGB"] == pytest.approx([0.1, 0.2, 0.3])
    assert albedo["Albedo.R"][0, 15] == 0


@pytest.mark.parametrize("mode", ["depth", "normals", "uv", "albedo", "shapes", "binary", "phong"])
def test_an_empty_scene_renders(tmp_path, mode):
    """Nothing to hit is a picture too, in every mode."""
    picture = render(loaded(tmp_path, (), rendermode=mode))
    pixels = np.frombuffer(picture.rgb8(), np.uint8)
    assert pixels.size == 3 * 16 * 12
    assert np.all(pixels == (64 if mode == "phong" else 0))


@pytest.mark.parametrize("mode", ["depth", "normals", "uv", "albedo", "shapes"])
def test_pictures_of_debug_modes_tell_shapes_from_nothing(tmp_path, mode):
    """Each mode's 8-bit picture is black exactly where nothing is hit, at least on average."""
    pixels = np.frombuffer(render(loaded(tmp_path, (PANEL, BALL), rendermode=mode)).rgb8(), np.uint8)
    pixels = pixels.reshape(12, 16, 3)
    assert not pixels[0, 15].any() and pixels[CENTRE].any() and pixels[0, 0].any()
