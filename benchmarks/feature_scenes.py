"""What the benchmark `features` compares: for each feature, a scene with it, and the same scene without it."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import dataclass, field

from benchmarks.measure import ROOT
from renderer.scene.schema import PATHTRACER

FOLDER = ROOT / "scenes" / "features"
SMALLER = 2  # times smaller than the effort's pictures on each side
GREY = {"type": "diffuse", "reflectance": [0.5] * 3}
LIGHT = {"type": "pointlight", "position": [-1.5, 3.2, -2.2], "intensity": [24.0, 23.0, 21.0]}
MANY = 64  # lights: so many that their choice takes tables
PIECES = 4  # shapes of a kind that are added, behind the camera
STRUCTURES = "hierarchy", "grid", "no structure"
FEWER = 2  # samples a pixel of these: every ray against every triangle takes long
BEHIND = -20.0  # z, where the camera looks along +z


def _same(document):
    """Return the document."""
    return document


@dataclass(frozen=True)
class Side:
    """A scene, with or without a feature."""

    said: str
    edit: Callable = _same  # document -> document
    patch: str = ""  # of benchmarks.feature_patches, in force while the kernel is recorded
    accel: str = "auto"


@dataclass(frozen=True)
class Feature:
    """What is compared; `scene` is a file under scenes/, the sides' edits are made to what it has."""

    scene: str
    having: Side
    without: Side
    pieces: int = 1  # things that are added together: the cost is that of one
    mitsuba: bool = False  # whether the same pair is measured with it
    samples: dict = field(default_factory=dict)  # side -> samples a pixel; others take those of the benchmark


def document(feature, side, size, samples):
    """Return the document of a side of a Feature, `size` pixels large."""
    made = json.loads((ROOT / "scenes" / f"{feature.scene}.json").read_text())
    made = side.edit(copy.deepcopy(made) | {"samples": feature.samples.get(side.said, samples), "mirrorlight": False})
    made["camera"] |= {"width": size[0], "height": size[1]}
    return made


def is_path_traced(feature):
    """Return whether a Feature's scenes are."""
    return document(feature, feature.having, (1, 1), 1)["rendermode"] == PATHTRACER


def folder(feature):
    """Return the folder that a feature's scene names files from."""
    return (ROOT / "scenes" / f"{feature.scene}.json").parent


def _with(**keys):
    """Return an edit that sets keys of the document."""
    return lambda made: made | keys


def _each_shape(change):
    """Return an edit that changes every shape."""

    def edit(made):
        made["scene"]["shapes"] = [change(shape) for shape in made["scene"]["shapes"]]
        return made

    return edit


def _material(**keys):
    """Return an edit of keys of all materials."""
    return _each_shape(lambda shape: shape | {"material": shape.get("material", {}) | keys})


def _grey(shape):
    """Return a shape whose BSDF, unless it is diffuse, is a grey diffuse one."""
    bsdf = shape["material"]["bsdf"]
    return shape if bsdf["type"] == "diffuse" else shape | {"material": {"bsdf": GREY}}


def _coursework(shape):
    """Return a shape of the coursework's own material in the place of plastic."""
    if shape["material"]["bsdf"]["type"] != "plastic":
        return shape
    return shape | {"material": {"diffusecolor": [0.5] * 3, "ks": 0.4, "specularexponent": 50}}


def _plain(shape):
    """Return a shape with values in the place of its images."""
    bsdf = {key: (0.3 if key == "alpha" else [0.5] * 3) if isinstance(value, str) and key != "type" else value
            for key, value in shape["material"]["bsdf"].items()}  # fmt: skip
    return shape | {"material": {"bsdf": bsdf}}


def _matt(shape):
    """Return a shape without emission."""
    return {key: value for key, value in shape.items() if key != "emission"}


def _ball(shape):
    """Return a sphere of about a mesh's size in its place."""
    kept = {key: shape[key] for key in ("material",) if key in shape}
    return shape if shape["type"] != "mesh" else {"type": "sphere", "center": [0, 1, 0], "radius": 1.0} | kept


def _lit(*lights):
    """Return an edit that leaves these lights and nothing that shines."""

    def edit(made):
        made = _each_shape(_matt)(made)
        made["scene"]["lightsources"] = list(lights)
        return made

    return edit


def _points(made):
    """Return the document with a point light in the middle of each lamp."""
    made["scene"]["lightsources"] = [
        {"type": "pointlight", "position": light["position"], "intensity": light["intensity"]}
        for light in made["scene"]["lightsources"]
    ]
    return made


def _dark_with(kind=None, **keys):
    """Return an edit to a scene without lights, with PIECES more shapes if a kind is named."""

    def edit(made):
        made["rendermode"], made["scene"]["lightsources"] = "phong", []
        made["scene"]["shapes"] += [{"type": kind, **_placed(keys, k)} for k in range(PIECES if kind else 0)]
        return made

    return edit


def _placed(keys, number):
    """Return a shape's keys with its points side by side behind the camera; it lies askew as the sheet asks."""
    def moved(p):
        return [p[0] + 3.0 * number, p[1], p[2] + BEHIND]

    points = ("center", "v0", "v1", "v2", "min", "max", "point")
    made = {key: moved(value) if key in points else value for key, value in keys.items()}
    return made | ({"vertices": [moved(p) for p in keys["vertices"]]} if "vertices" in keys else {})


def _shape(kind, said, **keys):
    """Return the Feature of a kind of shape: what its intersection test costs."""
    return Feature("features/shape_sphere", Side(f"{PIECES} {said} more behind the camera", _dark_with(kind, **keys)),
                   Side("without them; no lights", _dark_with()), pieces=PIECES)  # fmt: skip


def _phong(scene, having, without, **more):
    """Return a Feature of mode phong."""
    settle = _with(rendermode="phong")
    chained = [Side(side.said, lambda made, edit=side.edit: edit(settle(made)), side.patch, side.accel)
               for side in (having, without)]  # fmt: skip
    return Feature(scene, *chained, **more)


def _bsdf(kind, change=_same):
    """Return the Feature of a BSDF on the shapes above a diffuse floor."""
    scene = "features/bsdf_plastic" if kind == "coursework" else f"features/bsdf_{kind}"
    return Feature(scene, Side(f"{kind} on the shapes", _each_shape(change)),
                   Side("grey diffuse in its place", _each_shape(_grey)), mitsuba=True)  # fmt: skip


def _light(scene, said):
    """Return the Feature of a light."""
    return Feature(f"features/{scene}", Side(said), Side("a point light in its place", _lit(LIGHT)), mitsuba=True)


def _filter(name):
    """Return the Feature of a reconstruction filter."""
    return Feature("features/filter_box", Side(f"filter {name}", _with(filter=name)), Side("filter box"), mitsuba=True)


BASIC = {
    "basic.camera": _phong("binary_primitives",
                           Side("rays of the camera, their directions summed", patch="camera alone"),
                           Side("loop and film alone", patch="no camera")),
    "basic.sphere": _shape("sphere", "spheres", center=[0, 0, 0], radius=1.0),
    "basic.triangle": _shape("triangle", "triangles", v0=[0, 0, 0], v1=[1, 0, 0.3], v2=[0.2, 1, 0]),
    "basic.cylinder": _shape("cylinder", "cylinders", center=[0, 0, 0], axis=[1, 2, 3], radius=0.5, height=0.5),
    "basic.phong": _phong("simple_phong", Side("as it is"), Side("ambient light alone", patch="ambient alone")),
    "basic.highlight": _phong("simple_phong", Side("as it is"), Side("no highlight", patch="no highlight")),
    "basic.shadows": _phong("scene", Side("as it is"), Side("no shadow test", patch="no shadows")),
    "basic.reflection": _phong("mirror_image", Side("as it is"),
                               Side("no mirrors", _material(isreflective=False, isrefractive=False))),
    "basic.refraction": _phong("features/material_refractive", Side("as it is"),
                               Side("mirrors in the place of glass", _each_shape(
                                   lambda shape: shape | {"material": shape["material"] | {
                                       "isreflective": bool(shape["material"].get("isrefractive")),
                                       "isrefractive": False}}))),
}  # fmt: skip
MORE = {
    "intermediate.textures": _phong("features/texture_sphere", Side("an image on a sphere"),
                                    Side("one colour", _each_shape(lambda shape: shape | {"material": {"ks": 0.2}}))),
    "intermediate.bilinear": _phong("features/texture_nearest", Side("bilinear", _material(texturefilter="bilinear")),
                                    Side("nearest", _material(texturefilter="nearest"))),
    "intermediate.hierarchy": _phong("features/shape_triangle_soup", Side("hierarchy", accel="bvh"),
                                     Side("no structure", accel="none"), samples=dict.fromkeys(STRUCTURES, FEWER)),
    "older.grid": _phong("features/shape_triangle_soup", Side("grid", accel="grid"), Side("no structure", accel="none"),
                         samples=dict.fromkeys(STRUCTURES, FEWER)),
    "older.plane": _shape("plane", "planes", point=[0, 0, 0], normal=[0, 0.1, 1]),
    "older.box": _shape("box", "boxes", min=[0, 0, 0], max=[1, 1, 1]),
    "older.convex": _shape("convex", "tetrahedra", vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    "older.mesh": _phong("features/shape_mesh", Side("as it is"), Side("a sphere in its place", _each_shape(_ball))),
    "older.soft_shadows": _phong("soft_shadows", Side("as it is"), Side("a point light in its place", _points)),
    "older.glossy": _phong("soft_shadows", Side("as it is"), Side("sharp mirrors", _material(roughness=0.0))),
}  # fmt: skip
PIXELS = {
    "pathtracer.samples_phong": _phong("features/samples", Side("64 samples a pixel"), Side("1 sample a pixel"),
                                       samples={"1 sample a pixel": 1}),
    "pathtracer.samples": Feature("features/mode_pathtracer", Side("64 samples a pixel"), Side("1 sample a pixel"),
                                  samples={"1 sample a pixel": 1}),
    **{f"pathtracer.filter_{name}": _filter(name) for name in ("tent", "gaussian", "mitchell")},
    "pathtracer.sobol": Feature("features/mode_pathtracer", Side("Sobol points", _with(sampler="sobol")),
                                Side("independent numbers", _with(sampler="independent"))),
    "pathtracer.lens": Feature("features/camera_thinlens", Side("thin lens"), Side("pinhole", lambda made: made | {
        "camera": {key: made["camera"][key] for key in ("fov", "position", "lookAt")}}), mitsuba=True),
}  # fmt: skip
BSDFS = {
    f"pathtracer.bsdf_{kind}": _bsdf(kind) for kind in
    ("mirror", "conductor", "roughconductor", "dielectric", "roughdielectric", "plastic", "principled")
} | {
    "pathtracer.bsdf_coursework": Feature(
        "features/bsdf_plastic", Side("the coursework's material on the shapes", _each_shape(_coursework)),
        Side("grey diffuse in its place", _each_shape(_grey)), mitsuba=True),
    "pathtracer.bsdf_textured": Feature("features/bsdf_textured", Side("parameters from images"),
                                        Side("values", _each_shape(_plain)), mitsuba=True),
}  # fmt: skip
LIGHTS = {
    "pathtracer.light_pointlight": Feature("features/light_pointlight_paths", Side("a point light"),
                                           Side("the background alone", _lit()), mitsuba=True),
    **{f"pathtracer.light_{kind}": _light(f"light_{kind}", said) for kind, said in (
        ("spot", "spots"), ("directional", "light from far away"), ("arealight", "two lamps"),
        ("disklight", "lamps that are disks"), ("environment", "an image of the sky"))},
    **{f"pathtracer.light_{kind}": _light(f"emission_{kind}", said) for kind, said in (
        ("sphere", "shining spheres"), ("mesh", "a shining mesh"), ("sheets", "shining rectangle, disk, triangle"),
        ("solids", "shining box, cylinder, convex volume"))},
    "pathtracer.light_many": Feature("features/light_pointlight_paths", Side(f"{MANY} point lights", _lit(*(
        LIGHT | {"position": [0.2 * (k % 8) - 1, 3 + 0.1 * k, -2.0]} for k in range(MANY)))),
        Side("one", _lit(LIGHT)), mitsuba=True),
}  # fmt: skip
PATH = {
    "pathtracer.bounces": Feature("features/mode_pathtracer", Side("8 bounces", _with(nbounces=8)),
                                  Side("1 bounce", _with(nbounces=1)), mitsuba=True),
    "pathtracer.mis": Feature("features/mode_pathtracer", Side("as it is"),
                              Side("light from lights alone, unweighted", patch="lights alone")),
    "pathtracer.roulette": Feature("cornell", Side("roulette"), Side("none", _with(roulette=False)), mitsuba=True),
    "pathtracer.mirrorlight": Feature("scene_pathtracer", Side("lamps looked for in mirrors", _with(mirrorlight=True)),
                                      Side("found by chance")),
    "pathtracer.mesh": Feature("studio", Side("the teapot"), Side("a sphere in its place", _each_shape(_ball)),
                               mitsuba=True),
}  # fmt: skip
FAMILIES = BASIC, MORE, PIXELS, BSDFS, LIGHTS, PATH
SCENES = {key: feature for family in FAMILIES for key, feature in family.items()}
