"""Figures and numbers of the part `intermediate` of the report: textures, and the hierarchy of bounding volumes."""

from __future__ import annotations

from pathlib import Path

import drjit as dr
import numpy as np

from benchmarks.lanes import vectors
from benchmarks.mesh_rays import ray_sets
from benchmarks.mesh_scenes import bumpy
from benchmarks.rays import primary_rays
from renderer.accel.records import LEAF, TAG, WORDS
from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.numeric import FAR
from renderer.core.records import NO_SHAPE, Ray
from renderer.io import mesh_ply
from renderer.scene.geometry import Geometry
from renderer.scene.loader import load
from renderer.scene.meshes import plain_triangles
from renderer.scene.structures import structure_over
from renderer.scene.tables import compile_camera, compile_scene
from tests.accel import build_inputs
from tools import testsuite
from tools.report import pairs
from tools.report.results import ROOT, digits, percent, times
from tools.report.results import cost as feature_cost

CAMERA = {"fov": 28, "position": [0, 1.5, -6.4], "lookAt": [-0.12, -0.05, 0]}
LIGHT = {"type": "pointlight", "position": [-3, 4, -4], "intensity": [0.6, 0.6, 0.56]}
WORLD = {"backgroundcolor": [0.3, 0.36, 0.44], "lightsources": [LIGHT]}
FLOOR = {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0],
         "material": {"diffusecolor": [0.7, 0.7, 0.7], "ks": 0}}  # fmt: skip
MESH = 100_000  # triangles of the mesh in the picture
SIZES = (1_000, 10_000, 100_000, 1_000_000)  # triangles of the meshes through which steps are counted
RAYS = 200, 150  # of each set for that
SWEPT = 10_000  # primitives of the trees beside those of a full sweep


def make(folder: Path) -> dict:
    """Return the part's numbers."""
    return textures(folder) | hierarchy(folder) | steps() | quality() | cost()


def textures(folder):
    """Draw all three shapes with textures; the colours alone are compared, too."""
    found = pairs.pair(folder, "textures", "features", document=textured())
    colours = pairs.both(pairs.prepared("features", mode="albedo", document=textured()))
    return found | pairs.agreement("albedo", colours.ours - testsuite.coarse(colours.theirs), colours)


def textured():
    """Return a scene of a sphere, two cylinders, a quad of two triangles and one triangle more, all textured."""
    def shape(kind, picture, settings, **places):
        return {"type": kind, **places, "material": {"texture": f"../textures/{picture}", "ks": 0.15, **settings}}

    corners = [-0.05, -1, 0.35], [0.85, -1, 0.85], [0.85, 0.7, 0.85], [-0.05, 0.7, 0.35]
    uv = [0, 1], [1, 1], [1, 0], [0, 0]
    quad = [{f"v{k}": corners[c] for k, c in enumerate(half)} | {f"uv{k}": uv[c] for k, c in enumerate(half)}
            for half in ((0, 1, 2), (0, 2, 3))]  # fmt: skip
    shapes = [
        FLOOR,
        shape("sphere", "globe.png", {}, center=[-1.45, -0.15, 0], radius=0.85),
        *(shape("triangle", "bricks.jpg", {"scaleU": 2, "scaleV": 2}, **half) for half in quad),
        shape("triangle", "pixels.ppm", {"texturefilter": "nearest"}, v0=[0.1, -1, -0.9], v1=[0.8, -1, -0.6],
              v2=[0.35, -0.25, -0.5]),
        shape("cylinder", "letter.png", {"scaleU": 4, "scaleV": 2}, center=[1.55, -0.4, 0.1], axis=[0, 1, 0],
              radius=0.5, height=0.6),
        shape("cylinder", "globe.png", {}, center=[1.5, 0.66, 0.2], axis=[0.8, 0.3, -1], radius=0.32, height=0.4),
    ]  # fmt: skip
    return {"rendermode": "phong", "camera": CAMERA, "scene": {**WORLD, "shapes": shapes}}


def hierarchy(folder):
    """Draw a mesh of many triangles, and through how many records its rays went."""
    vertices, faces = bumpy(MESH)
    mesh_ply.write(folder / "bumpy.ply", vertices, faces)
    mesh = {"type": "mesh", "filename": str((folder / "bumpy.ply").resolve()),
            "material": {"diffusecolor": [0.72, 0.6, 0.42], "ks": 0.25, "specularexponent": 30}}  # fmt: skip
    camera = {"position": [0, 0.45, 1.9], "lookAt": [0, 0, 0], "fov": 62}
    light = {**LIGHT, "position": [-2, 3, 2.5], "intensity": [0.75, 0.75, 0.7]}
    document = {"rendermode": "phong", "camera": camera,
                "scene": {**WORLD, "lightsources": [light], "shapes": [mesh]}}  # fmt: skip
    found = pairs.pair(folder, "mesh", "features", document=document)
    loaded = pairs.prepared("features", document=document)
    rays = primary_rays(compile_camera(loaded.description.camera), *pairs.SIZE)
    count = walked(compile_scene(loaded), rays.o, rays.d)[0].reshape(pairs.SIZE[1], pairs.SIZE[0])
    most = int(np.ceil(count.max() / 10) * 10)
    write_counts(folder / "mesh_steps", count / most)
    return found | {"mesh_triangles": f"{len(faces):,}", "mesh_steps_scale": str(most),
                    "mesh_steps_mean": digits(count.mean()), "mesh_steps_most": str(int(count.max()))}  # fmt: skip


def write_counts(path, shares):
    """Write numbers of records, as shares of the most, as a picture."""
    import matplotlib

    pairs.write(path, matplotlib.colormaps["magma_r"](shares)[..., :3], False)


def geometry_of(vertices, faces):
    """Return the Geometry of one mesh in the hierarchy."""
    triangles = plain_triangles(vertices, faces)
    return Geometry((), triangles, structure_over(triangles), 1)


def walked(geometry, o, d):
    """Return for rays (N, 3) how many records each of them reads on its way to the closest hit, and how many leaves."""
    ray, tree = Ray(vectors(Vector3f, Float, o), vectors(Vector3f, Float, d)), geometry.structure
    slabs, leaf, lanes = tree.slabs(ray), geometry.leaf_test(ray), len(o)
    state = (tree.start(lanes), dr.full(Float, FAR, lanes), dr.full(UInt32, NO_SHAPE, lanes),
             dr.full(Bool, True, lanes), dr.zeros(UInt32, lanes), dr.zeros(UInt32, lanes))  # fmt: skip

    def step(walk, t, index, active, records, leaves):
        words = tree.fetch(walk, active)
        at_leaf = dr.select(words[TAG] >= LEAF, UInt32(1), 0)
        walk, t, index, goes_on = tree.step(walk, words, slabs, t, index, leaf, active, False)
        return walk, t, index, goes_on, records + 1, leaves + at_leaf

    found = dr.while_loop(state, lambda walk, t, index, active, *_: active, step, label="counted")
    return found[4].numpy().astype(float), found[5].numpy().astype(float)


@pairs.slow(lambda: {"steps": [["1"] * 6], "steps_grow": "1", "triangles_grow": "1"})
def steps():
    """Return how many records rays read in meshes of ever more triangles, and how large they are."""
    rows, mean = [], {}
    for size in SIZES:
        vertices, faces = bumpy(size)
        geometry = geometry_of(vertices, faces)
        held = len(geometry.structure._records) // WORDS
        cells = [f"{len(faces):,}", digits(held / len(faces), 3)]
        sets = {rays.name: next(iter(rays.orders.values())) for rays in ray_sets(vertices, faces, *RAYS)}
        for name in ("primary", "bounce"):
            records, leaves = walked(geometry, sets[name].o, sets[name].d)
            mean[name, size] = records.mean()
            cells += [digits(records.mean(), 3), digits(leaves.mean(), 2)]
        rows.append(cells)
    first, last = SIZES[0], SIZES[-1]
    return {"steps": rows, "steps_grow": times(mean["bounce", last] / mean["bounce", first]),
            "triangles_grow": f"{last // first:,}"}  # fmt: skip


@pairs.slow(lambda: dict.fromkeys(("sweep_least", "sweep_most", "swept", "moved_least", "moved_most"), "1"))
def quality():
    """Return what a random ray visits in our trees, beside those of a full sweep, and those before subtrees move."""
    from renderer.accel.build import build

    ratio, moved = [], []
    for make_input in build_inputs.INPUTS.values():
        lo, hi = make_input(SWEPT)
        lanes = build_inputs.vector(lo), build_inputs.vector(hi)
        dr.eval(lanes)
        ours, before = (build_inputs.cost(build(*lanes, 4, rounds)) for rounds in (4, 0))
        ratio.append(ours / build_inputs.yardstick_cost(lo, hi, 4))
        moved.append(1 - ours / before)
    return {"sweep_least": digits(min(ratio), 2), "sweep_most": digits(max(ratio), 2), "swept": f"{SWEPT:,}",
            "moved_least": percent(min(moved)), "moved_most": percent(max(moved))}  # fmt: skip


def cost():
    """Return which share of the time without a structure the hierarchy takes in its smallest scene, and its size."""
    shapes = load(str(ROOT / "scenes" / "features" / "shape_triangle_soup.json")).shapes
    triangles = sum(shape.type == "triangle" for _, shape in shapes)
    return {"hierarchy_times": feature_cost("intermediate.hierarchy")["share"], "soup_triangles": f"{triangles:,}"}
