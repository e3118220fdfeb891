"""Which shapes go into the structure, and that everything else about a shape stays with it wherever it goes."""

import numpy as np
import pytest

from renderer.accel.brute_force import BruteForce
from renderer.accel.bvh import Bvh
from renderer.core.rows import UNROLL_LIMIT
from renderer.engine.render import render
from renderer.scene.arrange import AUTO, MOST_BESIDE, arrange
from renderer.scene.tables import compile_scene
from tests.support.documents import write_texture
from tests.support.scenes import MATT, SHAPES, loaded
from tests.support.soups import cube, write_obj

BOUNDED = [SHAPES[kind][0] for kind in ("sphere", "cylinder", "box", "convex", "triangle")]
PLANE = SHAPES["plane"][0]
HALF_SPACE = {"type": "convex", "halfspaces": [[0, 1, 0, -1.0]]}
MESH = {"type": "mesh", "filename": "cube.obj"}


@pytest.fixture
def folder(tmp_path):
    """A directory with a mesh file of twelve triangles."""
    write_obj(tmp_path / "cube.obj", *cube())
    return tmp_path


def placed(folder, shapes, accel=AUTO):
    """Return [types inside of the structure], [types outside], and the structure."""
    ordered, fields = arrange(loaded(folder, shapes), accel)
    inside, outside = [], []
    for group in fields["shapes"]:
        (outside if group.code is None else inside).extend([group.kind.name] * group.rows.count)
    if fields["triangles"]:
        inside.append(("triangles", fields["triangles"].count))
    assert len(ordered) == fields["shape_count"] == len(loaded(folder, shapes).shapes)
    return inside, outside, fields["structure"]


def many(count):
    """Return so many bounded shapes, of all kinds in turn."""
    return [BOUNDED[k % len(BOUNDED)] for k in range(count)]


@pytest.mark.parametrize("accel", [AUTO, "none"])
def test_a_handful_is_unrolled(folder, accel):
    """Up to the limit there is no structure, triangle shapes included."""
    inside, outside, structure = placed(folder, many(UNROLL_LIMIT), accel)
    assert (inside, len(outside), structure) == ([], UNROLL_LIMIT, None)


def test_one_more_goes_into_a_hierarchy(folder):
    """All of them together."""
    inside, outside, structure = placed(folder, many(UNROLL_LIMIT + 1))
    assert outside == [] and isinstance(structure, Bvh)
    triangles = sum(shape["type"] == "triangle" for shape in many(UNROLL_LIMIT + 1))
    assert len(inside) == UNROLL_LIMIT + 1 - triangles + 1 and inside[-1] == ("triangles", triangles)


@pytest.mark.parametrize("endless", [PLANE, HALF_SPACE])
def test_what_has_no_bounds_does_not_count(folder, endless):
    """Neither for the limit, nor is it in the structure."""
    _, outside, structure = placed(folder, [*many(UNROLL_LIMIT), endless])
    assert structure is None and len(outside) == UNROLL_LIMIT + 1
    inside, outside, structure = placed(folder, [endless, *many(UNROLL_LIMIT + 1), endless])
    assert outside == [endless["type"]] * 2 and structure is not None
    assert placed(folder, [endless] * (UNROLL_LIMIT + 5))[2] is None


@pytest.mark.parametrize("count", [0, 1, 4])
def test_few_of_a_kind_stay_beside_a_mesh(folder, count):
    """Their kinds would make the test of every leaf longer."""
    inside, outside, structure = placed(folder, [*many(count), PLANE, MESH])
    assert isinstance(structure, Bvh) and len(outside) == count + 1 and [name for name, _ in inside] == ["triangles"]


def test_many_of_a_kind_go_in_beside_a_mesh(folder):
    """What is of a kind with few others stays out, the rest goes into the hierarchy."""
    inside, outside, _ = placed(folder, [*[BOUNDED[0]] * (MOST_BESIDE + 1), BOUNDED[1], MESH])
    assert outside == ["cylinder"] and inside[: MOST_BESIDE + 1] == ["sphere"] * (MOST_BESIDE + 1)
    assert "cylinder" in placed(folder, [BOUNDED[1], MESH], "bvh")[0], "asked for, everything that fits goes in"


@pytest.mark.parametrize("shapes", [[BOUNDED[0]], [BOUNDED[4]], many(5)])
def test_a_hierarchy_can_be_asked_for(folder, shapes):
    """Also for one shape."""
    inside, outside, structure = placed(folder, [*shapes, PLANE], "bvh")
    assert outside == ["plane"] and isinstance(structure, Bvh) and inside


def test_without_a_hierarchy_meshes_are_tested_one_by_one(folder):
    """The other shapes are then not among the leaves."""
    inside, outside, structure = placed(folder, [*many(40), MESH], "none")
    assert isinstance(structure, BruteForce) and inside == [("triangles", 12)] and len(outside) == 40


@pytest.mark.parametrize("accel", [AUTO, "bvh", "none"])
def test_nothing_at_all(folder, accel):
    """An empty scene has neither groups nor a structure."""
    assert placed(folder, [], accel) == ([], [], None)
    picture = render(loaded(folder, [], rendermode="binary"), accel=accel)
    assert not picture.channels()["R"].any()


@pytest.mark.parametrize("accel", ["bvh", "none"])
def test_dropped_shapes_leave_the_numbers_alone(folder, accel):
    """A degenerate triangle is not rendered; shapes after it keep their numbers of the file."""
    flat = {"type": "triangle", "v0": [0, 0, 0], "v1": [1, 1, 1], "v2": [2, 2, 2]}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 0.5}
    scene = loaded(folder, [flat, ball, flat, MESH | {"transform": [{"scale": 0.2}, {"translate": [0, 1, 0]}]}],
                   rendermode="shapes")  # fmt: skip
    assert [index for index, _ in scene.shapes] == [1, 3]
    numbers = render(scene, accel=accel).channels()["Shape"]
    assert set(np.unique(numbers)) == {1, 3, 0xFFFFFFFF}


# Forty shapes of forty colours


def colour(number):
    """Return a colour that no other number has."""
    return [(number % 5 + 1) / 8, (number // 5 % 5 + 1) / 8, (number // 25 + 1) / 8]


def wall(textured=(), colours=40):
    """Return forty shapes of five kinds and so many colours, in a mixed order on a wall of 8 by 5 cells."""
    shapes = []
    for number in np.random.default_rng(4).permutation(40).tolist():
        x, y, r = number % 8 - 3.5, number // 8 - 2.0, 0.3
        low, high = [x - r, y - r, -r], [x + r, y + r, r]
        made = [
            {"type": "sphere", "center": [x, y, 0], "radius": r},
            {"type": "cylinder", "center": [x, y, 0], "axis": [1, 2, 0], "radius": r, "height": 0.2},
            {"type": "box", "min": low, "max": high},
            {"type": "triangle", "v0": low, "v1": [x + r, y - r, 0], "v2": [x, y + r, 0]},
            {"type": "mesh", "filename": "cube.obj", "transform": [{"scale": 0.25}, {"translate": [x, y, 0]}]},
        ][number * 7 % 5]
        material = MATT | {"diffusecolor": colour(number % colours)}
        if number in textured:
            own = material["diffusecolor"]
            material["texture"] = {"type": "checkerboard", "color1": own, "color2": own}
        shapes.append((number, made | {"material": material}))
    return shapes


CAMERA = {"width": 96, "height": 60, "position": [0, 0, -6], "fov": 45.24}
STRUCTURES = ["bvh", "none", AUTO]


def cells(mode, channels, folder, shapes, accel):
    """Return the values in the middle of each shape's cell, in the shapes' order, and the whole picture."""
    scene = loaded(folder, [shape for _, shape in shapes], rendermode=mode, camera=CAMERA)
    picture = render(scene, accel=accel).channels()
    values = np.stack([picture[name] for name in channels], -1)
    numbers = np.array([number for number, _ in shapes])
    # +x is to the right and row 0 at the top; a cell is 12 pixels
    return values[(4 - numbers // 8) * 12 + 6, numbers % 8 * 12 + 6], values


@pytest.mark.parametrize("accel", STRUCTURES)
@pytest.mark.parametrize("textured", [(), range(0, 40, 3)], ids=["plain", "textured"])
@pytest.mark.parametrize("colours", [40, 7])
def test_materials_stay_with_their_shapes(folder, accel, textured, colours):
    """Every one of forty shapes shows its own colour, in its material or a texture, alone or shared with others."""
    shapes = wall(textured, colours)
    seen, _ = cells("albedo", ("Albedo.R", "Albedo.G", "Albedo.B"), folder, shapes, accel)
    assert np.array_equal(seen, np.float32([colour(number % colours) for number, _ in shapes]))


@pytest.mark.parametrize("accel", STRUCTURES)
def test_numbers_stay_with_their_shapes(folder, accel):
    """Each cell shows the place in the file of the shape there."""
    seen, _ = cells("shapes", ("Shape",), folder, wall(), accel)
    assert np.array_equal(seen[:, 0], np.arange(40))


@pytest.mark.parametrize("mode, channels", [("shapes", ("Shape",)), ("albedo", ("Albedo.R", "Albedo.G", "Albedo.B"))])
def test_pictures_agree(folder, mode, channels):
    """Pixel by pixel, but for outlines within rounding: triangles are tested in another way in a structure."""
    first, second = (cells(mode, channels, folder, wall(), accel)[1] for accel in ("bvh", "none"))
    assert (first != second).any(-1).mean() <= 1e-3


# Tables of looks


def test_looks_are_kept_once(folder):
    """Many shapes of three materials need three records."""
    shapes = [shape | {"material": MATT | {"kd": (k % 3) / 4}} for k, shape in enumerate(many(40))]
    scene = compile_scene(loaded(folder, shapes))
    assert scene.materials.count == 3 and scene.looks.count == 40


def test_texture_and_colour_together_make_a_look(folder):
    """Shapes that share one of the two do not share the record."""
    texture = {"texture": write_texture(folder / "t.png").name}
    materials = [MATT, MATT | texture, MATT | {"kd": 0.1} | texture, MATT | {"kd": 0.1}]
    shapes = [shape | {"material": materials[k % 4]} for k, shape in enumerate(many(40))]
    scene = compile_scene(loaded(folder, shapes))
    assert (scene.materials.count, scene.texture.rows.count, scene.looks.count) == (4, 4, 40)


def test_a_few_shapes_have_a_table_of_their_own(folder):
    """It is read faster than through their places."""
    scene = compile_scene(loaded(folder, many(5)))
    assert scene.looks is None and scene.materials.count == 5


def test_different_looks_need_no_places(folder):
    """As many looks as shapes: the places would say nothing."""
    scene = compile_scene(loaded(folder, [shape for _, shape in wall()]))
    assert scene.looks is None and scene.materials.count == 40
