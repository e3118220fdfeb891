"""The export of path-traced scenes: dictionary and XML agree, our own plugin is a BSDF, and conventions are ours."""

import json
import re

import mitsuba as mi
import numpy as np
import pytest

from converters import mitsuba as export
from converters import cameras, whitted
from converters.mitsuba.as_dict import part_object  # chooses the variant
from converters.mitsuba.lamps import both_sides
from converters.mitsuba.plan import plan
from converters.nesting import outside_indices
from converters.solids import parts
from renderer.io.image import write_exr
from renderer.scene.loader import load, override
from tests.support.documents import write_texture
from tests.support.paths import scene
from tests.support.stats import LEAST_BATCHES, compare

pytestmark = pytest.mark.oracle

GREY = {"bsdf": {"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]}}
TEXTURED = {"bsdf": {"type": "plastic", "reflectance": "texture.png"}, "texturefilter": "nearest", "scaleU": 1.7}
ROUGH = {"bsdf": {"type": "roughconductor", "alpha": "texture.png"}, "normalmap": "texture.png"}
BUMPY = {"bsdf": {"type": "principled", "clearcoat": 0.5}, "bumpmap": "texture.png", "bumpscale": 0.05}
MIXED = {"kd": 0.5, "ks": 0.3, "isreflective": True, "reflectivity": 0.3, "texture": "texture.png"}
FLOOR = {"type": "plane", "point": [0, -0.9, 0], "normal": [0, 1, 0], "material": GREY}
LIGHTS = [
    {"type": "arealight", "position": [0.6, 2.0, -0.8], "u": [1, 0.3, 0.2], "v": [-0.2, 0, 1], "intensity": [9, 8, 7]},
    {"type": "disklight", "position": [-1, 1.5, 0], "normal": [0.3, -1, 0], "radius": 0.4, "intensity": [3, 8, 7],
     "twosided": False},
    {"type": "spot", "position": [1.0, 2.5, -1.5], "direction": [-1.0, -2.9, 1.6], "intensity": [9, 8, 7]},
    {"type": "directional", "direction": [-1.0, -2.9, 1.6], "intensity": [0.2, 0.1, 0.3]},
    {"type": "pointlight", "position": [1.0, 0.5, -1.5], "intensity": [1, 1, 2]},
    {"type": "environment", "filename": "sky.exr", "intensity": [0.5, 0.4, 0.3], "rotation": 40.0},
]
EVERYTHING = scene(
    {"type": "sphere", "center": [-0.6, 0, 0], "radius": 0.4, "material": TEXTURED},
    {"type": "rectangle", "center": [0.2, 0, 0.2], "u": [0.8, 0, 0.2], "v": [0, 0.8, 0.1], "material": ROUGH},
    {"type": "disk", "center": [0.9, 0, 0], "normal": [0.3, 0, -1], "radius": 0.4, "material": BUMPY},
    {"type": "box", "min": [-0.3, -0.9, -0.8], "max": [0.1, -0.5, -0.4], "material": {"bsdf": {"type": "dielectric"}}},
    {"type": "triangle", "v0": [-1, 0.5, 0.3], "v1": [0.2, 0.6, 0.4], "v2": [-0.4, 1.1, 0.3], "material": MIXED,
     "emission": [0.3, 0.2, 0.1]},
    FLOOR, lights=LIGHTS, filter="tent", samples=64,
    camera={"type": "thinlens", "apertureRadius": 0.3, "focusDistance": 3.7, "width": 24, "height": 16},
)


def prepare(folder, document):
    """Return the document loaded, with the files that it names beside it."""
    write_texture(folder / "texture.png")
    sky = np.random.default_rng(5).random((6, 8, 3)).astype(np.float32)
    write_exr(folder / "sky.exr", {name: np.ascontiguousarray(sky[..., k]) for k, name in enumerate("RGB")}, {})
    (folder / "scene.json").write_text(json.dumps(document))
    return load(folder / "scene.json")


def picture(whole):
    """Return Mitsuba's picture."""
    return np.array(mi.render(whole, seed=5), np.float64)


def batches(whole, seed):
    """Return pictures by different seeds: the orders of lights differ between dictionary and XML, and so does noise."""
    return np.array([mi.render(whole, seed=seed + k).numpy() for k in range(LEAST_BATCHES)], np.float64)


@pytest.fixture(scope="module")
def from_dictionary(tmp_path_factory):
    """Pictures of the dictionary of EVERYTHING."""
    return batches(mi.load_dict(export.to_dict(prepare(tmp_path_factory.mktemp("dictionary"), EVERYTHING))), 0)


def from_xml(path):
    """Return pictures of an XML file."""
    return batches(mi.load_file(str(path)), 100)


def test_xml_is_the_dictionary(tmp_path, from_dictionary):
    """The XML with its files renders to the picture of the dictionary."""
    loaded = prepare(tmp_path, EVERYTHING)
    warnings = export.write_xml(loaded, tmp_path / "out.xml")
    assert not compare(from_xml(tmp_path / "out.xml"), from_dictionary).refused
    assert any("mirror share" in str(w) and "scene.shapes[4]" in str(w) for w in warnings)


@pytest.mark.parametrize(("pattern", "replacement"), [
    (r'name="max_depth" value="5"', 'name="max_depth" value="2"'),
    (r'name="focus_distance" value="3.7"', 'name="focus_distance" value="2.7"'),
    (r'name="raw" value="false"', 'name="raw" value="true"'),
    (r'(<rfilter type="tent".*\n.*value=")1.0', r"\g<1>2.0"),
    (r'name="cutoff_angle" value="30.0"', 'name="cutoff_angle" value="50.0"'),
    (r'(name="radiance" value=")9', r"\g<1>4"),
    (r'(type="envmap".*\n.*\n.*<matrix value=")\S+ \S+ \S+', r"\g<1>1.0 0.0 0.0"),
    (r'name="scale" value="0.05"', 'name="scale" value="0.5"'),
])
def test_changed_xml_is_another_scene(tmp_path, from_dictionary, pattern, replacement):
    """The comparison above sees changed depths, lenses, textures, filters and lights."""
    loaded, path = prepare(tmp_path, EVERYTHING), tmp_path / "out.xml"
    export.write_xml(loaded, path)
    text, count = re.subn(pattern, replacement, path.read_text())
    assert count, "nothing was changed"
    path.write_text(text)
    assert compare(from_xml(path), from_dictionary).refused


def test_only_the_mixed_material_is_inexact(tmp_path):
    """With our own plugin nothing is to be said; without, the one material that has no stock counterpart is named."""
    document = scene({"type": "sphere", "center": [0, 0, 0], "radius": 1.0, "material": {"kd": 0.5, "ks": 0.3}}, FLOOR,
                     lights=LIGHTS[:5])
    loaded = prepare(tmp_path, document)
    assert export.plan(loaded, exact=True).warnings == ()
    assert ["rough plastic" in str(w) for w in export.plan(loaded).warnings] == [True]
    plain = scene({"type": "sphere", "center": [0, 0, 0], "radius": 1.0, "material": {"kd": 0.5, "ks": 0.0}}, FLOOR)
    assert export.plan(prepare(tmp_path, plain)).warnings == ()


def sky_picture(folder, direction, **camera):
    """Return the picture of surroundings that are red in the first quarter of the image's columns, else black."""
    image = np.zeros((4, 64, 3), np.float32)
    image[:, :16, 0] = 1
    document = scene(lights=[{"type": "environment", "filename": "quarter.exr"}],
                     camera={"position": [0, 0, 0], "lookAt": direction, "fov": 60, **camera})
    loaded = prepare(folder, document)
    write_exr(folder / "quarter.exr", {name: np.ascontiguousarray(image[..., k]) for k, name in enumerate("RGB")}, {})
    return picture(mi.load_dict(export.to_dict(loaded)))[..., 0]


def test_surroundings_are_not_mirrored(tmp_path):
    """Towards -z the picture shows the image's first columns right of its middle, and its last ones left of it."""
    (tmp_path / "quarter.exr").write_bytes(b"")
    seen = sky_picture(tmp_path, [0, 0, -1])
    assert seen[:, 28:].mean() > 0.99 and seen[:, :20].mean() < 0.01
    assert sky_picture(tmp_path, [0, 0, 1]).mean() < 0.01


@pytest.mark.parametrize("shape", [
    {"type": "rectangle", "center": [0, 1, 2], "u": [1, 0, 0], "v": [0, 0, 3]},
    {"type": "rectangle", "center": [0, 1, 2], "u": [1, 0.5, 0], "v": [0, 0.5, 3]},
    {"type": "disk", "center": [0, 1, 2], "normal": [0, 1, 3], "radius": 2},
    {"type": "triangle", "v0": [0, 0, 0], "v1": [1, 0, 0], "v2": [0, 1, 1]},
    {"type": "plane", "point": [0, 1, 2], "normal": [0, 1, 0]},
])
def test_both_sides_face_apart_and_share_texture_coordinates(tmp_path, shape):
    """The reverse has the opposite normal, lies a hair behind, and at the same place the same texture coordinates."""
    part = parts(prepare(tmp_path, scene(shape)).shapes[0][1])[0]
    hits = {}
    for name, side in both_sides(part).items():
        whole = mi.load_dict({"type": "scene", "s": part_object(side, {})})
        middle, normal = _middle(side)
        hit = whole.ray_intersect(mi.Ray3f(mi.Point3f(*map(float, middle + [0.1, 0.2, 0.15] + normal)),
                                           mi.Vector3f(*map(float, -normal))))
        p, n, uv = (np.array(value).ravel() for value in (hit.p, hit.n, hit.uv))
        assert hit.is_valid()[0] and n @ normal > 0.999, name
        mapped = side.uv_map @ [*uv, 1.0] if side.uv_map is not None else np.zeros(3)
        hits[name] = p, n, mapped
    (front, out, uv), (back, reverse, same_uv) = hits.values()
    assert out @ reverse < -0.999 and 0 < (front - back) @ out < 1e-3
    assert np.allclose(uv, same_uv, atol=1e-3)


def _middle(side):
    """Return a point of a part and its normal."""
    if side.mesh is not None:
        corners = side.mesh.vertices[side.mesh.faces[0]]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        return corners.mean(axis=0), normal / np.linalg.norm(normal)
    return side.to_world[:3, 3], side.to_world[:3, 2]


def test_focus_is_on_what_is_looked_at(tmp_path):
    """Without a distance, the sharp plane goes through the point looked at."""
    camera = {"type": "thinlens", "apertureRadius": 0.1, "position": [1, 2, 3], "lookAt": [1, 2, 8]}
    kind, parameters = cameras.sensor(prepare(tmp_path, scene(camera=camera)).description.camera)
    assert kind == "thinlens" and parameters["focus_distance"] == pytest.approx(5)


@pytest.mark.parametrize(("mode", "samples", "kind"), [
    ("phong", 1, "perspective"), ("phong", 16, "thinlens"), ("normals", 16, "perspective"),
    ("pathtracer", 1, "thinlens"),
])
def test_lens_is_exported_where_it_blurs(tmp_path, mode, samples, kind):
    """One ray a pixel goes through the middle of the lens, but in mode `pathtracer`; debug modes have no other."""
    camera = {"type": "thinlens", "apertureRadius": 0.1}
    loaded = prepare(tmp_path, scene(camera=camera, samples=samples, rendermode=mode))
    assert plan(loaded).children["sensor"].type == kind


def test_glass_around_glass_depends_on_the_mode(tmp_path):
    """In mode `pathtracer` the BSDF tells what refracts, in phong mode the coursework's keys."""
    def ball(radius, material):
        return {"type": "sphere", "center": [0, 0, 0], "radius": radius, "material": material}

    water = {"bsdf": {"type": "roughdielectric", "ior": 1.33}, "isrefractive": True, "refractiveindex": 1.2}
    opaque = {"bsdf": {"type": "diffuse"}, "isrefractive": True, "refractiveindex": 1.1}
    document = scene(ball(3, water), ball(2, opaque), ball(1, {"isrefractive": True, "refractiveindex": 1.5}))
    shapes = [shape for _, shape in prepare(tmp_path, document).shapes]
    assert outside_indices(shapes, "pathtracer") == [1.0, 1.0, 1.33]  # what is opaque does not ask
    assert outside_indices(shapes, "phong") == [1.0, 1.2, 1.1]


def test_phong_export_takes_every_light(tmp_path):
    """In phong mode each light has a counterpart that lights about as much, and what differs is told."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 0.7, "material": {"ks": 0.0}}
    for light in LIGHTS:
        document = scene(ball, {**FLOOR, "material": {"ks": 0.0}}, lights=[light], samples=1)
        document["scene"]["ambientlight"] = [0, 0, 0]
        loaded = override(prepare(tmp_path, document), mode="phong")
        warnings = export.write_xml(loaded, tmp_path / "out.xml")
        assert bool(warnings) == (light["type"] != "directional")
        stock, exact = picture(mi.load_file(str(tmp_path / "out.xml"))), whitted.reference(loaded)
        if light["type"] != "environment":  # which in phong mode is only seen
            assert 0.5 < stock[exact["hit"]].mean() / exact["rgb"][exact["hit"]].mean() < 2
