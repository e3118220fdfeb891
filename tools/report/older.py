"""Figures and numbers of the part `older` of the report: what only the older assignment sheet asks for."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from renderer.engine.render import render
from renderer.io.mesh import read_mesh
from renderer.scene.loader import from_dict, override
from tools import testsuite
from tools.report import pairs
from tools.report.results import ROOT, cost, percent

WORLD = {"backgroundcolor": [0.3, 0.36, 0.44],
         "lightsources": [{"type": "pointlight", "position": [-3, 5, -4], "intensity": [0.65, 0.65, 0.6]}]}  # fmt: skip
HALF_SPACES = [[1, 0, 0, 0.75], [-1, 0, 0, 0.75], [0, 1, 0, 0.8], [0, -1, 0, 0.8], [0, 0, 1, 0.75], [0, 0, -1, 0.75],
               *([x, y, z, 1.6] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1))]  # fmt: skip
GOLDEN = 1.618
HULL = [corner for a in (-GOLDEN, GOLDEN) for b in (-1, 1) for corner in ([0, a, b], [b, 0, a], [a, b, 0])]
COSTS = {"intermediate.textures": "texture, on a sphere", "intermediate.bilinear": "bilinear beside nearest",
         "intermediate.hierarchy": "hierarchy", "older.grid": "uniform grid", "older.plane": "plane",
         "older.box": "box", "older.convex": "convex volume", "older.mesh": "mesh",
         "older.soft_shadows": "soft shadows", "older.glossy": "glossy reflection"}  # fmt: skip
SOFT = "soft_shadows"
SOFT_SAMPLES = 1024  # a pixel of our soft shadows
POINTS, RAYS = 10, 4  # of Mitsuba, along a side: lights in the place of a lamp, rays through a pixel
SOFT_SIZE = 300, 200


def make(folder: Path) -> dict:
    """Return the part's numbers."""
    found = pairs.pair(folder, "solids", "features", document=solids())
    found |= pairs.pair(folder, "meshes", "features", document=meshes()) | pairs.pair(folder, "teapot", "teapot")
    teapot = read_mesh(str(ROOT / "scenes" / "meshes" / "teapot.ply"))
    found |= {"teapot_triangles": f"{len(teapot.faces):,}"} | soft_shadows(folder) | glossy(folder)
    return found | {"costs": costs()}


def costs():
    """Return what features cost, as benchmarks/features.py measured it: a sample, and as ratio of with to without."""
    rows = []
    for key, told in COSTS.items():
        found = cost(key)
        rows.append([told, found["ns"], found["ratio"]])
    return rows


def solids():
    """Return a scene of planes, a box and convex volumes, all textured."""
    def material(picture, **settings):
        return {"texture": f"../textures/{picture}", "ks": 0.1, **settings}

    board = {"type": "checkerboard", "color1": [0.75, 0.74, 0.7], "color2": [0.4, 0.42, 0.44], "scale": 1.0}
    hull = [[0.5 * c + m for c, m in zip(corner, (1.75, -0.12, -0.1))] for corner in HULL]
    cut = [[*n, d + n[0] * 0.05 - n[1] * 0.2 + n[2] * 0.5] for *n, d in HALF_SPACES]
    shapes = [
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": {"texture": board, "ks": 0}},
        {"type": "plane", "point": [0, 0, 5], "normal": [0.25, 0, -1],
         "material": material("bricks.jpg", scaleU=0.4, scaleV=0.6)},
        {"type": "box", "min": [-2.5, -1, -0.4], "max": [-1.1, 0.3, 0.7], "material": material("letter.png")},
        {"type": "convex", "halfspaces": cut, "material": material("bricks.jpg", scaleU=1.2, scaleV=1.2)},
        {"type": "convex", "vertices": hull, "material": material("letter.png", scaleU=1.1, scaleV=1.1)},
    ]
    camera = {"fov": 33, "position": [0.4, 1.7, -6.6], "lookAt": [0.05, -0.15, 0]}
    return {"rendermode": "phong", "camera": camera, "scene": {**WORLD, "shapes": shapes}}


def meshes():
    """Return a scene of meshes from files of every format, on a plane."""
    def mesh(name, *steps, material):
        return {"type": "mesh", "filename": f"../meshes/{name}", "transform": [*steps], "material": material}

    shapes = [
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": {"diffusecolor": [0.7] * 3, "ks": 0}},
        mesh("rock.ply", {"scale": 0.8}, {"rotate": {"axis": [0, 1, 0], "angle": 25}},
             {"translate": [-1.75, -0.2, 0.2]}, material={"diffusecolor": [0.5, 0.66, 0.75], "ks": 0.2}),
        mesh("torus.obj", {"rotate": {"axis": [1, 0, 0], "angle": -60}}, {"scale": 0.75}, {"translate": [0, -0.2, 0.1]},
             material={"texture": "../textures/letter.png", "scaleU": 8, "scaleV": 3, "ks": 0.2}),
        mesh("teapot.ply", {"scale": 0.42}, {"rotate": {"axis": [0, 1, 0], "angle": 30}}, {"translate": [1.75, -1, 0]},
             material={"diffusecolor": [0.72, 0.38, 0.22], "ks": 0.5, "specularexponent": 120}),
    ]  # fmt: skip
    camera = {"fov": 32, "position": [0, 1.6, -6.6], "lookAt": [0.3, -0.25, 0]}
    return {"rendermode": "phong", "camera": camera, "scene": {**WORLD, "shapes": shapes}}


def soft_document(*, blurred=True, lights=None):
    """Return the scene of soft shadows with a box filter; if asked, sharp mirrors and a plain floor, other lights."""
    document = json.loads((ROOT / "scenes" / f"{SOFT}.json").read_text())
    document["filter"] = "box"
    if lights is not None:
        document["scene"]["lightsources"] = lights
    if not blurred:
        for shape in document["scene"]["shapes"]:
            for key in ("roughness", "texture"):
                shape["material"].pop(key, None)
    return document


def soft_shadows(folder):
    """Draw the shadows of a lamp, and Mitsuba's of many points in its place; mirrors are sharp in both."""
    ours = pairs.alone(_loaded(soft_document(blurred=False), SOFT_SIZE, SOFT_SAMPLES))
    theirs = of_points()
    found = pairs.Both(ours, theirs)
    for ending, shown in (("ours", ours), ("mitsuba", theirs), ("difference", pairs.coloured(ours - theirs))):
        pairs.write(folder / f"soft_{ending}", shown, ending != "difference")
    told = {"lamp_points": f"{POINTS**2}", "lamp_rays": f"{RAYS**2}", "lamp_samples": f"{SOFT_SAMPLES:,}"}
    return pairs.agreement("soft", ours - theirs, found) | told


@pairs.slow(lambda: np.full((*SOFT_SIZE[::-1], 3), 0.5))
def of_points():
    """Return Mitsuba's picture under point lights, each pixel the mean of RAYS x RAYS rays through its equal parts."""
    from converters.whitted import reference

    (lamp,) = soft_document()["scene"]["lightsources"]
    loaded = _loaded(soft_document(blurred=False, lights=points_of(lamp)), [RAYS * size for size in SOFT_SIZE], 1)
    fine = reference(loaded)["rgb"]
    mean = fine.reshape(SOFT_SIZE[1], RAYS, SOFT_SIZE[0], RAYS, 3).mean((1, 3))
    return testsuite.coarse(testsuite.toned(mean, loaded.description))


def points_of(lamp):
    """Return point lights in the middles of equal parts of a rectangular lamp, together as bright as it is."""
    middle, u, v = (np.array(lamp[key]) for key in ("position", "u", "v"))
    places = (np.arange(POINTS) + 0.5) / POINTS - 0.5
    intensity = [value / POINTS**2 for value in lamp["intensity"]]
    return [{"type": "pointlight", "position": (middle + x * u + y * v).tolist(), "intensity": intensity}
            for x in places for y in places]  # fmt: skip


def _loaded(document, size, samples):
    """Return the loaded scene."""
    loaded = from_dict(document, directory=str(ROOT / "scenes"))
    return override(loaded, width=size[0], height=size[1], samples=samples)


def glossy(folder):
    """Draw the same scene with rough mirrors, and tell how much of a wall's light a disk at half the lobe hides."""
    rough = pairs.alone(_loaded(soft_document(), SOFT_SIZE, SOFT_SAMPLES))
    pairs.write(folder / "glossy", rough, True)
    return half_of_the_lobe()


ROUGHNESS, WALL_SAMPLES = 0.2, 65536


@pairs.slow(lambda: dict.fromkeys(("lobe_share", "lobe_samples", "lobe_roughness"), "1"))
def half_of_the_lobe():
    """Return the share of light that a rough mirror, seen head-on, gets past a disk behind the eye.

    GGX normals at an angle a are seen with the density D cos, of which tan a < roughness holds half; they reflect to
    2 a, so a disk of that angle hides half of the light.
    """
    reach = float(4 * np.tan(2 * np.arctan(ROUGHNESS)))
    black = {"kd": 0.0, "ks": 0.0, "diffusecolor": [0, 0, 0]}
    shapes = [
        {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, -1],
         "material": {**black, "isreflective": True, "reflectivity": 1.0, "roughness": ROUGHNESS}},
        {"type": "disk", "center": [0, 0, -4.001], "normal": [0, 0, 1], "radius": reach, "material": black},
    ]  # fmt: skip
    camera = {"width": 1, "height": 1, "position": [0, 0, -4], "lookAt": [0, 0, 0], "fov": 1e-4}
    document = {"rendermode": "phong", "nbounces": 1, "camera": camera,
                "scene": {"backgroundcolor": [1, 1, 1], "ambientlight": [0, 0, 0], "shapes": shapes}}  # fmt: skip
    found = float(render(_loaded(document, (1, 1), WALL_SAMPLES)).channels()["R"][0, 0])
    return {"lobe_share": percent(found, 3), "lobe_samples": f"{WALL_SAMPLES:,}", "lobe_roughness": str(ROUGHNESS)}
