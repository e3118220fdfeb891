"""Strangers' spellings: understood with a note, or left out in words."""

import pytest

from renderer.core.errors import SceneError
from renderer.core.vectors import cross, length, unit
from renderer.scene import aliases, aliases_light, aliases_material, materials, schema
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


def test_an_area_light_of_a_size_alone_is_left_out_in_words(document):
    """Where it faces cannot be told; the others stay."""
    light = {"type": "AreaLight", "position": [0, 4, 0], "size": [1, 2], "intensity": [1, 1, 1]}
    document["scene"]["lightsources"].insert(0, light)
    loaded = from_dict(document)
    (warning,) = loaded.warnings
    assert warning.key_path == "scene.lightsources[0]"
    assert warning.message == aliases_light.SIZE_ALONE
    assert len(loaded.description.scene.lightsources) == 1


LIT = {"position": [1, 4, 0], "intensity": [2, 2, 2]}


@pytest.mark.parametrize(("light", "expected"), [
    ({"type": "arealight", "u_axis": [2, 0, 0], "v_axis": [0, 0, 3]}, ((1, 4, 0), (2, 0, 0), (0, 0, 3))),
    ({"type": "AreaLight", "u": [0, 0, 3], "v": [2, 0, 0], "width": 4, "height": 0.5},
     ((1, 4, 0), (0, 0, 4), (0.5, 0, 0))),
    ({"type": "arealight", "u": [1, 0, 0], "v": [0, 0, 1], "width": 4, "samples": 8},
     ((1, 4, 0), (4, 0, 0), (0, 0, 1))),
    ({"type": "area", "normal": [0, 0, -2], "width": 4, "height": 2}, ((1, 4, 0), (4, 0, 0), (0, -2, 0))),
    ({"type": "arealight", "corner": [0, 5, 0], "edge1": [2, 0, 0], "edge2": [0, 0, 4], "position": None},
     ((1, 5, 2), (2, 0, 0), (0, 0, 4))),
])
def test_area_lights_of_others_find_their_place(document, light, expected):
    """Centre and edges, of full length."""
    light = {name: value for name, value in (LIT | light).items() if value is not None}
    document["scene"]["lightsources"] = [light]
    loaded = from_dict(document | {"rendermode": "path", "camera samples": 4})
    (area,) = loaded.description.scene.lightsources
    assert (area.position, area.u, area.v) == expected
    assert area.intensity == (2, 2, 2)
    assert all(warning.is_note or aliases.SHADOW_RAYS in warning.message for warning in loaded.warnings)


def test_a_normal_without_edges_faces_that_way(document):
    """The edges' cross product is along it, also if it is slanted."""
    document["scene"]["lightsources"] = [LIT | {"type": "area", "normal": [1, -2, 3], "width": 4, "height": 2}]
    (area,) = from_dict(document).description.scene.lightsources
    n = cross(area.u, area.v)
    assert length(area.u) == pytest.approx(4) and length(area.v) == pytest.approx(2)
    assert unit(n) == pytest.approx(unit([1, -2, 3]))


def test_a_mistake_in_a_foreign_area_light_points_to_the_file(document):
    """At the keys that were written."""
    document["scene"]["lightsources"] = [
        {"type": "area", "corner": [0, 5, 0], "edge1": [1, 0, 0], "edge2": [2, 0, 0], "intensity": 3}]
    with pytest.raises(SceneError) as caught:
        from_dict(document)
    (problem,) = [problem for problem in caught.value.problems if "parallel" in problem.message]
    assert problem.key_path == "scene.lightsources[0].corner"


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


@pytest.mark.parametrize(("camera", "radius", "focus"), [
    ({"type": "aperture", "diameter": 0.5}, 0.25, None),
    ({"type": "thinlens", "aperture": 0.5, "focalDistance": 3}, 0.5, 3),
    ({"type": "pinhole", "aperture": 0.5, "focusdistance": 3}, 0.25, 3),
    ({"apertureSize": 0.5, "focalDistance": 3}, 0.25, 3),
    ({"lensRadius": 0.5, "focus_distance": 3}, 0.5, 3),
])
def test_lenses_of_others_are_understood(document, camera, radius, focus):
    """By their radius or diameter; also with strict."""
    document["camera"] |= camera
    found = from_dict(document, strict=True).description.camera
    assert (found.type, found.apertureRadius, found.focusDistance) == ("thinlens", radius, focus)


@pytest.mark.parametrize("camera", [{"aperture": 0.5}, {"aperture": 0.5, "focus_distance": 3}])
def test_an_aperture_that_may_be_a_radius_or_a_diameter_is_left_out(document, camera):
    """In words."""
    document["camera"] |= camera
    loaded = from_dict(document)
    assert (loaded.description.camera.type, loaded.description.camera.apertureRadius) == ("pinhole", 0)
    (warning,) = [warning for warning in loaded.warnings if not warning.is_note]
    assert (warning.key_path, warning.message) == ("camera.aperture", aliases_light.ANY_APERTURE)


def test_a_pinhole_of_ours_stays_one(document):
    """Our own keys on a pinhole are a warning, and no lens."""
    document["camera"] |= {"apertureRadius": 0.5, "FOV": 30}
    loaded = from_dict(document)
    assert loaded.description.camera.type == "pinhole"
    assert any("type pinhole has no lens" in warning.message for warning in loaded.warnings)


@pytest.mark.parametrize("mode", ["path", "pathtracing", "PathTracer"])
def test_other_words_for_path_tracing_are_understood(document, mode):
    """Of any case."""
    loaded = from_dict(document | {"rendermode": mode}, strict=True)
    assert (loaded.description.rendermode, len(loaded.warnings)) == ("pathtracer", 1)
    assert from_dict(document | {"rendermode": mode}, mode="phong").description.rendermode == "phong"


@pytest.mark.parametrize(("name", "value"), [
    ("emission", [3, 2, 1]), ("emissioncolor", [3, 2, 1]), ("emissive", [3, 2, 1]), ("emission", 2),
])
def test_emission_of_a_material_is_that_of_its_shape(document, name, value):
    """A number is the same in every channel."""
    loaded = from_dict(changed(document | {"rendermode": "pathtracer"}, (*MATERIAL, name), value), strict=True)
    assert loaded.shapes[0][1].emission == ((3, 2, 1) if value != 2 else (2, 2, 2))


def test_a_negative_emission_points_to_the_file(document):
    """At the material's key."""
    with pytest.raises(SceneError) as caught:
        from_dict(changed(document, (*MATERIAL, "emissioncolor"), [1, -2, 3]))
    assert [p.key_path for p in caught.value.problems if "-2" in p.message] == [
        "scene.shapes[0].material.emissioncolor[1]"]


def test_a_metallic_material_is_principled(document, tmp_path):
    """With its colour or texture, and its roughness."""
    (tmp_path / "a.png").touch()
    document["rendermode"] = "pathtracer"
    changed(document, MATERIAL, {"metallic": 0.7, "roughness": 0.2, "diffusecolor": [0.1, 0.2, 0.3]})
    changed(document, ("scene", "shapes", 1, "material"), {"metallic": 1, "texture": "a.png"})
    loaded = from_dict(document, directory=tmp_path, strict=True)
    first, second = (shape.material.bsdf for _, shape in loaded.shapes[:2])
    assert first == materials.Principled(type="principled", basecolor=(0.1, 0.2, 0.3), metallic=0.7, roughness=0.2)
    assert second == materials.Principled(type="principled", basecolor="a.png", metallic=1.0)


def test_a_lambertian_brdf_is_diffuse(document):
    """Others are left out in words."""
    document["rendermode"] = "pathtracer"
    changed(document, MATERIAL, {"brdfType": "lambertian", "diffusecolor": [0.1, 0.2, 0.3]})
    changed(document, ("scene", "shapes", 1, "material"), {"brdfType": "schlick"})
    loaded = from_dict(document)
    first, second = (shape.material.bsdf for _, shape in loaded.shapes[:2])
    assert (first, second) == (materials.Diffuse(type="diffuse", reflectance=(0.1, 0.2, 0.3)), None)
    assert aliases_material.NO_BRDF in [warning.message for warning in loaded.warnings]


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
    lamp, point = world.lightsources
    assert point == schema.PointLight(type="pointlight", position=(0.0, 9.0, 0.0), intensity=(0.5, 0.25, 0.0))
    assert (lamp.type, lamp.position, lamp.intensity) == ("arealight", (0.0, 4.0, 0.0), (2.0, 2.0, 2.0))
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


OWN = {"file": [schema.Scene], "camera": [schema.Camera], "scene": [schema.World], "material": [schema.Material],
       "light": [record.node for record in schema.LIGHT_KINDS.values()],
       "shape": [record.node for record in schema.SHAPE_KINDS.values()]}


@pytest.mark.parametrize("where", OWN)
def test_no_alias_hides_a_key_of_ours(where):
    """Every target exists and no alias or foreign word is a key itself."""
    own = {name for record in OWN[where] for name in record.keys}
    assert set(aliases.RENAMED[where].values()) <= own
    assert not (set(aliases.RENAMED[where]) | set(aliases.UNRENDERED[where])) & own
