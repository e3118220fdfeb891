"""Scenes of the report's pages on path tracing that show several things at once, as documents of the scene format."""

from __future__ import annotations

import json

import numpy as np

from tools.report.results import ROOT

FOLDER = "features"  # below scenes/, from where the documents name their files
GOLD = {"eta": [0.143, 0.375, 1.442], "k": [3.983, 2.386, 1.603]}
BALLS = (  # from left to right, the front row first
    {"bsdf": {"type": "diffuse", "reflectance": [0.7, 0.25, 0.2]}},
    {"diffusecolor": [0.25, 0.4, 0.6], "ks": 0.6, "specularexponent": 80},
    {"bsdf": {"type": "plastic", "reflectance": [0.1, 0.35, 0.15]}},
    {"bsdf": {"type": "dielectric", "ior": 1.5}},
    {"bsdf": {"type": "roughdielectric", "ior": 1.5, "alpha": 0.15}},
    {"bsdf": {"type": "mirror"}},
    {"bsdf": {"type": "conductor", **GOLD}},
    {"bsdf": {"type": "roughconductor", "alpha": 0.15}},
    {"bsdf": {"type": "roughconductor", "alpha": 0.35, "distribution": "beckmann", **GOLD}},
    {"bsdf": {"type": "principled", "basecolor": [0.55, 0.1, 0.15], "roughness": 0.6, "clearcoat": 1, "sheen": 0.5}},
)
A_ROW = 5
ROUGHNESS = 0.01, 0.04, 0.12, 0.3  # of the plates, from the nearest
RADII = 0.06, 0.18, 0.45, 0.9  # of the spheres above them
CELL, DEPTH, THICK = (1.5, 1.2), 1.3, 0.05  # of the niches: width and height, depth, and walls


def file(name: str) -> dict:
    """Return the document of a scene below scenes/."""
    return json.loads((ROOT / "scenes" / f"{name}.json").read_text())


def diffuse(*reflectance: float) -> dict:
    """Return a matt material."""
    return {"bsdf": {"type": "diffuse", "reflectance": list(reflectance)}}


def bsdfs() -> dict:
    """Return a scene with a ball of every kind of BSDF, in two rows, under a lamp and an image of a sky."""
    board = {"type": "checkerboard", "color1": [0.32, 0.34, 0.38], "color2": [0.62, 0.6, 0.56], "scale": 1.5}
    shapes = [{"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0],
               "material": {"bsdf": {"type": "diffuse", "reflectance": board}}},
              {"type": "box", "min": [-3.1, 0, 0.3], "max": [3.1, 0.7, 1.6],
               "material": diffuse(0.45, 0.44, 0.42)}]  # fmt: skip
    for k, material in enumerate(BALLS):
        row, column = divmod(k, A_ROW)
        center = [1.2 * (column - (A_ROW - 1) / 2), 0.5 + 0.7 * row, -0.75 + 1.65 * row]
        shapes.append({"type": "sphere", "center": center, "radius": 0.5, "material": material})
    lamp = {"type": "arealight", "position": [-2.6, 4.6, -2.6], "u": [1.4, 0, 0], "v": [0, 0.7, 1.2],
            "intensity": [12, 11.5, 10.5]}  # fmt: skip
    sky = {"type": "environment", "filename": "../textures/sky.exr", "rotation": 20}
    camera = {"fov": 18.5, "position": [0, 2.8, -9.6], "lookAt": [0, 0.68, 0]}
    return {"rendermode": "pathtracer", "nbounces": 8, "filter": "gaussian", "camera": camera,
            "scene": {"lightsources": [lamp, sky], "shapes": shapes}}  # fmt: skip


def lights() -> dict:
    """Return niches, in two rows of four, with a light of a kind of its own and a ball in each."""
    width, height = CELL
    wall, back = diffuse(0.62, 0.6, 0.57), 0.5 * DEPTH
    shapes = [{"type": "rectangle", "center": [0, height, back], "u": [4 * width, 0, 0], "v": [0, 2 * height, 0],
               "material": wall}]  # fmt: skip
    for k in range(5):
        x = (k - 2) * width
        shapes.append({"type": "box", "min": [x - THICK, 0, -back], "max": [x + THICK, 2 * height, back],
                       "material": wall})  # fmt: skip
    for k in range(3):
        y = k * height
        shapes.append({"type": "box", "min": [-2 * width, y - THICK, -back], "max": [2 * width, y + THICK, back],
                       "material": wall})  # fmt: skip
    lamps = []
    for k in range(8):
        row, column = divmod(k, 4)
        middle = np.array([(column - 1.5) * width, (1 - row) * height + 0.5 * height, 0.0])
        shapes.append({"type": "sphere", "center": (middle - [0, 0.28, 0]).tolist(), "radius": 0.25,
                       "material": diffuse(0.7, 0.7, 0.7)})  # fmt: skip
        light = _light(k, middle)
        (lamps if "material" not in light else shapes).append(light)
    camera = {"fov": 22.5, "position": [0, height, -7.2], "lookAt": [0, height, 0]}
    return {"rendermode": "pathtracer", "nbounces": 6, "filter": "gaussian", "camera": camera,
            "scene": {"backgroundcolor": [0.02, 0.02, 0.025], "lightsources": lamps, "shapes": shapes}}  # fmt: skip


def _light(number, middle):
    """Return the light of a niche with this middle."""
    def at(x, y, z):
        return (middle + [x, y, z]).tolist()

    black = diffuse(0.05, 0.05, 0.05)
    return [
        {"type": "pointlight", "position": at(-0.3, 0.35, -0.3), "intensity": [1.1, 1.0, 0.85]},
        {"type": "spot", "position": at(-0.45, 0.42, -0.45), "direction": [0.45, -0.72, 0.45], "cutoff": 30,
         "intensity": [6.0, 6.4, 7.6]},
        {"type": "arealight", "position": at(0, 0.5, -0.1), "u": [0.5, 0, 0], "v": [0, 0, 0.3], "twosided": False,
         "intensity": [8.0, 7.5, 6.8]},
        {"type": "disklight", "position": at(0, 0.48, -0.1), "normal": [0.3, -1, 0], "radius": 0.16,
         "intensity": [12.0, 8.0, 4.0]},
        {"type": "sphere", "center": at(0.4, 0.2, -0.2), "radius": 0.1, "emission": [9.0, 10.0, 14.0],
         "material": black},
        {"type": "mesh", "filename": "../meshes/torus.obj", "emission": [6.0, 4.4, 2.4], "material": black,
         "transform": [{"scale": 0.22}, {"rotate": {"axis": [1, 0, 0.3], "angle": 60}},
                       {"translate": at(0, 0.32, 0.1)}]},
        {"type": "triangle", "v0": at(-0.6, 0.0, 0.45), "v1": at(-0.2, 0.1, 0.6), "v2": at(-0.45, 0.5, 0.55),
         "emission": [4.0, 9.0, 6.0], "material": black},
        {"type": "box", "min": at(0.25, 0.1, 0.0), "max": at(0.5, 0.35, 0.25), "emission": [5.0, 3.0, 5.0],
         "material": black},
    ][number]  # fmt: skip


def plates() -> dict:
    """Return four plates of growing roughness that reflect four spheres of growing size and equal power [Veach1997]."""
    eye, lamp = np.array([0.0, 1.5, -8.0]), np.array([0.0, 3.9, 3.5])
    shapes = [{"type": "plane", "point": [0, -2, 0], "normal": [0, 1, 0], "material": diffuse(0.3, 0.3, 0.3)}]
    for k, alpha in enumerate(ROUGHNESS):
        middle = np.array([0.0, -1.3 + 0.55 * k, -1.6 + 1.25 * k])
        towards = [(place - middle) / np.linalg.norm(place - middle) for place in (eye, lamp)]
        normal = sum(towards) / np.linalg.norm(sum(towards))
        across = np.cross(normal, [1.0, 0.0, 0.0])
        shapes.append({"type": "rectangle", "center": middle.tolist(), "u": [6.4, 0, 0], "v": (1.1 * across).tolist(),
                       "material": {"bsdf": {"type": "roughconductor", "alpha": alpha}}})  # fmt: skip
    for k, radius in enumerate(RADII):
        place = (lamp + [2.3 * (k - 1.5), 0, 0]).tolist()
        shapes.append({"type": "sphere", "center": place, "radius": radius, "emission": [2.0 / radius**2] * 3,
                       "material": diffuse(0.0, 0.0, 0.0)})  # fmt: skip
    camera = {"fov": 36, "position": eye.tolist(), "lookAt": [0, 1.35, 0]}
    return {"rendermode": "pathtracer", "nbounces": 2, "sampler": "independent", "camera": camera,
            "scene": {"backgroundcolor": [0.0] * 3, "lightsources": [], "shapes": shapes}}  # fmt: skip
