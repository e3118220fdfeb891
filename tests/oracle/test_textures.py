"""Textures on every shape, with every filter and wrap, against Mitsuba's bitmaps and checkerboard."""

import pytest

from tests.support.documents import SHAPES, SHINY, scene, shape

pytestmark = pytest.mark.oracle

ALBEDO = ("albedo", "rgb")


def textured(**settings):
    """Return a material with the test's picture."""
    return {**SHINY, "texture": "texture.png", "scaleU": 1.7, "scaleV": 1.3, **settings}


def large(name, material):
    """Return the material with larger texels on planes, where far texels are smaller than pixels."""
    return {**material, "scaleU": 0.23, "scaleV": 0.17} if name == "plane" else material


@pytest.mark.parametrize("texture_filter", ["nearest", "bilinear"])
@pytest.mark.parametrize("name", SHAPES)
def test_texture_on_shape(agree, name, texture_filter):
    """A picture lies on each shape as the texture coordinates say."""
    agree(scene(shape(name, large(name, textured(texturefilter=texture_filter)))), ALBEDO)


@pytest.mark.parametrize("wrap", ["repeat", "clamp"])
@pytest.mark.parametrize("texture_filter", ["nearest", "bilinear"])
@pytest.mark.parametrize("name", ["triangle", "plane", "cylinder"])
def test_texture_wrap(agree, name, texture_filter, wrap):
    """Beyond 0 <= u, v <= 1 the texture repeats or its rim goes on."""
    material = large(name, textured(texturefilter=texture_filter, texturewrap=wrap))
    agree(scene(shape(name, material)), ALBEDO)


@pytest.mark.parametrize("scale", [(1.0, 1.0), (2.5, 1.0), (1.0, 0.3)])
def test_texture_scale(agree, scale):
    """scaleU and scaleV repeat the texture along u and v."""
    agree(scene(shape("sphere", textured(scaleU=scale[0], scaleV=scale[1]))), ALBEDO)


@pytest.mark.parametrize("name", SHAPES)
def test_texture_checkerboard(agree, name):
    """The checkerboard's squares lie where Mitsuba has them, also at negative uv."""
    board = {"type": "checkerboard", "scale": 3.0, "color1": [0.9, 0.8, 0.1], "color2": [0.1, 0.2, 0.7]}
    agree(scene(shape(name, {**SHINY, "texture": board, "scaleU": 1.4, "scaleV": 0.9})), ALBEDO)


def test_texture_from_inside(agree):
    """From inside a sphere the texture is seen mirrored, not moved."""
    camera = {"position": [0.1, 0.1, -0.1], "lookAt": [0.7, 0.3, 0.5], "fov": 90.0}
    agree(scene(shape("sphere", textured()), camera=camera), ALBEDO)
