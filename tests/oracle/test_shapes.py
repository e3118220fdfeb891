"""Each shape seen by our renderer and by Mitsuba: hits, depth, outward normal, uv, albedo, shape number, colour."""

import pytest

from tests.support.documents import GROUND, SHAPES, SHINY, WHITE, scene, shape

pytestmark = pytest.mark.oracle

BOARD = {"type": "checkerboard", "scale": 4.0, "color1": [0.9, 0.2, 0.1], "color2": [0.1, 0.6, 0.9]}
CHECKER = {**SHINY, "texture": BOARD}


def test_shape_sphere(agree):
    """A sphere is where Mitsuba has it, with longitude around +y and latitude from the top."""
    agree(scene(shape("sphere"), GROUND))


def test_shape_triangle(agree):
    """A triangle is where Mitsuba has it, with interpolated uv."""
    agree(scene(shape("triangle"), GROUND))


def test_shape_triangle_from_behind(agree):
    """A triangle is lit from both sides, and its normal stays that of its winding."""
    agree(scene({**shape("triangle"), "v1": SHAPES["triangle"]["v2"], "v2": SHAPES["triangle"]["v1"]}, GROUND))


def test_shape_cylinder(agree):
    """A capped cylinder of a tilted axis is where Mitsuba has a tube and two disks."""
    agree(scene(shape("cylinder"), GROUND))


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -2, 0], [-0.3, 0.1, 1.2], [0.02, 0.9, 0.43]])
def test_shape_cylinder_of_any_axis(agree, axis):
    """Aligned, reversed and tilted axes of any length give the same cylinder as in Mitsuba."""
    agree(scene({**shape("cylinder", CHECKER), "axis": axis}, GROUND))


def test_shape_plane(agree):
    """An infinite tilted plane is where Mitsuba has a very large disk."""
    agree(scene(shape("plane")))


def test_shape_plane_from_below(agree):
    """A plane seen from behind is lit as from the front, with its own outward normal."""
    agree(scene({**shape("plane", CHECKER), "normal": [-0.1, -1.3, 0.25]}, lights=[([0, 2, -3], [1, 1, 1])]))


def test_shape_box(agree):
    """An axis-aligned box is where Mitsuba has a mesh of twelve triangles, with uv on each face."""
    agree(scene(shape("box"), GROUND))


def test_shape_box_from_the_other_side(agree):
    """The three faces hidden from the usual camera agree too."""
    agree(scene(shape("box", CHECKER), camera={"position": [-2.2, -1.7, 3.4]}))


def test_shape_convex_from_halfspaces(agree):
    """A convex volume given by half-spaces is where Mitsuba has the mesh of its facets."""
    agree(scene(shape("convex_halfspaces"), GROUND))


def test_shape_convex_from_vertices(agree):
    """A convex volume given by vertices is where Mitsuba has the mesh of their hull."""
    agree(scene(shape("convex_vertices"), GROUND))


@pytest.mark.parametrize("name", [n for n in SHAPES if n not in ("triangle", "plane")])
def test_camera_inside_a_shape(agree, name):
    """From inside, the same surface is seen, with outward normals, lit on the inner side."""
    camera = {"position": [0.1, 0.1, -0.1], "lookAt": [0.7, 0.3, 0.5], "fov": 90.0}
    agree(scene(shape(name), camera=camera, lights=[([0.0, 0.15, 0.05], [1.0, 0.9, 0.8])]))


def test_overlapping_shapes_nearest_first(agree):
    """Where shapes overlap, the nearest surface is seen."""
    every = [shape(name, {**WHITE, "diffusecolor": [0.1 * k, 0.5, 1 - 0.1 * k]}) for k, name in enumerate(SHAPES)]
    agree(scene(*every, GROUND))
