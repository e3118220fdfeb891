"""Small scene documents for tests, as the nested dictionaries that a JSON file holds."""

from __future__ import annotations

import copy

import numpy as np
from PIL import Image

CAMERA = {"type": "pinhole", "width": 240, "height": 160, "position": [0.4, 0.9, -4.0], "lookAt": [0.05, 0.1, 0.0],
          "upVector": [0.0, 1.0, 0.0], "fov": 34.0, "exposure": 0.1}
LIGHTS = ([2.5, 3.5, -3.0], [0.8, 0.7, 0.6]), ([-3.0, 2.0, -2.0], [0.2, 0.3, 0.4])
WHITE = {"kd": 0.8, "ks": 0.0, "diffusecolor": [0.8, 0.7, 0.5]}
SHINY = {"kd": 0.7, "ks": 0.4, "specularexponent": 30.0, "diffusecolor": [0.7, 0.4, 0.3],
         "specularcolor": [0.9, 1.0, 0.8]}
MIRROR = {**SHINY, "isreflective": True, "reflectivity": 0.7}
GLASS = {**SHINY, "isrefractive": True, "refractiveindex": 1.5, "reflectivity": 0.9}

# One of each kind, of about the same size, none aligned with anything that it need not be aligned with.
SHAPES = {
    "sphere": {"type": "sphere", "center": [0.1, 0.12, 0.0], "radius": 0.83},
    "cylinder": {"type": "cylinder", "center": [0.05, 0.1, 0.1], "axis": [0.6, 1.1, -0.7], "radius": 0.52,
                 "height": 0.71},
    "triangle": {"type": "triangle", "v0": [-1.1, -0.62, 0.3], "v1": [1.23, -0.44, -0.2], "v2": [0.21, 1.05, 0.37],
                 "uv0": [0.1, 0.9], "uv1": [1.4, 0.8], "uv2": [0.55, -0.3]},
    "plane": {"type": "plane", "point": [0.1, -0.6, 0.3], "normal": [0.1, 1.3, -0.25]},
    "box": {"type": "box", "min": [-0.63, -0.52, -0.44], "max": [0.71, 0.47, 0.83]},
    "convex_halfspaces": {"type": "convex", "halfspaces": [
        [1, 0.9, -0.3, 0.7], [-1.2, 0.5, -0.4, 0.8], [0.1, -1, 0.2, 0.55],
        [0.2, 0.3, 1.3, 0.9], [-0.2, 0.4, -1.1, 0.6]]},
    "convex_vertices": {"type": "convex", "vertices": [
        [0.9, -0.4, 0.1], [-0.7, -0.5, 0.4], [0.1, -0.45, -0.8],
        [0.2, 0.9, 0.15], [-0.5, 0.4, -0.3], [0.05, 0.0, 0.02]]},
}
GROUND = {"type": "plane", "point": [0, -0.9, 0], "normal": [0, 1, 0], "material": WHITE}


def shape(name, material=SHINY):
    """Return a copy of one of SHAPES with a material."""
    return {**copy.deepcopy(SHAPES[name]), "material": dict(material)}


def scene(*shapes, camera=None, lights=LIGHTS, mode="phong", nbounces=4, **world):
    """Return a scene document; `camera` changes keys of CAMERA, `world` those of `scene`."""
    sources = [{"type": "pointlight", "position": list(p), "intensity": list(i)} for p, i in lights]
    return {"nbounces": nbounces, "rendermode": mode, "camera": {**CAMERA, **(camera or {})},
            "scene": {"backgroundcolor": [0.25, 0.3, 0.35], "lightsources": sources, "shapes": list(shapes), **world}}


def changed(document, path, value):
    """Return a copy of the document with the value at `path`, dotted keys and indices, replaced.

    A callable gets the old value and returns the new one.
    """
    result = copy.deepcopy(document)
    *parents, last = (int(key) if key.isdigit() else key for key in path.split("."))
    node = result
    for key in parents:
        node = node[key]
    node[last] = value(node[last]) if callable(value) else value
    return result


def write_texture(path, width=7, height=5, flip=False):
    """Write a picture of random colours, in which no two rows, columns or texels are alike; `flip` upside down."""
    texels = np.random.default_rng(7).integers(20, 255, (height, width, 3)).astype(np.uint8)
    Image.fromarray(texels[::-1] if flip else texels).save(path)
    return path
