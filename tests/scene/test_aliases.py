"""Strangers' spellings: understood with a note, or left out in words."""

import pytest

from renderer.core.errors import SceneError
from renderer.scene import aliases, schema
from renderer.scene.loader import from_dict, load


def changed(document, path, value):
    """Return the document with the value at a path of keys and indices set (None removes it)."""
    place = document
    for step in path[:-1]:
        place = place.setdefault(step, {}) if isinstance(place, dict) else place[step]
    if value is None:
        place.pop(path[-1])
    else:
        place[path[-1]] = value
    return document


def first_material(loaded):
    """Return the material of the first shape."""
    return loaded.shapes[0][1].material


MATERIAL = ("scene", "shapes", 0, "material")


@pytest.mark.parametrize(("path", "value", "read", "expected"), [
    (("camera samples",), 9, lambda s: s.description.samples, 9),
    (("samplesPerPixel",), 9, lambda s: s.description.samples, 9),
    (("nBounces",), 3, lambda s: s.description.nbounces, 3),
    (("rendermode",), "Preview", lambda s: s.description.rendermode, "phong"),
    (("rendermode",), "BINARY", lambda s: s.description.rendermode, "binary"),
    (("camera", "up"), [1, 0, 0], lambda s: s.description.camera.upVector, (1, 0, 0)),
    (("camera", "FOV"), 30, lambda s: s.description.camera.fov, 30),
    (("scene", "ambientLight"), [1, 0, 0], lambda s: s.description.scene.ambientlight, (1, 0, 0)),
    (("scene", "background_color"), [1, 0, 0], lambda s: s.description.scene.backgroundcolor, (1, 0, 0)),
    ((*MATERIAL, "specular-exponent"), 3, lambda s: first_material(s).specularexponent, 3),
    ((*MATERIAL, "ior"), 1.5, lambda s: first_material(s).refractiveindex, 1.5),
    ((*MATERIAL, "texturefile"), "", lambda s: first_material(s).texture, None),
    ((*MATERIAL, "transparency"), 0.7, lambda s: (first_material(s).isrefractive, first_material(s).reflectivity),
     (True, 0.7)),
    ((*MATERIAL, "transparency"), 0, lambda s: first_material(s).isrefractive, False),
    (("scene", "shapes", 0, "color"), [1, 0, 0], lambda s: first_material(s).diffusecolor, (1, 0, 0)),
    (("scene", "shapes", 0, "reflectivity"), 0.3,
     lambda s: (first_material(s).isreflective, first_material(s).reflectivity), (True, 0.3)),
    (("scene", "shapes", 0, "type"), "Sphere", lambda s: s.shapes[0][1].radius, 1),
    (("scene", "lightsources", 0, "type"), "point", lambda s: s.description.scene.lightsources[0].intensity, (1, 1, 1)),
    (("scene", "lightsources", 0, "intensity"), 0.5,
     lambda s: s.description.scene.lightsources[0].intensity, (0.5, 0.5, 0.5)),
])
def test_a_common_spelling_is_understood_with_a_note(document, path, value, read, expected):
    """Also with strict, because nothing is lost."""
    loaded = from_dict(changed(document, path, value), strict=True)
    assert read(loaded) == expected
    assert loaded.warnings
    assert all("understood" in str(note) for note in loaded.warnings)


@pytest.mark.parametrize("name", ["texturefile", "texturepath", "textureFilename", "texture_file", "texturePath"])
def test_every_spelling_of_a_texture_file_is_looked_up(document, tmp_path, name):
    """The missing file is told at the key that the file used."""
    changed(document, (*MATERIAL, name), "gone.png")
    with pytest.raises(SceneError) as caught:
        from_dict(document, directory=tmp_path)
    (problem,) = caught.value.problems
    assert problem.key_path == f"scene.shapes[0].material.{name}"
    assert "gone.png" in problem.message


@pytest.mark.parametrize("name", ["hasTexture", "hastexture"])
def test_a_texture_switched_off_is_not_used(document, name):
    """Even if its file is missing."""
    changed(document, (*MATERIAL, name), False)
    changed(document, (*MATERIAL, "textureFilename"), "gone.png")
    assert first_material(from_dict(document)).texture is None


def test_an_ambient_light_becomes_the_ambient_light(document):
    """It leaves the list, and those after it keep their place in messages."""
    lights = document["scene"]["lightsources"]
    lights.insert(0, {"type": "ambient", "intensity": [0.1, 0.2, 0.3]})
    lights.append({"type": "pointlight", "position": [1, 1, 1]})
    with pytest.raises(SceneError) as caught:
        from_dict(document)
    assert [problem.key_path for problem in caught.value.problems] == ["scene.lightsources[2].intensity"]
    lights.pop()
    description = from_dict(document).description
    assert description.scene.ambientlight == (0.1, 0.2, 0.3)
    assert len(description.scene.lightsources) == 1


UNRENDERED = [
    (where, name) for where, table in aliases.UNRENDERED.items() for name in table
]
PLACES = {"file": (), "camera": ("camera",), "scene": ("scene",), "light": ("scene", "lightsources", 0),
          "shape": ("scene", "shapes", 0), "material": MATERIAL}


@pytest.mark.parametrize(("where", "name"), UNRENDERED)
def test_a_feature_that_is_not_rendered_is_told_in_words(document, where, name):
    """The rest of the scene still renders; with strict it does not."""
    changed(document, (*PLACES[where], name), 0.5)
    loaded = from_dict(document)
    (warning,) = loaded.warnings
    assert warning.message == aliases.UNRENDERED[where][name]
    assert len(loaded.shapes) == 6
    with pytest.raises(SceneError):
        from_dict(document, strict=True)


@pytest.mark.parametrize("kind", [*aliases.LIGHTS_LEFT_OUT, "AreaLight"])
def test_a_foreign_light_is_left_out_in_words(document, kind):
    """The others stay."""
    document["scene"]["lightsources"].insert(0, {"type": kind, "u": 3})
    loaded = from_dict(document)
    (warning,) = loaded.warnings
    assert warning.key_path == "scene.lightsources[0]"
    assert warning.message.startswith("left out: ")
    assert len(loaded.description.scene.lightsources) == 1


@pytest.mark.parametrize("kind", aliases.SHAPES_LEFT_OUT)
def test_a_foreign_shape_is_left_out_and_the_others_keep_their_index(document, kind):
    """Indices in messages and pictures are those of the file."""
    document["scene"]["shapes"].insert(2, {"type": kind, "filename": "a.obj"})
    document["scene"]["shapes"][4]["strange"] = 1
    loaded = from_dict(document)
    assert [index for index, _ in loaded.shapes] == [0, 1, 3, 4, 5, 6]
    assert [w.key_path for w in loaded.warnings] == ["scene.shapes[4].strange", "scene.shapes[2]"] or \
        {w.key_path for w in loaded.warnings} == {"scene.shapes[2]", "scene.shapes[4].strange"}
    with pytest.raises(SceneError, match="left out"):
        from_dict(document, strict=True)


@pytest.mark.parametrize("kind", ["thinlens", "aperture"])
def test_a_lens_is_rendered_as_a_pinhole(document, kind):
    """The lens's own keys are told once more, at their place."""
    document["camera"] |= {"type": kind, "aperture": 0.1, "focalDistance": 3}
    loaded = from_dict(document)
    assert {w.key_path for w in loaded.warnings} == {"camera.type", "camera.aperture", "camera.focalDistance"}
    assert {w.message for w in loaded.warnings} == {aliases.LENS}


@pytest.mark.parametrize("mode", ["pathtracer", "pathtracing", "PathTracer"])
def test_a_path_traced_scene_says_what_to_do(document, mode):
    """It is refused until another mode is asked for."""
    document["rendermode"] = mode
    with pytest.raises(SceneError, match="--mode phong"):
        from_dict(document)
    assert from_dict(document, mode="phong").description.rendermode == "phong"


OTHER_LAYOUT = """{
  "camera": {"position": [1, 2, 3], "look_at": [0, 0, 1], "up": [0, 1, 0], "focus_distance": 3},
  "lights": [
    {"type": "area", "position": [0, 4, 0], "normal": [0, -1, 0], "width": 1, "height": 1, "intensity": 2},
    {"type": "point", "position": [0, 9, 0], "intensity": 0.5, "color": [1, 0.5, 0]}
  ],
  "objects": [
    {"type": "cubemap", "filename": "sky.png"},
    {"type": "sphere", "center": [0, 0, 9], "radius": 1, "color": [1, 0, 0], "reflectivity": 0.25,
     "transparency": 0, "refractive_index": 1.5},
    {"type": "sphere", "center": [0, 0, 9], "radius": 2, "color": [0, 0, 1], "reflectivity": 0, "transparency": 0.5}
  ]
}"""


def test_the_layout_with_objects_at_the_top_level_loads(scene_file):
    """Lights, objects and their colours find their places, and a direction is made a point."""
    loaded = load(scene_file(OTHER_LAYOUT))
    camera, world = loaded.description.camera, loaded.description.scene
    assert camera.lookAt == (1.0, 2.0, 4.0)
    assert world.lightsources == (schema.PointLight(position=(0.0, 9.0, 0.0), intensity=(0.5, 0.25, 0.0)),)
    (first, mirror), (second, glass) = loaded.shapes
    assert (first, second) == (1, 2)
    assert mirror.material == schema.Material(
        diffusecolor=(1.0, 0.0, 0.0), isreflective=True, reflectivity=0.25, refractiveindex=1.5)
    assert glass.material == schema.Material(
        diffusecolor=(0.0, 0.0, 1.0), isreflective=False, isrefractive=True, reflectivity=0.5)


def test_places_in_a_translated_file_are_those_of_the_file(scene_file):
    """A mistake behind three translations points to the user's own text."""
    content = OTHER_LAYOUT.replace('"color": [0, 0, 1]', '"color": [0, -7, 1]')
    with pytest.raises(SceneError) as caught:
        load(scene_file(content))
    (mistake,) = [p for p in caught.value.problems if "got -7" in p.message]
    offset = content.index("-7")
    assert mistake.key_path == "objects[2].color[1]"
    assert (mistake.line, mistake.column) == (content[:offset].count("\n") + 1, offset - content[:offset].rfind("\n"))


@pytest.mark.parametrize(("where", "own"), [
    ("file", schema.Scene), ("camera", schema.Camera), ("scene", schema.World), ("light", schema.PointLight),
    ("material", schema.Material),
])
def test_no_alias_hides_a_key_of_ours(where, own):
    """Every target exists and no alias or foreign word is a key itself."""
    assert set(aliases.RENAMED[where].values()) <= set(own.keys)
    assert not (set(aliases.RENAMED[where]) | set(aliases.UNRENDERED[where])) & set(own.keys)
