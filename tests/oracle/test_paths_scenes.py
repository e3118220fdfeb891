"""Path-traced scenes against Mitsuba: cameras, filters, bounces, textures, caustics, mirrors, and all together.

In each, one thing is a little wrong on our side in a twin, which is refused.
"""

import numpy as np
import pytest
from PIL import Image

from renderer.engine.render import render
from renderer.scene.loader import override
from tests.support.documents import SHAPES, changed, write_texture
from tests.support.meshes import lump, mesh, write
from tests.support.paths import Case, ours, scene, times
from tests.support.stats import compare, demand_equal

pytestmark = pytest.mark.oracle

CHALK = {"bsdf": {"type": "diffuse", "reflectance": [0.8, 0.6, 0.4]}}
GREY = {"bsdf": {"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]}}
WHITE = {"bsdf": {"type": "diffuse", "reflectance": [0.85, 0.85, 0.85]}}
RED = {"bsdf": {"type": "diffuse", "reflectance": [0.7, 0.1, 0.1]}}
GREEN = {"bsdf": {"type": "diffuse", "reflectance": [0.1, 0.6, 0.15]}}
GLASS = {"bsdf": {"type": "dielectric", "ior": 1.5}}
MIRROR = {"bsdf": {"type": "mirror", "reflectance": [0.9, 0.9, 0.9]}}
FLOOR = {"type": "rectangle", "center": [0, -0.9, 0], "u": [0, 0, 9], "v": [9, 0, 0], "material": GREY}
BALL = {"type": "sphere", "center": [-0.3, -0.3, -0.2], "radius": 0.55, "material": CHALK}
LAMP = {"type": "arealight", "position": [-0.8, 2.0, -1.5], "u": [1.5, 0, 0.2], "v": [0, 0.3, 1.2],
        "intensity": [4, 4, 4]}
DIM = [0.03, 0.03, 0.03]  # a sky under which relief shows
SKY = [0.5, 0.6, 0.7]


def room(*shapes, size=1.0):
    """Return the shapes of an open box with a red and a green wall, and what is in it."""
    def wall(center, u, v, material):
        return {"type": "rectangle", "center": center, "u": u, "v": v, "material": material}

    return (wall([0, -size, 0], [2, 0, 0], [0, 0, 2], WHITE), wall([0, size, 0], [2, 0, 0], [0, 0, 2], WHITE),
            wall([0, 0, size], [2, 0, 0], [0, 2, 0], WHITE), wall([-size, 0, 0], [0, 2, 0], [0, 0, 2], RED),
            wall([size, 0, 0], [0, 2, 0], [0, 0, 2], GREEN), *shapes)


INTO_ROOM = {"position": [0, 0, -3.4], "lookAt": [0, 0, 0], "fov": 40.0}
CEILING = {"type": "arealight", "position": [0, 0.98, 0], "u": [0.7, 0, 0], "v": [0, 0, 0.7],
           "intensity": [6.0, 5.5, 5.0]}
BLOCK = {"type": "box", "min": [-0.6, -1.0, -0.1], "max": [0.0, -0.1, 0.5], "material": WHITE}
INTENSITY = "scene.lightsources.0.intensity"


def in_room(*shapes, bounces=5, path=INTENSITY, value=None, samples=256, **settings):
    """Return the Case of things in the room under its lamp."""
    document = scene(*room(*shapes), lights=[CEILING], camera=INTO_ROOM, bounces=bounces, **settings)
    return Case(document, path, times(1.01) if value is None else value, samples)


def at_camera(path, value, samples=256, shapes=(BALL, FLOOR), **camera):
    """Return the Case of a camera."""
    return Case(scene(*shapes, lights=[LAMP], background=SKY, camera=camera), f"camera.{path}", value, samples)


NEAR = {"type": "sphere", "center": [0.8, 0.2, -1.8], "radius": 0.25, "material": RED}
LENS = {"type": "thinlens", "apertureRadius": 0.3, "focusDistance": 3.6}
SMALL_SKY = np.random.default_rng(3).gamma(0.5, 1.0, (6, 9, 3)).astype(np.float32)


def write_files(folder):
    """Write a texture, a grey one, a map of normals, heights, surroundings and a mesh."""
    write_texture(folder / "texture.png")
    rng = np.random.default_rng(11)
    Image.fromarray(rng.integers(60, 200, (6, 5, 1)).astype(np.uint8).repeat(3, 2)).save(folder / "grey.png")
    coloured = rng.integers(60, 200, (6, 5, 3)).astype(np.uint8)
    Image.fromarray(coloured).save(folder / "numbers.png")
    tilt = rng.uniform(-0.35, 0.35, (8, 6, 2))
    normals = np.concatenate([tilt, np.sqrt(1 - (tilt**2).sum(2, keepdims=True))], axis=2)
    Image.fromarray(np.rint(255 * (0.5 + 0.5 * normals)).astype(np.uint8)).save(folder / "normals.png")
    Image.fromarray(rng.integers(0, 255, (8, 6), dtype=np.uint8)).save(folder / "heights.png")
    write_hdr(folder / "sky.hdr")
    write(folder / "lump.ply", lump(300))


def write_hdr(path):
    """Write SMALL_SKY in Radiance's format, flat: 8-bit mantissas with a common exponent."""
    mantissa, exponent = np.frexp(SMALL_SKY.max(axis=2))
    texels = np.concatenate([SMALL_SKY / np.ldexp(1.0, exponent)[..., None] * 256, exponent[..., None] + 128.0], axis=2)
    height, width = SMALL_SKY.shape[:2]
    header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    path.write_bytes(header.encode() + np.uint8(np.clip(texels, 0, 255)).tobytes())


def surrounded(*shapes, samples=256, path=INTENSITY, value=None, camera=None, **settings):
    """Return the Case of shapes in surroundings of an image."""
    sky = {"type": "environment", "filename": "sky.hdr", "rotation": 25.0, **settings}
    return Case(scene(*shapes, lights=[{**sky, "intensity": [1.0, 0.9, 0.8]}], camera=camera), path,
                times(1.01) if value is None else value, samples, (write_files,))


def textured(shape, key, wrong, samples=256, sky=SKY, **material):
    """Return the Case of a shape with a texture, of which a key of the material is wrong on our side."""
    placed = {"scaleU": 1.7, "scaleV": 1.3, **material}
    document = scene({**shape, "material": placed}, FLOOR, lights=[LAMP], background=sky)
    return Case(document, f"scene.shapes.0.material.{key}", wrong, samples, (write_files,))


def plain(kind, **parameters):
    """Return a material of a BSDF."""
    return {"bsdf": {"type": kind, **parameters}}


PANE = {"type": "rectangle", "center": [0.1, 0.1, 0.0], "u": [1.7, 0.2, 0.5], "v": [-0.2, 1.6, 0.1]}
BOARD = {"type": "checkerboard", "color1": [0.1, 0.2, 0.3], "color2": [0.8, 0.7, 0.6], "scale": 5.0}
DULL = {"type": "checkerboard", "color1": [0.1, 0.1, 0.1], "color2": [0.6, 0.6, 0.6], "scale": 3.0}

SAMPLES = {0: 1024, 1: 256, 2: 256, 8: 256}  # for numbers of bounces

CASES = {
    "thinlens": at_camera("apertureRadius", times(1.05), 256, (BALL, NEAR, FLOOR), **LENS),
    "thinlens_focus": at_camera("focusDistance", times(1.02), 256, (BALL, NEAR, FLOOR), **LENS),
    "thinlens_default_focus": at_camera("lookAt", [0.05, 0.2, 0.3], 256, (BALL, NEAR, FLOOR), type="thinlens",
                                        apertureRadius=0.2),
    "orthographic": at_camera("viewHeight", times(1.01), 512, type="orthographic", viewHeight=3.0),
    "orthographic_as_fov": at_camera("fov", times(1.01), 512, type="orthographic"),
    "fov": at_camera("fov", times(1.01), 512),
    "upright": at_camera("upVector", [0.31, 1.0, 0.0], 64, width=32, height=48, upVector=[0.3, 1.0, 0.0]),
    **{f"bounces_{n}": in_room(BLOCK, bounces=n, samples=SAMPLES[n]) for n in SAMPLES},
    "one_bounce_less": in_room(BLOCK, bounces=3, path="nbounces", value=2),
    "one_bounce_more": in_room(BLOCK, bounces=3, path="nbounces", value=4),
    "no_roulette": in_room(BLOCK, bounces=8, roulette=False),
    "sobol": in_room(BLOCK, sampler="sobol"),
    "albedo": in_room(BLOCK, path="scene.shapes.0.material.bsdf.reflectance", value=times(0.98)),
    "caustic": Case(scene({**BALL, "material": GLASS}, FLOOR, bounces=4, lights=[
        {"type": "disklight", "position": [-1.5, 2.0, 1.0], "normal": [1.2, -2.3, -1.2], "radius": 0.3,
         "intensity": [50, 40, 30]}]), "scene.shapes.0.material.bsdf.ior", 1.52, 512),
    "nested_glass": Case(scene(
        {"type": "sphere", "center": [0.1, 0, 0], "radius": 0.8, "material": plain("dielectric", ior=1.33)},
        {"type": "sphere", "center": [0.2, 0, 0.1], "radius": 0.5, "material": plain("dielectric", ior=1.7)},
        FLOOR, lights=[LAMP], background=SKY, bounces=8), "scene.shapes.1.material.bsdf.ior", 1.6, 256),
    "mirrors": Case(scene(
        {"type": "rectangle", "center": [0.9, 0, 0.5], "u": [0.5, 0, 2], "v": [0, 1.6, 0.2], "material": MIRROR},
        {"type": "rectangle", "center": [-0.9, 0, 0.5], "u": [-0.4, 0, 2], "v": [0.1, 1.6, 0.2], "material": MIRROR},
        BALL, FLOOR, lights=[LAMP], background=SKY, bounces=8),
        "scene.shapes.0.material.bsdf.reflectance", times(0.99)),
    "environment": surrounded(BALL, FLOOR),
    "environment_rotation": surrounded(BALL, FLOOR, path="scene.lightsources.0.rotation", value=26.0),
    "environment_mirror": surrounded({**BALL, "material": MIRROR}),
    "environment_glossy": surrounded({**BALL, "material": plain("roughconductor", alpha=0.1)}, FLOOR, samples=512),
    "environment_above": surrounded(BALL, FLOOR, camera={"position": [0.3, 3.9, -1.0], "fov": 60.0}),
    "texture_rectangle": textured(PANE, "scaleU", times(1.02), **plain("diffuse", reflectance="texture.png")),
    "texture_nearest": textured(PANE, "texturefilter", "bilinear", texturefilter="nearest",
                                **plain("diffuse", reflectance="texture.png")),
    "texture_clamp": textured(PANE, "texturewrap", "repeat", texturewrap="clamp",
                              **plain("diffuse", reflectance="texture.png")),
    "texture_sphere": textured(SHAPES["sphere"], "scaleU", times(1.02), **plain("plastic", reflectance="texture.png")),
    "texture_disk": textured({"type": "disk", "center": [0.1, 0.1, 0], "normal": [0.5, 0.3, -1], "radius": 0.8},
                             "scaleV", times(1.02), **plain("mirror", reflectance="texture.png")),
    "texture_coursework": textured(SHAPES["box"], "kd", times(1.02), texture="texture.png", kd=0.7, ks=0.3),
    "texture_board": textured(PANE, "bsdf.reflectance.scale", times(1.02), **plain("diffuse", reflectance=BOARD)),
    "texture_alpha": textured(PANE, "bsdf.alpha", "grey.png", **plain("roughconductor", alpha="numbers.png")),
    "texture_alpha_board": textured(PANE, "bsdf.alpha.color2", [0.5, 0.5, 0.5], **plain("roughconductor", alpha=DULL)),
    "texture_glass_alpha": textured(SHAPES["sphere"], "bsdf.alpha", "grey.png",
                                    **plain("roughdielectric", alpha="numbers.png")),
    "texture_principled": textured(SHAPES["box"], "scaleV", times(1.02), **plain(
        "principled", basecolor="texture.png", roughness="grey.png", metallic="numbers.png")),
    "normalmap_rectangle": textured(PANE, "scaleU", times(1.03), sky=DIM, normalmap="normals.png", **CHALK),
    "normalmap_sphere": textured(SHAPES["sphere"], "scaleU", times(1.03), sky=DIM, normalmap="normals.png", **CHALK),
    "normalmap_triangle": textured(SHAPES["triangle"], "scaleV", times(1.03), sky=DIM, normalmap="normals.png",
                                   **plain("roughconductor", alpha=0.3)),
    "normalmap_mesh": textured(mesh("lump.ply", {}, normals="flat"), "scaleV", times(1.1), sky=DIM,
                               normalmap="normals.png", **CHALK),
    "bumpmap_rectangle": textured(PANE, "bumpscale", times(1.2), sky=DIM, bumpmap="heights.png", bumpscale=0.1,
                                  **CHALK),
    "bumpmap_sphere": textured(SHAPES["sphere"], "bumpscale", times(1.4), sky=DIM, bumpmap="heights.png",
                               bumpscale=0.08, **CHALK),
    "bumpmap_metal": textured(PANE, "bumpscale", times(1.2), sky=DIM, bumpmap="heights.png", bumpscale=0.03,
                              **plain("roughconductor", alpha=0.3)),
    "mesh": Case(scene({**mesh("lump.ply", CHALK, {"scale": 0.8}), "normals": "flat"}, FLOOR, lights=[LAMP],
                       background=SKY), "scene.shapes.0.transform.0.scale", 0.806, 256, (write_files,)),
    "mesh_smooth": Case(scene(mesh("lump.ply", CHALK, {"scale": 0.8}, normals="smooth"), FLOOR, lights=[LAMP],
                              background=SKY), "scene.shapes.0.normals", "flat", 256, (write_files,)),
    "mesh_glass": Case(scene(mesh("lump.ply", GLASS, {"scale": 0.8}, normals="flat"), FLOOR, lights=[LAMP],
                             background=SKY, bounces=8), "scene.shapes.0.material.bsdf.ior", 1.52, 256, (write_files,)),
    "everything": Case(scene(
        *room({"type": "sphere", "center": [0.45, -0.65, -0.4], "radius": 0.35, "material": GLASS},
              {**BLOCK, "material": plain("principled", roughness=0.4, clearcoat=0.8)},
              {"type": "cylinder", "center": [-0.4, 0.2, 0.2], "axis": [0.2, 1, 0], "radius": 0.2, "height": 0.3,
               "material": plain("roughconductor", alpha=0.2)},
              {"type": "sphere", "center": [0.6, 0.3, 0.3], "radius": 0.2, "material": GREY, "emission": [2, 1, 1]},
              {"type": "convex", "vertices": [[0.1, -1, 0.3], [0.7, -1, 0.3], [0.4, -1, 0.8], [0.4, -0.3, 0.5]],
               "material": {"kd": 0.5, "ks": 0.4, "isreflective": True, "reflectivity": 0.3, "roughness": 0.2}}),
        lights=[CEILING, {"type": "spot", "position": [-0.8, 0.8, -0.8], "direction": [0.6, -0.9, 0.7],
                          "intensity": [1, 2, 3]}],
        camera={**INTO_ROOM, "type": "thinlens", "apertureRadius": 0.05, "focusDistance": 3.2}, bounces=6),
        INTENSITY, times(1.02), 512),
}


REACH = 2  # pixels: radius of the widest filter; nearer to the edge Mitsuba lacks samples, and ours do not


def filtered(name):
    """Return the Case of a filter: things with edges, and the box filter in the twin."""
    return Case(scene(BALL, FLOOR, lights=[LAMP], background=SKY, filter=name), "filter", "box", 256)


@pytest.mark.parametrize("name", ["tent", "gaussian", "mitchell"])
def test_filter(judge, name):
    """The mean picture under a filter is Mitsuba's, which spreads samples over pixels; that under another is not."""
    case = filtered(name)
    right, wrong = (cut(ours(judge.load(case, document), case.samples))
                    for document in (case.document, changed(case.document, case.path, case.value)))
    theirs = cut(judge.reference(case))
    demand_equal(right, theirs)
    assert compare(wrong, theirs).refused


def cut(pictures):
    """Return pictures without their edges."""
    return pictures[:, REACH:-REACH, REACH:-REACH]


def test_render_command_path(judge):
    """What `render` makes in passes, by the scene's seeds and sampler, is that picture too."""
    case = CASES["sobol"]
    loaded = override(judge.load(case, case.document), samples=case.samples // 2)
    pictures = [np.stack([render(loaded, seed=seed).channels()[c] for c in "RGB"], axis=-1) for seed in range(16)]
    demand_equal(np.array(pictures), judge.reference(case))


@pytest.mark.parametrize("name", CASES)
def test_scene(judge, name):
    """Our picture has Mitsuba's expectation, and the twin has not."""
    judge.decide(CASES[name])
