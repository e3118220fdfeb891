"""Bad scene files: every mistake at once, each with its place, in plain words."""

import json
import re
from decimal import Decimal

import numpy as np
import pytest

from renderer.core.errors import SceneError, UsageError
from renderer.scene.loader import MAX_REPORTED, from_dict, load

TEMPLATE = """{
  "camera": {"position": [0, 0, -5], "lookAt": [0, 0, 0]@CAMERA@},
  "scene": {
    "lightsources": [@LIGHT@],
    "shapes": [
      {"type": "sphere", "center": [0, 0, 0], "radius": 1@SPHERE@},
      @SHAPE@
    ]
  }@TOP@
}"""
LIGHT = '{"type": "pointlight", "position": [9, 9, 9], "intensity": [1, 1, 1]}'
SHAPE = '{"type": "sphere", "center": [3, 0, 0], "radius": 1}'


def text(**parts):
    """Return the template with parts filled in."""
    parts = {"CAMERA": "", "LIGHT": LIGHT, "SPHERE": "", "SHAPE": SHAPE, "TOP": ""} | parts
    return re.sub("@([A-Z]+)@", lambda match: parts[match[1]], TEMPLATE)


# (part, its text, what the message points at, key path, message): the place is that of the pointed-at text
MISTAKES = [
    ("SHAPE", '{"type": "sphere", "center": [0, 0, 0], "radius": -1}', "-1", "scene.shapes[1].radius",
     "must be greater than 0, got -1"),
    ("SHAPE", '{"type": "sphere", "center": [0, 0, 0], "radius": 0}', '0}', "scene.shapes[1].radius",
     "must be greater than 0, got 0"),
    ("SHAPE", '{"type": "sphere", "center": [0, 0, 0], "radius": 1e-30}', "1e-30", "scene.shapes[1].radius",
     "must be at least 1e-18, because its square must not vanish in a 32-bit float, got 1e-30"),
    ("SHAPE", '{"type": "sphere", "center": [0, 1e30, 0], "radius": 1}', "1e30", "scene.shapes[1].center[1]",
     "must not be beyond 1e+18 in size, because its square must fit a 32-bit float, got 1e30"),
    ("SHAPE", '{"type": "sphere", "center": [0, 1e999, 0], "radius": 1}', "1e999", "scene.shapes[1].center[1]",
     "must be a finite number, got 1e999"),
    ("SHAPE", '{"type": "sphere", "center": [0, true, 0], "radius": 1}', "true", "scene.shapes[1].center[1]",
     "must be a number, got true"),
    ("SHAPE", '{"type": "sphere", "center": [7, 8], "radius": 1}', "[7, 8]", "scene.shapes[1].center",
     "must be a point [x, y, z]: 3 numbers, got a list of 2 values"),
    ("SHAPE", '{"type": "sphere", "center": "here", "radius": 1}', '"here"', "scene.shapes[1].center",
     "must be a point [x, y, z]: 3 numbers, got the text 'here'"),
    ("SHAPE", '{"type": "sphere", "center": [3, 3, 3]}', '{"type": "sphere", "center": [3', "scene.shapes[1].radius",
     "is missing; it is a number greater than 0"),
    ("SHAPE", '{"type": "sphre"}', '"sphre"', "scene.shapes[1].type",
     "unknown shape type 'sphre', did you mean 'sphere'? "
     "(known: sphere, cylinder, triangle, plane, box, convex, rectangle, disk, mesh)"),
    ("SHAPE", '{"radius": 3}', '{"radius": 3}', "scene.shapes[1].type",
     "is missing; a shape is one of sphere, cylinder, triangle, plane, box, convex, rectangle, disk, mesh"),
    ("SHAPE", '{"type": 7}', "7", "scene.shapes[1].type",
     "must be one of sphere, cylinder, triangle, plane, box, convex, rectangle, disk, mesh, got 7"),
    ("SHAPE", "42", "42", "scene.shapes[1]", "must be a shape: an object {...}, got 42"),
    ("SHAPE", '{"type": "convex"}', '{"type": "convex"}', "scene.shapes[1]",
     "exactly one of halfspaces and vertices must be given, neither is"),
    ("SHAPE", '{"type": "convex", "halfspaces": [[1, 0, 0, 1], [0, 0, 0, 2]]}', "[0, 0, 0, 2]",
     "scene.shapes[1].halfspaces[1]", "must not have the normal [0, 0, 0]: a half-space needs a direction, "
     "got a list of 4 values"),
    ("SHAPE", '{"type": "convex", "vertices": [[1, 0, 5]]}', "[[1, 0, 5]]", "scene.shapes[1].vertices",
     "must hold at least 4 points [x, y, z], got a list of 1 value"),
    ("SHAPE", '{"type": "cylinder", "center": [0, 0, 0], "axis": [0, 0, 0.0], "radius": 1, "height": 1}',
     "[0, 0, 0.0]", "scene.shapes[1].axis", "must not be [0, 0, 0]: the cylinder needs a direction"),
    ("SHAPE", '{"type": "plane", "point": [0, 1, 0], "normal": [0.0, 0, 0]}', "[0.0, 0, 0]",
     "scene.shapes[1].normal", "must not be [0, 0, 0]: the plane needs a direction"),
    ("SHAPE", '{"type": "box", "min": [0, 2, 0.0], "max": [1, 1, 1]}', "[0, 2, 0.0]", "scene.shapes[1].min",
     "must not be greater than max in any axis; in y it is 2 against 1"),
    ("SPHERE", ', "material": {"reflectivity": 2}', "2}", "scene.shapes[0].material.reflectivity",
     "must be between 0 and 1, got 2"),
    ("SPHERE", ', "material": {"isreflective": "yes"}', '"yes"', "scene.shapes[0].material.isreflective",
     "must be true or false, got the text 'yes'"),
    ("SPHERE", ', "material": {"diffusecolor": [1, -3, 1]}', "-3", "scene.shapes[0].material.diffusecolor[1]",
     "must be at least 0, got -3"),
    ("SPHERE", ', "material": [8]', "[8]", "scene.shapes[0].material",
     "must be an object {...} with the keys of a material, got a list of 1 value"),
    ("SPHERE", ', "material": {"texture": 5}', "5}", "scene.shapes[0].material.texture",
     "must be a file name or an object with type checkerboard, got 5"),
    ("SPHERE", ', "material": {"texture": {"type": "marble"}}', '"marble"', "scene.shapes[0].material.texture.type",
     "unknown texture type 'marble' (known: checkerboard)"),
    ("SPHERE", ', "material": {"texturefilter": "bilinaer"}', '"bilinaer"', "scene.shapes[0].material.texturefilter",
     "unknown texture filter 'bilinaer', did you mean 'bilinear'? (known: nearest, bilinear)"),
    ("LIGHT", '{"type": "pointlght"}', '"pointlght"', "scene.lightsources[0].type",
     "unknown light type 'pointlght', did you mean 'pointlight'? "
     "(known: pointlight, spot, directional, arealight, disklight, environment)"),
    ("LIGHT", '{"type": "pointlight", "position": [4, 4, 4], "intensity": [1, 1, "1"]}', '"1"',
     "scene.lightsources[0].intensity[2]", "must be a number at least 0, got the text '1'"),
    ("CAMERA", ', "fov": 180', "180", "camera.fov", "must be greater than 0 and less than 180, got 180"),
    ("CAMERA", ', "fov": null', "null", "camera.fov", "must be a number greater than 0 and less than 180, got null"),
    ("CAMERA", ', "width": -300', "-300", "camera.width", "must be between 1 and 65536, got -300"),
    ("CAMERA", ', "width": 99999999999999999999', "99999999999999999999", "camera.width",
     "must be between 1 and 65536, got 99999999999999999999"),
    ("CAMERA", ', "height": 2.5', "2.5", "camera.height", "must be a whole number between 1 and 65536, got 2.5"),
    ("CAMERA", ', "width": 65536, "height": 65536', "65536", "camera.width",
     "width times height must be at most 268,435,456 pixels, got 65536 x 65536 = 4,294,967,296"),
    ("CAMERA", ', "upVector": [0, 0, 7]', "[0, 0, 7]", "camera.upVector",
     "must not be parallel to the direction of view (lookAt - position): the picture has no up then"),
    ("CAMERA", ', "upVector": [0, 0, 0.0]', "[0, 0, 0.0]", "camera.upVector",
     "must not be [0, 0, 0]: the picture needs an up direction"),
    ("CAMERA", ', "type": "fisheye"', '"fisheye"', "camera.type",
     "unknown camera type 'fisheye' (known: pinhole, thinlens, orthographic)"),
    ("TOP", ',\n  "rendermode": "phng"', '"phng"', "rendermode",
     "unknown rendermode 'phng', did you mean 'phong'? "
     "(known: binary, phong, pathtracer, depth, normals, uv, albedo, shapes)"),
    ("CAMERA", ', "focusDistance": 0', "0", "camera.focusDistance", "must be greater than 0, got 0"),
    ("TOP", ',\n  "samples": 0', "0", "samples", "must be between 1 and 16777216, got 0"),
    ("TOP", ',\n  "nbounces": {}', "{}", "nbounces", "must be a whole number between 0 and 64, got an empty object"),
    ("TOP", ',\n  "tonemap": "aces"', '"aces"', "tonemap", "unknown tonemap 'aces' (known: linear, reinhard, filmic)"),
]


@pytest.mark.parametrize(("part", "spoilt", "pointed_at", "key_path", "message"), MISTAKES,
                         ids=[f"{row[3]}-{number}" for number, row in enumerate(MISTAKES)])
def test_a_mistake_is_told_with_its_place(refused, part, spoilt, pointed_at, key_path, message):
    """One spoilt part gives one problem at the line and column of what is wrong."""
    content = text(**{part: spoilt})
    (problem,) = refused(content)
    offset = content.index(pointed_at, content.index(spoilt))
    before = content[:offset]
    assert (problem.key_path, problem.message) == (key_path, message)
    assert (problem.line, problem.column) == (before.count("\n") + 1, offset - before.rfind("\n"))
    assert problem.file.endswith("s.json")


def test_position_equal_to_look_at_is_refused(refused, document):
    """A camera that looks nowhere is a mistake."""
    document["camera"]["position"] = [0, 0, 0]
    (problem,) = refused(document)
    assert problem.key_path == "camera.lookAt"
    assert problem.message.startswith("must differ from position")


def test_all_mistakes_are_told_at_once_in_the_order_of_the_file(refused):
    """Mistakes of keys and of their combination come together, sorted by place."""
    problems = refused(text(CAMERA=', "fov": 0, "upVector": [0, 0, 1]', SHAPE='{"type": "spere"}', TOP=', "samples": 0',
                            SPHERE=', "material": {"ks": -1, "texture": 1}, "raduis": 2'))
    assert [problem.key_path for problem in problems] == [
        "camera.fov", "scene.shapes[0].material.ks", "scene.shapes[0].material.texture", "scene.shapes[0].raduis",
        "scene.shapes[1].type", "samples",
    ]
    assert [(p.line, p.column) for p in problems] == sorted((p.line, p.column) for p in problems)


def test_the_whole_scene_is_checked_beside_a_faulty_shape(refused, document):
    """A broken key in one shape does not hide the missing direction of another or of the camera."""
    document["scene"]["shapes"][0]["radius"] = "big"
    document["scene"]["shapes"][1]["axis"] = [0, 0, 0]
    document["camera"]["upVector"] = [0, 0, 1]
    found = {problem.key_path for problem in refused(document)}
    assert found == {"scene.shapes[0].radius", "scene.shapes[1].axis", "camera.upVector"}


def test_many_mistakes_are_cut_and_counted(refused, document):
    """A file with hundreds of mistakes does not flood the terminal."""
    document["scene"]["shapes"] = [{"type": "sphere", "center": [0, 0, 0], "radius": -1}] * 250
    problems = refused(document)
    assert len(problems) == MAX_REPORTED + 1
    assert problems[-1].message == f"and {250 - MAX_REPORTED} more problems in this file"


# Unknown keys


def test_an_unknown_key_is_a_warning_with_the_nearest_name(scene_file):
    """By default an unknown key is ignored, and told where it stands."""
    content = text(SPHERE=', "raduis": 4')
    (warning,) = load(scene_file(content)).warnings
    assert (warning.key_path, warning.message) == (
        "scene.shapes[0].raduis", "unknown key, did you mean 'radius'? (ignored)")
    assert content.splitlines()[warning.line - 1][warning.column - 1:].startswith('"raduis"')


def test_strict_makes_an_unknown_key_a_mistake(refused):
    """With strict nothing is ignored."""
    (problem,) = refused(text(SPHERE=', "flavour": 4'), strict=True)
    assert (problem.key_path, problem.message) == ("scene.shapes[0].flavour", "unknown key")


def test_a_misspelt_required_key_is_told_beside_the_missing_one(refused):
    """The unknown key explains why the known one is missing."""
    problems = refused(text(SHAPE='{"type": "sphere", "center": [0, 0, 0], "raduis": 1}'))
    assert {(p.key_path, p.message) for p in problems} == {
        ("scene.shapes[1].radius", "is missing; it is a number greater than 0"),
        ("scene.shapes[1].raduis", "unknown key, did you mean 'radius'?"),
    }


def test_the_same_remark_in_many_places_is_told_once(scene_file, document):
    """An exporter's own key on every shape gives one line with a count."""
    for shape in document["scene"]["shapes"]:
        shape["exporter"] = 1
    (warning,) = load(scene_file(document)).warnings
    assert warning.message == "unknown key (here and in 5 more places) (ignored)"
    assert warning.key_path == "scene.shapes[0].exporter"


def test_the_editors_schema_key_is_no_remark(scene_file, document):
    """`$schema` is for editors."""
    assert load(scene_file({"$schema": "../docs/scene.schema.json"} | document), strict=True).warnings == ()


# What is not JSON


@pytest.mark.parametrize(("content", "line", "column", "said"), [
    ("", 0, 0, "is empty"),
    (" \n ", 0, 0, "is empty"),
    ('{"camera": ,}', 1, 12, "a value is expected here"),
    ('{\n "a": 1\n "b": 2}', 3, 2, "a comma (or the closing bracket) is expected here"),
    ('{"a" 1}', 1, 6, "a colon is expected here"),
    ("{'a': 1}", 1, 2, "a key in double quotes is expected here"),
    ("{\"a\": 'b'}", 1, 7, "a value is expected here; JSON has double quotes only"),
    ('{"a": True}', 1, 7, "a value is expected here; JSON writes true, false and null in lower case"),
    ('{"a": None}', 1, 7, "a value is expected here; JSON writes true, false and null in lower case"),
    ('{"a": 1,}', 1, 9, "the comma before it is one too many"),
    ('{"a": [1,]}', 1, 10, "the comma before it is one too many"),
    ('{"a": "b', 1, 7, "this text has no closing quote"),
    ('{"a": 1', 1, 8, "but the file ends"),
    ('{"a": 1} {"b": 2}', 1, 10, "the document has ended before this"),
    ('{\n// note\n"a": 1}', 2, 1, "JSON has no comments"),
    ('{"a": NaN}', 1, 7, "NaN is not a number that JSON knows"),
    ('{"a": [1,\n -Infinity]}', 2, 2, "-Infinity is not a number that JSON knows"),
    ('{"a": 1,\n "a": 2}', 2, 2, "this key is given twice"),
    ("[" * 5000, 1, 5000, "is nested too deeply"),
    ('{"a": ' * 5000, 1, 29995, "is nested too deeply"),
    ('{"a": 1, "b": ' + "9" * 5000 + "}", 1, 15, "holds a number with thousands of digits"),
    ("[1, 2]", 1, 1, "must be an object {...} with the keys camera and scene, got a list of 2 values"),
    ("null", 1, 1, "must be an object {...} with the keys camera and scene, got null"),
    (b'{"a":\n "caf\xe9"}', 2, 6, "is not UTF-8 text (byte 0xe9)"),
    (b"\xff\xfe{\x00}\x00", 1, 1, "is not UTF-8 text (byte 0xff)"),
])
def test_what_is_not_json_is_told_with_its_place(refused, content, line, column, said):
    """Syntax errors, and what Python's parser would let through, come with line and column."""
    (problem,) = refused(content)
    assert said in problem.message
    assert (problem.line, problem.column) == (line, column)


def test_every_repeated_key_is_told(refused):
    """Repeated keys anywhere are found, each with its path."""
    problems = refused('{"a": {"x": 1, "y": 2, "x": 3}, "b": [{"z": 0, "z": 0}]}')
    assert [(p.key_path, p.column) for p in problems] == [("a.x", 24), ("b[0].z", 48)]


def test_a_byte_order_mark_is_accepted(scene_file, document):
    """Editors on Windows write one."""
    assert load(scene_file(b"\xef\xbb\xbf" + json.dumps(document).encode())).warnings == ()


def test_a_missing_file_is_told_with_the_path_tried(tmp_path):
    """The absolute path helps whoever is in the wrong folder."""
    with pytest.raises(SceneError, match=r"no such file \(tried .*nothing\.json\)"):
        load(tmp_path / "nothing.json")


@pytest.mark.parametrize("beside, said", [
    ("scene.json", "no such file, did you mean 'scene.json'? (tried "),
    ("scene.txt", "no such file (tried "),
    ("lamp.json", "no such file (tried "),
    ("scene\n.json", "no such file (tried "),
])
def test_a_misspelt_file_is_told_with_its_neighbour(tmp_path, beside, said):
    """Of the same kind, of a similar name, and fit to be printed."""
    (tmp_path / beside).write_text("{}")
    with pytest.raises(SceneError) as caught:
        load(tmp_path / "scnee.json")
    assert caught.value.problems[0].message.startswith(said)


@pytest.mark.parametrize("path", ["", "a" * 5000, "nul\0byte"])
def test_an_impossible_path_is_told(path):
    """Paths that the system refuses are no traceback."""
    with pytest.raises(SceneError):
        load(path)


def test_a_directory_is_told(tmp_path):
    """A folder is not a scene."""
    with pytest.raises(SceneError, match="is a directory"):
        load(tmp_path)


def test_values_are_shown_short(refused, document):
    """A value of a thousand characters does not fill the screen."""
    document["camera"]["fov"] = "x" * 1000
    document["camera"]["width"] = 10**1000
    for problem in refused(document):
        assert len(problem.message) < 160


@pytest.mark.parametrize("value, told", [(np.float64(40), "float64"), (Decimal(40), "Decimal('40')"), ({1}, "{1}")])
def test_values_that_no_file_can_hold_are_told(document, value, told):
    """Programs that make a document may leave numbers of other kinds in it."""
    document["camera"]["fov"] = value
    with pytest.raises(SceneError, match=re.escape(told)):
        from_dict(document)


# Modes and documents


def test_another_mode_lets_a_path_traced_scene_load(scene_file, document):
    """`mode` replaces the file's, and what nothing would light there is no remark then."""
    document["rendermode"] = "pathtracer"
    loaded = load(scene_file(document), mode="phong", strict=True)
    assert (loaded.description.rendermode, loaded.warnings) == ("phong", ())


def test_an_unknown_mode_is_told_though_it_is_replaced(scene_file, document):
    """A typing mistake in the file does not pass in silence."""
    document["rendermode"] = "phogn"
    (warning,) = load(scene_file(document), mode="depth").warnings
    assert warning.message == "unknown rendermode 'phogn', did you mean 'phong'?; rendered as depth, as asked"


def test_an_unknown_asked_mode_is_a_usage_error(scene_file, document):
    """The mistake is the command line's, not the file's."""
    with pytest.raises(UsageError, match="unknown mode 'phogn', did you mean 'phong'"):
        load(scene_file(document), mode="phogn")


def test_a_document_loads_without_a_file(document):
    """Converters and tests pass dictionaries; they are not changed, and problems have no line."""
    before = json.dumps(document)
    loaded = from_dict({**document, "camera samples": 3})
    assert loaded.description.samples == 3
    assert json.dumps(document) == before
    with pytest.raises(SceneError) as caught:
        from_dict({"camera": {}, "scene": {}}, name="made up")
    assert {(p.file, p.line) for p in caught.value.problems} == {("made up", 0)}


def test_twenty_thousand_triangles_load(scene_file):
    """Meshes written as JSON keep their number and order."""
    triangle = {"type": "triangle", "v1": [1, 0, 0], "v2": [0, 1, 0], "material": {"kd": 0.5}}
    shapes = [{**triangle, "v0": [0, 0, -1 - number]} for number in range(20_000)]
    loaded = load(scene_file({"rendermode": "depth", "camera": {"position": [0, 0, 0], "lookAt": [0, 0, 1]},
                              "scene": {"shapes": shapes}}))
    assert len(loaded.shapes) == 20_000
    assert all(shape.v0[2] == -1 - index for index, shape in loaded.shapes)
