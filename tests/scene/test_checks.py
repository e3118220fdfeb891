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


def test_a_misspelt_texture_is_told_with_its_neighbour(document, tmp_path):
    """The name that was meant is often in the same folder."""
    (tmp_path / "globe.png").write_bytes(b"")
    document["scene"]["shapes"][0]["material"] = {"texture": "glob.png"}
    with pytest.raises(SceneError) as caught:
        from_dict(document, directory=tmp_path)
    assert "no such file, did you mean 'globe.png'? (tried " in caught.value.problems[0].message


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


def with_light(document, light, mode="pathtracer", **options):
    """Return the loaded scene of one light."""
    document["scene"]["lightsources"] = [light]
    return from_dict(document | {"rendermode": mode}, **options)


SPOT = {"type": "spot", "position": [0, 5, -5], "direction": [0, -1, 1], "intensity": [1, 1, 1]}
SUN = {"type": "directional", "direction": [0, -1, 1], "intensity": [1, 1, 1]}
AREA = {"type": "arealight", "position": [9, 9, -9], "u": [1, 0, 0], "v": [0, 0, 1], "intensity": [1, 1, 1]}
DISK = {"type": "disklight", "position": [9, 9, -9], "normal": [0, -1, 0], "radius": 1, "intensity": [1, 1, 1]}


@pytest.mark.parametrize(("light", "key", "message"), [
    (SPOT | {"direction": [0, 0, 0]}, "direction", "needs a direction"),
    (SPOT | {"cutoff": 20, "beamwidth": 21}, "beamwidth", "must not be greater than cutoff, which is 20"),
    (SUN | {"direction": [0, 0, 0]}, "direction", "needs a direction"),
    (AREA | {"u": [0, 0, 0]}, "u", "needs two edges"),
    (AREA | {"u": [0, 0, -2]}, "v", "must not be parallel to u"),
    (DISK | {"normal": [0, 0, 0]}, "normal", "needs a direction"),
])
def test_a_light_without_direction_or_extent_is_refused(document, light, key, message):
    """At its key."""
    with pytest.raises(SceneError) as caught:
        with_light(document, light)
    (problem,) = caught.value.problems
    assert problem.key_path == f"scene.lightsources[0].{key}" and message in problem.message


@pytest.mark.parametrize("light", [SPOT | {"cutoff": 20, "beamwidth": 20}, SPOT, SUN, AREA, DISK])
def test_a_sound_light_is_no_remark(document, light):
    """Whatever its kind."""
    assert with_light(document, light, strict=True).warnings == ()


@pytest.mark.parametrize(("shape", "key"), [
    ({"type": "rectangle", "center": [0, 0, 0], "u": [0, 0, 0], "v": [1, 0, 0]}, "u"),
    ({"type": "rectangle", "center": [0, 0, 0], "u": [1, 1, 0], "v": [-2, -2, 0]}, "v"),
    ({"type": "disk", "center": [0, 0, 0], "normal": [0, 0, 0], "radius": 1}, "normal"),
])
def test_a_sheet_without_direction_or_extent_is_refused(document, shape, key):
    """At its key."""
    with pytest.raises(SceneError) as caught:
        with_shape(document, shape)
    assert [problem.key_path for problem in caught.value.problems] == [f"scene.shapes[0].{key}"]


@pytest.mark.parametrize("mode", ["phong", "pathtracer"])
@pytest.mark.parametrize("light", [SPOT | {"position": [0, 0, 0]}, AREA | {"position": [0, 0, 0]},
                                   DISK | {"position": [0, 0, 0]}], ids=["spot", "arealight", "disklight"])
def test_any_light_inside_a_closed_shape_is_told(document, light, mode):
    """But in path-traced scenes light gets out of glass."""
    document["scene"]["shapes"] = [document["scene"]["shapes"][0]]
    document["samples"] = 4
    (warning,) = with_light(document, light, mode).warnings
    assert (warning.key_path, warning.is_note) == ("scene.lightsources[0].position", True)
    document["scene"]["shapes"][0]["material"] = {"bsdf": {"type": "dielectric"}, "isrefractive": mode == "phong"}
    told = [w.key_path for w in with_light(document, light, mode).warnings]
    assert ("scene.lightsources[0].position" in told) == (mode == "phong")


def test_only_one_environment_is_around(document, tmp_path):
    """The second one is refused, and each file is looked for."""
    sky = {"type": "environment", "filename": "sky.hdr"}
    document["scene"]["lightsources"] = [sky, sky, sky]
    with pytest.raises(SceneError) as caught:
        from_dict(document, directory=tmp_path)
    told = {problem.key_path: problem.message for problem in caught.value.problems}
    assert told.keys() == {"scene.lightsources[1]", "scene.lightsources[0].filename"}
    assert "environment 'sky.hdr': no such file" in told["scene.lightsources[0].filename"]


@pytest.mark.parametrize(("material", "where"), [
    ({"bsdf": {"type": "diffuse", "reflectance": "no.png"}}, "bsdf.reflectance"),
    ({"bsdf": {"type": "principled", "metallic": "no.png"}}, "bsdf.metallic"),
    ({"normalmap": "no.png"}, "normalmap"), ({"bumpmap": "no.png"}, "bumpmap"),
    ({"texture": "no.png", "bsdf": {"type": "mirror"}}, "texture"),
])
@pytest.mark.parametrize("mode", ["phong", "pathtracer"])
def test_every_file_of_a_material_is_looked_for(document, tmp_path, material, where, mode):
    """In every mode, because a mistake is one."""
    document["scene"]["shapes"][2]["material"] = material
    with pytest.raises(SceneError) as caught:
        from_dict(document | {"rendermode": mode}, directory=tmp_path)
    assert [problem.key_path for problem in caught.value.problems] == [f"scene.shapes[2].material.{where}"]


def test_a_board_cannot_reflect_more_than_it_gets(document):
    """Its colours are those of anything, where it is a reflectance they are not."""
    board = {"type": "checkerboard", "color1": [0, 0, 1.5]}
    document["scene"]["shapes"][0]["material"] = {"texture": board}
    assert from_dict(document).warnings == ()
    document["scene"]["shapes"][0]["material"] = {"bsdf": {"type": "diffuse", "reflectance": board}}
    with pytest.raises(SceneError, match="must not be greater than 1"):
        from_dict(document)


@pytest.mark.parametrize(("camera", "key"), [
    ({"apertureRadius": 0.1}, "apertureRadius"), ({"type": "thinlens"}, "type"),
    ({"type": "thinlens", "apertureRadius": 0.1}, None), ({"focusDistance": 3}, None),
])
def test_a_lens_that_does_nothing_is_told(document, camera, key):
    """A pinhole has none, and one of radius 0 is a pinhole."""
    document["camera"] |= camera
    assert [w.key_path for w in from_dict(document).warnings] == ([f"camera.{key}"] if key else [])


def test_a_light_of_no_power_is_told(document):
    """It costs time."""
    notes = with_light(document, AREA | {"intensity": [0, 0, 0]}).warnings
    assert [w.key_path for w in notes] == ["scene.lightsources[0]", "scene"]
    assert "intensity is 0" in notes[0].message and "nothing gives light" in notes[1].message


@pytest.mark.parametrize("change", [
    {"lightsources": [SUN]}, {"backgroundcolor": [0, 0, 0.1]},
    {"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "emission": [1, 0, 0]}]},
], ids=["light", "background", "emission"])
def test_a_path_traced_scene_without_light_is_told(document, change):
    """Any light will do."""
    document["scene"]["lightsources"] = []
    document["rendermode"] = "pathtracer"
    (warning,) = from_dict(document).warnings
    assert (warning.key_path, warning.is_note) == ("scene", True) and "will be black" in warning.message
    document["scene"] |= change
    assert from_dict(document).warnings == ()


def test_what_phong_mode_leaves_out_is_told_once(document, tmp_path):
    """Emission, BSDFs and maps; an area light that one ray a pixel sees."""
    (tmp_path / "a.png").touch()
    for shape in document["scene"]["shapes"]:
        shape |= {"emission": [1, 1, 1], "material": {"bsdf": {"type": "mirror"}, "bumpmap": "a.png"}}
    document["scene"]["lightsources"] = [AREA, DISK, {"type": "environment", "filename": "a.png"}]
    told = [w.key_path for w in from_dict(document, directory=tmp_path, strict=True).warnings]
    shape = "scene.shapes[0]"
    assert sorted(told) == [
        "scene.lightsources[0]", f"{shape}.emission", f"{shape}.material.bsdf", f"{shape}.material.bumpmap",
    ]  # fmt: skip
    document |= {"rendermode": "pathtracer"}
    assert from_dict(document, directory=tmp_path).warnings == ()
