"""What only several keys together can show."""

import pytest

from renderer.core.errors import SceneError
from renderer.scene.loader import from_dict

PYRAMID = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
CUBE_SIDES = [[1, 0, 0, 1], [-1, 0, 0, 1], [0, 1, 0, 1], [0, -1, 0, 1], [0, 0, 1, 1], [0, 0, -1, 1]]


def with_shape(document, shape, **options):
    """Return the loaded scene of one shape."""
    document["scene"]["shapes"] = [shape]
    return from_dict(document, **options)


DEGENERATE = {
    "collinear triangle": {"type": "triangle", "v0": [0, 0, 0], "v1": [1, 1, 1], "v2": [3, 3, 3]},
    "triangle of one point": {"type": "triangle", "v0": [2, 2, 2], "v1": [2, 2, 2], "v2": [2, 2, 2]},
    "needle": {"type": "triangle", "v0": [0, 0, 0], "v1": [1e6, 0, 0], "v2": [0, 1e-9, 0]},
    "flat box": {"type": "box", "min": [0, 0, 0], "max": [1, 0, 1]},
    "coplanar vertices": {"type": "convex", "vertices": [[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1], [5, 2, 1]]},
    "collinear vertices": {"type": "convex", "vertices": [[0, 0, 0], [1, 1, 1], [2, 2, 2], [3, 3, 3]]},
    "equal vertices": {"type": "convex", "vertices": [[4, 4, 4]] * 4},
    "disjoint half-spaces": {"type": "convex", "halfspaces": [[1, 0, 0, -1], [-1, 0, 0, -1]]},
    "half-spaces that touch": {"type": "convex", "halfspaces": [[0, 2, 0, 6], [0, -1, 0, -3]]},
    "touching at the origin": {"type": "convex", "halfspaces": [[0, 1, 0, 0], [0, -1, 0, 0], [1, 0, 0, 5]]},
    "cut-off cube": {"type": "convex", "halfspaces": [*CUBE_SIDES, [1, 1, 1, -3.5]]},
}
SOUND = {
    "small triangle": {"type": "triangle", "v0": [0, 0, 0], "v1": [1e-6, 0, 0], "v2": [0, 1e-6, 0]},
    "thin triangle": {"type": "triangle", "v0": [0, 0, 0], "v1": [1, 0, 0], "v2": [0.5, 1e-4, 0]},
    "thin box": {"type": "box", "min": [0, 0, 0], "max": [1, 1e-4, 1]},
    "tetrahedron": {"type": "convex", "vertices": PYRAMID},
    "half-space": {"type": "convex", "halfspaces": [[0, 1, 0, 0]]},
    "cube": {"type": "convex", "halfspaces": CUBE_SIDES},
    "far slab": {"type": "convex", "halfspaces": [[0, 1, 0, 1000], [0, -1, 0, -999.5]]},
    "cube with a corner cut": {"type": "convex", "halfspaces": [*CUBE_SIDES, [1, 1, 1, -2.5]]},
    "wedge off the origin": {"type": "convex", "halfspaces": [[1, 0, 0, -5], [-1, -1, 0, 20], [0, 1, 0, -8]]},
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_a_shape_without_extent_is_dropped_with_a_warning(document, name):
    """It leaves the index of the others as in the file."""
    document["scene"]["shapes"].insert(1, DEGENERATE[name])
    loaded = from_dict(document)
    assert [index for index, _ in loaded.shapes] == [0, 2, 3, 4, 5, 6]
    (warning,) = loaded.warnings
    assert (warning.key_path, warning.message[:8]) == ("scene.shapes[1]", "dropped:")


@pytest.mark.parametrize("name", DEGENERATE)
def test_strict_refuses_a_shape_without_extent(document, name):
    """With strict nothing is left out."""
    with pytest.raises(SceneError, match="dropped"):
        with_shape(document, DEGENERATE[name], strict=True)


@pytest.mark.parametrize("name", SOUND)
def test_a_small_or_thin_shape_is_kept(document, name):
    """Only what has no extent in 32-bit floats is dropped."""
    loaded = with_shape(document, SOUND[name])
    assert (len(loaded.shapes), loaded.warnings) == (1, ())


LIGHT_INSIDE = {
    "sphere": {"type": "sphere", "center": [9, 9, -8], "radius": 2},
    "cylinder": {"type": "cylinder", "center": [9, 8, -9], "axis": [0, 3, 0], "radius": 1, "height": 2},
    "box": {"type": "box", "min": [8, 8, -10], "max": [10, 10, -8]},
    "half-spaces": {"type": "convex", "halfspaces": [[1, 0, 0, 10], [-1, 0, 0, -8], [0, 1, 0, 10]]},
    "vertices": {"type": "convex", "vertices": [[8, 8, -10], [12, 8, -10], [8, 12, -10], [8, 8, -5]]},
}
LIGHT_OUTSIDE = {
    "sphere": {"type": "sphere", "center": [9, 9, -6], "radius": 2.9},
    "cylinder beside": {"type": "cylinder", "center": [9, 8, -7], "axis": [0, 3, 0], "radius": 1.9, "height": 2},
    "cylinder below": {"type": "cylinder", "center": [9, 6, -9], "axis": [0, 3, 0], "radius": 1, "height": 2.9},
    "box": {"type": "box", "min": [8, 8, -8.9], "max": [10, 10, -8]},
    "half-spaces": {"type": "convex", "halfspaces": [[1, 0, 0, 8.9]]},
    "vertices": {"type": "convex", "vertices": [[8, 8, -10], [9.8, 8, -10], [8, 9.8, -10], [8, 8, -8]]},
    "plane": {"type": "plane", "point": [0, 10, 0], "normal": [0, 1, 0]},
}


@pytest.mark.parametrize("name", LIGHT_INSIDE)
def test_a_light_inside_a_closed_shape_is_told(document, name):
    """Such a light is a common riddle."""
    (warning,) = with_shape(document, LIGHT_INSIDE[name]).warnings
    assert warning.key_path == "scene.lightsources[0].position"
    assert "is inside scene.shapes[0]" in warning.message


@pytest.mark.parametrize("name", LIGHT_OUTSIDE)
def test_a_light_outside_is_no_remark(document, name):
    """Near is not inside."""
    assert with_shape(document, LIGHT_OUTSIDE[name]).warnings == ()


def test_an_empty_scene_renders_its_background(document):
    """No shapes are no mistake, not even with strict."""
    document["scene"]["shapes"] = []
    (warning,) = from_dict(document, strict=True).warnings
    assert warning.message == "has no shapes; only the background is rendered"


def test_a_phong_scene_without_lights_is_told(document):
    """It would be flat."""
    document["scene"]["lightsources"] = []
    (warning,) = from_dict(document).warnings
    assert "no lightsources" in warning.message
    assert from_dict(document, mode="binary").warnings == ()


def test_a_missing_texture_is_told_with_the_path_tried(document, tmp_path):
    """The path shows relative to what it was looked for; one file named twice is told once."""
    for index in (0, 3):
        document["scene"]["shapes"][index]["material"] = {"texture": "no/such.png"}
    with pytest.raises(SceneError) as caught:
        from_dict(document, directory=tmp_path)
    (problem,) = caught.value.problems
    assert problem.key_path == "scene.shapes[0].material.texture"
    assert problem.message == f"texture 'no/such.png': no such file (tried {tmp_path / 'no/such.png'})"


@pytest.mark.parametrize("name", ["x" * 3000, "\ud800.png", "..", "."])
def test_an_impossible_texture_name_is_told(document, tmp_path, name):
    """Names that the system refuses, or that are folders, are no traceback, and can be printed."""
    document["scene"]["shapes"][0]["material"] = {"texture": name}
    with pytest.raises(SceneError) as caught:
        from_dict(document, directory=tmp_path)
    str(caught.value).encode("utf-8")


@pytest.mark.parametrize(("written", "lies"), [
    ("a.ppm", "a.ppm"), ("a.ppm", "textures/a.ppm"), ("pictures\\a.ppm", "pictures/a.ppm"),
])
def test_textures_are_found_where_scenes_in_circulation_keep_them(document, tmp_path, written, lies):
    """Beside the scene, in a folder `textures`, and with backslashes."""
    (tmp_path / lies).parent.mkdir(exist_ok=True)
    (tmp_path / lies).write_bytes(b"P6 1 1 255\n000")
    document["scene"]["shapes"][0]["material"] = {"texture": written}
    loaded = from_dict(document, directory=tmp_path)
    assert loaded.resolve(written) == tmp_path / lies
