"""Each shape as a light source, path traced, against Mitsuba; and its light a little wrong on our side."""

import pytest

from tests.support.documents import SHAPES
from tests.support.meshes import lump, mesh, write
from tests.support.paths import Case, scene, times

pytestmark = pytest.mark.oracle

CHALK = {"bsdf": {"type": "diffuse", "reflectance": [0.8, 0.6, 0.4]}}
GREY = {"bsdf": {"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]}}
FLOOR = {"type": "rectangle", "center": [0, -0.9, 0], "u": [0, 0, 9], "v": [9, 0, 0], "material": GREY}
WALL = {"type": "rectangle", "center": [0, 0, 1.5], "u": [9, 0, 0], "v": [0, 9, 0], "material": CHALK}
BALL = {"type": "sphere", "center": [-1.1, -0.3, -0.6], "radius": 0.4, "material": CHALK}
LUMP = lump(80)
EMISSION = "scene.shapes.0.emission"
PANE = {"type": "rectangle", "center": [0.1, 0.1, 0.0], "u": [1.1, 0.2, 0.5], "v": [-0.2, 0.9, 0.1]}
SLANTED = {"type": "rectangle", "center": [0.1, 0.1, 0.0], "u": [1.1, 0.2, 0.5], "v": [0.4, 0.9, 0.1]}
DISK = {"type": "disk", "center": [0.1, 0.1, 0.0], "normal": [0.5, 0.3, -1], "radius": 0.6}
BOWL = {"type": "sphere", "center": [0, 0, 0], "radius": 6.0}  # with everything inside
OPEN = {"type": "triangle", "v0": [-0.8, 0.3, 0.1], "v1": [0.7, 0.2, -0.2], "v2": [0.1, 1.1, 0.3]}


def shining(shape, samples=256, material=GREY, others=(FLOOR, WALL, BALL), factor=1.01, **settings):
    """Return the Case of a shape that shines."""
    shape = {**shape, "material": material, "emission": [3.0, 2.5, 2.0]}
    return Case(scene(shape, *others, **settings), EMISSION, times(factor), samples, (write_lump,))


def write_lump(folder):
    """Write a mesh without vertex normals: by these Mitsuba decides which side shines, and not by the surface's own."""
    write(folder / "flat.ply", LUMP.but(normals=None))


CASES = {
    "sphere": shining(SHAPES["sphere"]),
    "sphere_small": shining({"type": "sphere", "center": [0.2, 0.6, -0.3], "radius": 0.05}, 256),
    "sphere_from_inside": shining(BOWL, 64, others=(FLOOR, BALL), background=[0.5, 0.5, 0.5], factor=1.01,
                                  camera={"position": [0.4, 3.9, -9.0]}),
    "cylinder": shining(SHAPES["cylinder"]),
    "triangle": shining(OPEN),
    "box": shining(SHAPES["box"]),
    "convex_vertices": shining(SHAPES["convex_vertices"]),
    "convex_halfspaces": shining(SHAPES["convex_halfspaces"]),
    "rectangle": shining(PANE),
    "rectangle_slanted": shining(SLANTED),
    "disk": shining(DISK),
    "plane": shining({"type": "plane", "point": [0, -0.9, 0], "normal": [0, 1, 0]}, 64, others=(WALL, BALL)),
    "mesh": shining(mesh("flat.ply", GREY, {"scale": 0.7})),
    "mesh_turned": shining(mesh("flat.ply", GREY, {"scale": [0.5, 0.7, 0.6]},
                                {"rotate": {"axis": [0, 0, 1], "angle": 40}})),
    "mesh_mirrored": shining(mesh("flat.ply", GREY, {"scale": [-0.5, 0.7, 0.6]})),
    "inside_glass": shining({"type": "sphere", "center": [0.0, 0.1, 0.0], "radius": 0.55}, 256, others=(
        {"type": "sphere", "center": [0.0, 0.1, 0.0], "radius": 0.8, "material": {"bsdf": {"type": "dielectric"}}},
        FLOOR, WALL), bounces=6),
    "bright_and_metallic": shining(SHAPES["sphere"], 256, {"bsdf": {"type": "roughconductor", "alpha": 0.2}},
                                   background=[0.6, 0.5, 0.4]),
}


@pytest.mark.parametrize("name", CASES)
def test_emitter(judge, name):
    """Our picture has Mitsuba's expectation, and light that is a little too bright does not."""
    judge.decide(CASES[name])
