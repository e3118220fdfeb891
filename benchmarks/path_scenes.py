"""The path-traced scenes that are measured, as documents of the scene format."""

from __future__ import annotations

import copy
import json
import math

import numpy as np

from benchmarks.measure import ROOT
from benchmarks.mesh_scenes import bumpy
from renderer.io import mesh_ply
from renderer.io.image import write_exr

GREY, RED, GREEN = (
    {"bsdf": {"type": "diffuse", "reflectance": colour}} for colour in ([0.7] * 3, [0.6, 0.1, 0.1], [0.1, 0.5, 0.15])
)
LIGHTS_A_SIDE = 10  # of a cube of lights


def coursework(folder):
    """The coursework's `scene` with a small square lamp in the place of each point light."""
    document = json.loads((ROOT / "scenes" / "scene.json").read_text())
    document |= {"rendermode": "pathtracer", "nbounces": 9}
    document["scene"]["lightsources"] = [
        lamp(light["position"], 0.2, [10.0] * 3) for light in document["scene"]["lightsources"]
    ]
    return document


def cornell(folder):
    """A Cornell box with a mirror and a glass sphere."""
    shapes = [*box(), sphere([-0.45, -0.6, 0.3], 0.4, {"type": "mirror"}),
              sphere([0.45, -0.6, -0.3], 0.4, {"type": "dielectric", "ior": 1.5})]  # fmt: skip
    return scene(shapes, [lamp([0, 0.99, 0], 0.5, [15.0, 14.0, 12.0])], nbounces=8)


def conductors(folder):
    """Three rough metal spheres on a floor under an image of a sky with a small sun."""
    write_sky(folder / "sky.exr")
    alphas = (0.05, 0.2, 0.5)
    shapes = [sphere([1.1 * (k - 1), -0.5, 0], 0.5, {"type": "roughconductor", "alpha": alpha})
              for k, alpha in enumerate(alphas)]  # fmt: skip
    shapes.append(rectangle([0, -1, 0], [8, 0, 0], [0, 0, 8], GREY))
    return scene(shapes, [{"type": "environment", "filename": "sky.exr"}], nbounces=5)


def thin_lens(folder):
    """Rows of matt spheres, most of them out of focus."""
    colours = ([0.7, 0.2, 0.2], [0.2, 0.6, 0.3], [0.2, 0.3, 0.7])
    shapes = [sphere([1.2 * (k % 3 - 1) + 0.2 * (k // 3), -0.6, 1.8 * (k // 3) - 1.8], 0.4,
                     {"type": "diffuse", "reflectance": colours[k % 3]}) for k in range(9)]  # fmt: skip
    shapes.append(rectangle([0, -1, 0], [16, 0, 0], [0, 0, 16], GREY))
    camera = {"type": "thinlens", "apertureRadius": 0.12, "focusDistance": 3.4}
    return scene(shapes, [lamp([0, 3, -1], 1.5, [8.0] * 3)], nbounces=4, camera=camera, background=[0.2, 0.25, 0.3])


def many_lights(folder):
    """A thousand small spheres of light, of very different powers, in a room of walls and columns."""
    random = np.random.default_rng(11)
    places = random.uniform(-0.95, 0.95, (LIGHTS_A_SIDE**3, 3))
    colours = random.uniform(0.2, 1.0, (len(places), 3)) * 10 ** random.uniform(0, 2, (len(places), 1))
    shapes = [*box(), *({"type": "sphere", "center": place, "radius": 0.005, "emission": colour,
                         "material": {"bsdf": {"type": "diffuse", "reflectance": [0, 0, 0]}}}
                        for place, colour in zip(places.tolist(), colours.tolist()))]  # fmt: skip
    return scene(shapes, [], nbounces=4)


def mesh(folder, triangles=100_000):
    """A bumpy closed mesh of matt material on a floor, under a lamp."""
    vertices, faces = bumpy(triangles)
    mesh_ply.write(folder / "bumpy.ply", vertices, faces)
    shapes = [{"type": "mesh", "filename": "bumpy.ply", "transform": [{"scale": 0.9}], "material": GREY},
              rectangle([0, -1, 0], [8, 0, 0], [0, 0, 8], GREY)]  # fmt: skip
    return scene(shapes, [lamp([1, 3, -1], 1.0, [20.0] * 3)], nbounces=5)


SCENES = {"coursework, area lights": coursework, "Cornell box, glass and mirror": cornell,
          "rough conductors, environment": conductors, "thin lens": thin_lens, "1,000 lights": many_lights,
          "mesh of 100,000 triangles": mesh}  # fmt: skip


def scene(shapes, lights, nbounces, camera=None, background=(0.0, 0.0, 0.0)):
    """Return a document with a camera that looks along +z."""
    view = {"type": "pinhole", "width": 600, "height": 400, "position": [0, 0, -3.4], "lookAt": [0, 0, 0],
            "upVector": [0, 1, 0], "fov": 40} | (camera or {})
    world = {"backgroundcolor": list(background), "lightsources": lights, "shapes": copy.deepcopy(shapes)}
    return {"rendermode": "pathtracer", "nbounces": nbounces, "camera": view, "scene": world}


def box():
    """Return floor, ceiling, back and coloured sides of a box of edge 2 around the origin."""
    return [rectangle([0, -1, 0], [2, 0, 0], [0, 0, 2], GREY), rectangle([0, 1, 0], [2, 0, 0], [0, 0, 2], GREY),
            rectangle([0, 0, 1], [2, 0, 0], [0, 2, 0], GREY), rectangle([-1, 0, 0], [0, 2, 0], [0, 0, 2], RED),
            rectangle([1, 0, 0], [0, 2, 0], [0, 0, 2], GREEN)]  # fmt: skip


def rectangle(center, u, v, material):
    """Return a rectangle."""
    return {"type": "rectangle", "center": center, "u": u, "v": v, "material": material}


def sphere(center, radius, bsdf):
    """Return a sphere."""
    return {"type": "sphere", "center": center, "radius": radius, "material": {"bsdf": bsdf}}


def lamp(position, side, radiance):
    """Return a square lamp that shines downwards."""
    return {"type": "arealight", "position": position, "u": [side, 0, 0], "v": [0, 0, side], "intensity": radiance,
            "twosided": False}  # fmt: skip


def write_sky(path, width=512, height=256):
    """Write an environment image: a gradient over a dark ground, and a sun of a few texels."""
    elevation = np.cos(np.linspace(0, math.pi, height))[:, None, None]
    sky = np.where(elevation > 0, 0.4 + 0.5 * elevation * [0.4, 0.7, 1.0], [0.15, 0.12, 0.1])
    image = np.broadcast_to(sky, (height, width, 3)).astype(np.float32).copy()
    image[60:66, 350:356] = [900.0, 800.0, 600.0]
    write_radiance(path, image)


def write_radiance(path, image):
    """Write an (H, W, 3) float32 image as an EXR file."""
    write_exr(path, {name: np.ascontiguousarray(image[..., k]) for k, name in enumerate("RGB")}, {})
