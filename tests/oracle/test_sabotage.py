"""The comparisons have teeth: one small wrong thing on our side only, and the picture it shows in must be refused.

Our renderer draws the changed scene, Mitsuba the right one. Each row names the mistake that it stands for.
"""

import functools

import numpy as np
import pytest

from tests.support import oracle as sides
from tests.support.compare import Mismatch
from tests.support.documents import GLASS, GROUND, MIRROR, SHINY, changed, scene, shape, write_texture
from tests.support.meshes import lump, mesh, write
from tests.support.paths import times

pytestmark = pytest.mark.oracle

SIZE = 150, 100
TEXTURED = {**SHINY, "texture": "texture.png", "scaleU": 1.7, "scaleV": 1.3, "texturefilter": "bilinear"}
ROOM = {"type": "sphere", "center": [0.3, 0.2, 0.1], "radius": 8.0, "material": TEXTURED}
BALL = {"type": "sphere", "center": [-1.2, 0.1, -0.5], "radius": 0.5, "material": {"diffusecolor": [0.2, 0.5, 0.9]}}
WATER = {"type": "sphere", "center": [0.05, 0.1, 0.0], "radius": 1.2, "material": {**GLASS, "refractiveindex": 1.33}}
STRETCH, TURN = {"scale": [0.5, 1.1, 0.8]}, {"rotate": {"axis": [0.3, 1.0, -0.5], "angle": 70.0}}
SHEAR = {"matrix": [0.8, 0.4, 0, 0.1, 0, 0.7, 0, 0, 0, -0.3, 0.9, 0.2, 0, 0, 0, 1]}
RIGHT = lump(200)


def moved(index, offset):
    """Return the mesh with one vertex elsewhere."""
    vertices = RIGHT.vertices.copy()
    vertices[index] += offset
    return RIGHT.but(vertices=vertices)


MESHES = {  # file: what somebody could have made of the right one
    "right": RIGHT,
    "plain": RIGHT.but(normals=None),
    "plain_inside_out": RIGHT.but(normals=None).inside_out,
    "negated": RIGHT.but(normals=-RIGHT.normals),
    "matrix_for_normals": RIGHT.but(normals=RIGHT.normals * np.square(STRETCH["scale"])),  # not the inverse transpose
    "rolled_normals": RIGHT.but(normals=np.roll(RIGHT.normals, 1, axis=0)),  # those of the neighbouring vertex
    "rolled_uv": RIGHT.but(uv=np.roll(RIGHT.uv, 1, axis=0)),
    "flipped_v": RIGHT.but(uv=RIGHT.uv * [1, -1] + [0, 1]),
    "swapped_uv": RIGHT.but(uv=RIGHT.uv[:, ::-1]),
    "wrong_corners": RIGHT.unshared.but(uv=np.roll(RIGHT.unshared.uv.reshape(-1, 3, 2), 1, axis=1).reshape(-1, 2)),
    "hole": RIGHT.but(faces=np.delete(RIGHT.faces, RIGHT.vertices[RIGHT.faces].mean(1)[:, 2].argmin(), 0)),  # in front
    "dent": moved(RIGHT.vertices[:, 2].argmin(), [0, 0, 0.01]),  # of the vertex nearest to the camera
}
BASES = {
    "mesh": scene(mesh("right.ply", SHINY), GROUND),
    "mesh_plain": scene(mesh("plain.ply", SHINY), GROUND),
    "mesh_smooth": scene(mesh("plain.ply", SHINY, normals="smooth"), GROUND),
    "mesh_stretched": scene(mesh("right.ply", SHINY, STRETCH, TURN), GROUND),
    "mesh_mirrored": scene(mesh("right.ply", SHINY, TURN, {"scale": [-0.9, 1, 1]}), GROUND),
    "mesh_sheared": scene(mesh("right.ply", SHINY, SHEAR), GROUND),
    "mesh_texture": scene(mesh("right.ply", TEXTURED), GROUND),
    "mesh_mirror": scene(mesh("right.ply", MIRROR), BALL, ROOM),
    "mesh_glass": scene(mesh("plain.ply", {**GLASS, "refractiveindex": 1.2}), BALL, ROOM),
    "meshes": scene(mesh("right.ply", SHINY, {"scale": 0.6}, {"translate": [-0.6, 0, 0]}),
                    mesh("plain.ply", {**SHINY, **BALL["material"]}, {"scale": 0.6}, {"translate": [0.6, 0, 0]})),
    "sphere": scene(shape("sphere"), GROUND),
    "cylinder": scene(shape("cylinder"), GROUND),
    "triangle": scene(shape("triangle"), GROUND),
    "plane": scene(shape("plane")),
    "box": scene(shape("box"), GROUND),
    "convex_halfspaces": scene(shape("convex_halfspaces"), GROUND),
    "convex_vertices": scene(shape("convex_vertices"), GROUND),
    "binary": scene(shape("cylinder"), shape("triangle"), mode="binary"),
    "shadow": scene(shape("box"), GROUND, lights=[([1.0, 3.0, -0.6], [0.9, 0.8, 0.7])]),
    "mirror": scene(shape("sphere", MIRROR), {**BALL, "material": MIRROR}, GROUND),
    "glass": scene(shape("sphere", GLASS), BALL, ROOM),
    "nested": scene(WATER, shape("box", {**GLASS, "refractiveindex": 1.7}), ROOM, nbounces=5),
    **{f"texture_{name}": scene(shape(name, TEXTURED)) for name in ("sphere", "cylinder", "triangle", "box")},
    "texture_clamp": scene(shape("triangle", {**TEXTURED, "texturewrap": "clamp"})),
    "checkerboard": scene(shape("sphere", {**SHINY, "texture": {"type": "checkerboard", "scale": 5.0}})),
}
FIRST = "scene.shapes.0."
MATERIAL = FIRST + "material."


def add_to(offset):
    """Return a function that adds to a number."""
    return lambda old: old + offset


def transposed(old):
    """Return the linear part of sixteen numbers transposed."""
    rows = np.reshape(old, (4, 4)).copy()
    rows[:3, :3] = rows[:3, :3].T.copy()
    return rows.ravel().tolist()


def add(*offset):
    """Return a function that moves a vector."""
    return lambda old: [x + d for x, d in zip(old, offset)]


def swap(first, second):
    """Return a function that exchanges two axes of a vector."""

    def exchange(old):
        new = list(old)
        new[first], new[second] = new[second], new[first]
        return new

    return exchange


SABOTAGE = [  # base scene, key that is wrong, wrong value, picture that must be refused
    ("sphere", "camera.position", swap(0, 2), "shape"),  # camera: axes swapped
    ("sphere", "camera.upVector", times(-1), "shape"),  # camera: upside down and mirrored
    ("cylinder", "camera.upVector", [0.02, 1, 0], "shape"),  # camera: rolled by a degree
    ("sphere", "camera.fov", times(1.5), "shape"),  # camera: fov taken as horizontal
    ("sphere", "camera.fov", times(1.005), "depth"),  # camera: half a percent off
    ("sphere", "camera.position", add(0, 0, 0.002), "depth"),  # camera: not quite there
    ("binary", "scene.shapes.0.height", times(0.5), "rgb"),  # binary: height taken as the whole length
    ("sphere", FIRST + "radius", times(1.001), "depth"),
    ("sphere", FIRST + "radius", times(1.02), "shape"),
    ("sphere", FIRST + "center", add(0.001, 0, 0), "normal"),
    ("sphere", FIRST + "center", swap(0, 1), "depth"),
    ("cylinder", FIRST + "height", times(2), "shape"),  # cylinder: the half length taken for the length
    ("cylinder", FIRST + "axis", swap(0, 2), "shape"),
    ("cylinder", FIRST + "axis", times(-1), "uv"),  # cylinder: upside down, same silhouette
    ("cylinder", FIRST + "axis", add(0.005, 0, 0), "normal"),  # cylinder: axis a quarter degree off
    ("triangle", FIRST + "v1", add(0, 0, 0.002), "normal"),
    ("triangle", FIRST + "uv1", add(0.002, 0), "uv"),
    ("plane", FIRST + "normal", times(-1), "normal"),  # plane: normal flipped
    ("plane", FIRST + "normal", add(0.002, 0, 0), "normal"),
    ("plane", FIRST + "point", add(0.002, 0, 0), "uv"),  # plane: uv from another origin
    ("box", FIRST + "max", add(0.002, 0, 0), "uv"),
    ("box", FIRST + "min", add(0, 0, -0.01), "depth"),
    ("convex_halfspaces", FIRST + "halfspaces.4.3", times(1.01), "depth"),
    ("convex_halfspaces", FIRST + "halfspaces.0", times(-1), "shape"),  # half-space on the wrong side
    ("convex_vertices", FIRST + "vertices.3", add(0, 0.01, 0), "normal"),
    ("mesh_plain", FIRST + "filename", "plain_inside_out.ply", "normal"),  # windings reversed
    ("mesh", FIRST + "filename", "negated.ply", "rgb"),
    ("mesh", FIRST + "filename", "rolled_normals.ply", "rgb"),
    ("mesh", FIRST + "filename", "rolled_uv.ply", "uv"),
    ("mesh", FIRST + "filename", "flipped_v.ply", "uv"),
    ("mesh", FIRST + "filename", "swapped_uv.ply", "uv"),
    ("mesh", FIRST + "filename", "wrong_corners.ply", "uv"),  # barycentric coordinates of another corner
    ("mesh", FIRST + "filename", "hole.ply", "depth"),
    ("mesh", FIRST + "filename", "dent.ply", "depth"),
    ("mesh", FIRST + "normals", "flat", "rgb"),
    ("mesh", FIRST + "normals", "smooth", "rgb"),
    ("mesh_smooth", FIRST + "normals", "file", "rgb"),  # flat for smooth
    ("mesh_stretched", FIRST + "transform", [TURN, STRETCH], "shape"),  # steps in reverse order
    ("mesh_stretched", FIRST + "transform.1.rotate.angle", times(-1), "shape"),  # rotation transposed
    ("mesh_stretched", FIRST + "transform.1.rotate.angle", add_to(0.1), "depth"),
    ("mesh_stretched", FIRST + "filename", "matrix_for_normals.ply", "rgb"),
    ("mesh_mirrored", FIRST + "transform.1.scale", [0.9, 1, 1], "shape"),  # not mirrored
    ("mesh_mirrored", FIRST + "filename", "negated.ply", "rgb"),
    ("mesh_sheared", FIRST + "transform.0.matrix", transposed, "shape"),
    ("mesh_sheared", FIRST + "transform.0.matrix.3", add_to(0.002), "depth"),
    ("mesh_texture", MATERIAL + "texture", "flipped.png", "albedo"),
    ("mesh_texture", FIRST + "filename", "flipped_v.ply", "rgb"),
    ("mesh_mirror", FIRST + "normals", "flat", "rgb"),
    ("mesh_glass", MATERIAL + "refractiveindex", 1.21, "rgb"),
    ("mesh_glass", FIRST + "normals", "smooth", "rgb"),
    ("meshes", "scene.shapes", lambda old: old[::-1], "shape"),  # numbers of the other mesh
    ("meshes", MATERIAL + "diffusecolor", [0.2, 0.5, 0.9], "albedo"),  # material of the neighbour
    ("sphere", MATERIAL + "diffusecolor", times(1.01), "albedo"),
    ("sphere", MATERIAL + "diffusecolor", times(1.01), "rgb"),  # one percent of a colour
    ("sphere", MATERIAL + "diffusecolor", swap(0, 2), "rgb"),  # red and blue exchanged
    ("sphere", MATERIAL + "kd", times(1.01), "rgb"),
    ("sphere", MATERIAL + "ks", times(1.01), "rgb"),
    ("sphere", MATERIAL + "ks", 0.0, "rgb"),  # highlight dropped
    ("sphere", MATERIAL + "specularexponent", times(1.01), "rgb"),
    ("sphere", MATERIAL + "specularcolor", swap(0, 2), "rgb"),
    ("sphere", "scene.ambientlight", [0.404, 0.404, 0.404], "rgb"),  # ambient term one percent off
    ("sphere", "scene.backgroundcolor", times(1.01), "rgb"),
    ("sphere", "scene.lightsources.1.intensity", times(1.01), "rgb"),
    ("sphere", "scene.lightsources.1.intensity", times(0), "rgb"),  # second light dropped
    ("sphere", "scene.lightsources.0.position", add(0.02, 0, 0), "rgb"),
    ("shadow", "scene.lightsources.0.position", [3.5, 3.0, -0.6], "rgb"),  # shadow elsewhere
    ("shadow", FIRST + "max", add(0, -0.05, 0), "rgb"),  # shadow a little shorter
    ("mirror", MATERIAL + "reflectivity", times(1.01), "rgb"),
    ("mirror", MATERIAL + "isreflective", False, "rgb"),
    ("mirror", "nbounces", 1, "rgb"),  # mirrors show each other only once
    ("mirror", "nbounces", 3, "rgb"),  # one bounce too few
    ("glass", MATERIAL + "refractiveindex", 1.51, "rgb"),
    ("glass", MATERIAL + "isrefractive", False, "rgb"),
    ("glass", MATERIAL + "reflectivity", times(1.01), "rgb"),
    ("glass", "nbounces", 3, "rgb"),
    ("nested", "scene.shapes.0.material.refractiveindex", 1.32, "rgb"),
    ("nested", "scene.shapes.1.material.refractiveindex", 1.7 * 1.33, "rgb"),  # containing medium ignored
    *[(f"texture_{name}", MATERIAL + "texture", "flipped.png", "albedo")
      for name in ("sphere", "cylinder", "triangle", "box")],
    ("texture_sphere", MATERIAL + "texture", "flipped.png", "rgb"),
    ("texture_sphere", MATERIAL + "texturefilter", "nearest", "albedo"),
    ("texture_sphere", MATERIAL + "scaleU", times(1.01), "albedo"),
    ("texture_triangle", MATERIAL + "texturewrap", "clamp", "albedo"),
    ("texture_clamp", MATERIAL + "texturewrap", "repeat", "albedo"),
    ("checkerboard", MATERIAL + "texture.color1", [0.01, 0.01, 0.01], "albedo"),
    ("checkerboard", MATERIAL + "texture.scale", times(1.1), "albedo"),
]


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    """A function that returns folder and Mitsuba's view of a base scene, made once each."""

    @functools.cache
    def get(base):
        folder = tmp_path_factory.mktemp(base)
        write_texture(folder / "texture.png")
        write_texture(folder / "flipped.png", flip=True)
        for name, model in MESHES.items() if base.startswith("mesh") else ():
            write(folder / f"{name}.ply", model)
        return folder, sides.Oracle(sides.prepare(sides.write(folder, BASES[base]), *SIZE))

    return get


@pytest.mark.parametrize("base", BASES)
def test_unharmed_scene_passes(right, base):
    """Without sabotage every picture of the base scene is accepted, so that what follows fails for its own reason."""
    _, oracle = right(base)
    for name in ("shape", "depth", "normal", "uv", "albedo", "rgb"):
        oracle.check(name, sides.observe(oracle.loaded, name))


IDS = [f"{base}-{key}-{number}" for number, (base, key, *_) in enumerate(SABOTAGE)]


@pytest.mark.parametrize(("base", "key", "value", "picture"), SABOTAGE, ids=IDS)
def test_sabotage_is_found(right, base, key, value, picture):
    """A scene that is wrong in one value on our side is refused."""
    folder, oracle = right(base)
    wrong = sides.prepare(sides.write(folder, changed(BASES[base], key, value), "wrong.json"), *SIZE)
    with pytest.raises(Mismatch):
        oracle.check(picture, sides.observe(wrong, picture))


def flip_normals(picture):
    """Return normals turned inwards."""
    return -picture


def shift_normals(picture):
    """Return normals turned by a twentieth of a degree."""
    turned = picture + [0.001, 0.0, 0.0]
    return turned / np.maximum(np.linalg.norm(turned, axis=-1, keepdims=True), 1e-9)


WRONG_PICTURES = [
    ("normal", flip_normals),
    ("normal", shift_normals),
    ("normal", lambda picture: picture[..., [0, 2, 1]]),  # axes swapped
    ("depth", lambda picture: 2 * picture),  # a dropped factor 2
    ("depth", lambda picture: 1.001 * picture),
    ("uv", lambda picture: picture * [1, -1] + [0, 1]),  # v upside down
    ("uv", lambda picture: picture[..., ::-1]),  # u and v swapped
    ("uv", lambda picture: picture + [0.001, 0]),
    ("albedo", lambda picture: 0.99 * picture),
    ("shape", lambda picture: picture + (picture != 0xFFFFFFFF)),  # numbered from 1
    ("shape", lambda picture: np.roll(picture, 1, axis=1)),  # one pixel to the side
    ("shape", lambda picture: picture[::-1]),  # rows from the bottom
    ("rgb", lambda picture: picture[:, ::-1]),  # mirrored
    ("rgb", lambda picture: 1.01 * picture),
    ("rgb", lambda picture: np.roll(picture, 1, axis=0)),  # one row too low
    ("rgb", lambda picture: np.clip(picture, 0, 1) ** (1 / 2.2)),  # encoded
    ("rgb", lambda picture: np.round(np.clip(picture, 0, 1) * 255) / 255),  # 8 bits
]


@pytest.mark.parametrize(("name", "spoil"), WRONG_PICTURES)
def test_wrong_picture_is_found(right, name, spoil):
    """A right scene whose picture is spoilt on our side is refused."""
    _, oracle = right("cylinder")
    with pytest.raises(Mismatch):
        oracle.check(name, spoil(sides.observe(oracle.loaded, name)))
