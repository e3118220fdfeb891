"""Phong mode: ambient, diffuse, highlight and hard shadows against the exact counterpart in Mitsuba."""

import pytest

from tests.support.documents import GROUND, LIGHTS, SHAPES, SHINY, WHITE, scene, shape

pytestmark = pytest.mark.oracle

RGB = ("rgb",)


def test_mode_binary(agree):
    """Binary mode is red exactly where Mitsuba hits something."""
    agree(scene(shape("cylinder"), shape("triangle"), mode="binary"), RGB)


def test_phong_ambient(agree):
    """Without lights only the ambient term times diffusecolor is left."""
    agree(scene(shape("sphere"), GROUND, lights=(), ambientlight=[0.3, 0.5, 0.1]), RGB)


def test_phong_diffuse(agree):
    """Lambert's term does not fall off with distance."""
    agree(scene(shape("sphere", WHITE), GROUND, lights=[([40.0, 60.0, -50.0], [0.8, 0.7, 0.6])]), RGB)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 7.0, 40.0, 400.0])
def test_phong_highlight(agree, exponent):
    """The highlight follows (N.H)^e, also where e is 0."""
    agree(scene(shape("sphere", {**SHINY, "specularexponent": exponent, "ks": 0.8}), GROUND), RGB)


def test_phong_no_highlight_where_light_is_behind(agree):
    """A light behind a lone triangle adds nothing, highlight included."""
    agree(scene(shape("triangle", {**SHINY, "specularexponent": 0.0}), lights=[([0.2, 0.3, 3.0], [1, 1, 1])]), RGB)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_shadow_of_several_lights(agree, count):
    """Each light casts its own hard shadow."""
    more = ([0.0, 5.0, 0.5], [0.2, 0.1, 0.3]), ([-4, 1, 2], [0.1, 0.1, 0.0]), ([3, 0.5, 3], [0.0, 0.2, 0.1])
    lights = [*LIGHTS, *more]
    agree(scene(shape("box"), GROUND, lights=lights[:count]), RGB)


@pytest.mark.parametrize("name", [n for n in SHAPES if n != "plane"])
def test_shadow_of_shape(agree, name):
    """Each kind of shape throws its shadow on the ground."""
    high = {"position": [0, 2.5, -4.5]}
    agree(scene(shape(name), GROUND, lights=[([1.0, 3.0, -0.6], [0.9, 0.8, 0.7])], camera=high), RGB)


def test_shadow_of_plane(agree):
    """An infinite plane between light and shape darkens all of it."""
    wall = {"type": "plane", "point": [2, 0, 0], "normal": [1, 0.2, 0], "material": WHITE}
    agree(scene(shape("sphere"), wall, lights=[([3.5, 1.0, 0.0], [1, 1, 1]), ([-1, 2, -2], [0.3, 0.3, 0.3])]), RGB)


def test_shadow_not_of_shapes_beyond_the_light(agree):
    """A shape behind the light casts no shadow."""
    behind = {"type": "sphere", "center": [1.0, 3.0, -0.6], "radius": 0.5, "material": WHITE}
    agree(scene(shape("box"), behind, GROUND, lights=[([0.6, 1.6, -0.5], [0.9, 0.8, 0.7])]), RGB)
