"""The scenes of the benchmark `error`, from the coursework's to a million triangles; all of 192 x 128 pixels.

Materials are those that stock Mitsuba has, but for `scene`, which keeps the coursework's own: there Mitsuba renders
with the plugin of `converters/coursework_bsdf.py`, which is traced like any other in its JIT modes, while its scalar
mode would wait for Python at every hit and is left out (`JIT_ONLY`).
"""

from __future__ import annotations

import json
import math

from benchmarks import path_scenes
from benchmarks.measure import ROOT
from benchmarks.path_scenes import GREY, lamp, rectangle, scene, sphere

WIDTH, HEIGHT = 192, 128
JIT_ONLY = ("scene",)
QUICK_SCENES = ("simple_phong", "cornell", "thin_lens")
DEFAULT_PAINT = [0.8, 0.8, 0.8]
GLASS = {"type": "dielectric", "ior": 1.5}


def binary_primitives(folder):
    """The coursework's `binary_primitives` in matt material, lit by its background."""
    return _stock("binary_primitives", lambda material: {"type": "diffuse", "reflectance": DEFAULT_PAINT}, nbounces=4)


def simple_phong(folder):
    """The coursework's `simple_phong` with a small lamp for its light and glossy paint for its Blinn-Phong."""
    return _lamps(_stock("simple_phong", paint, nbounces=5))


def mirror_image(folder):
    """The coursework's `mirror_image`, likewise; its mirrors stay."""
    return _lamps(_stock("mirror_image", paint, nbounces=6))


def caustics(folder):
    """Balls and a pillar of glass over a floor, under a lamp that paths through the glass meet."""
    # above the floor: a cap in its plane would be glass or floor by rounding, to each renderer its own
    pillar = {"type": "cylinder", "center": [0.15, -0.5, 0.95], "axis": [0, 1, 0], "radius": 0.25, "height": 0.4,
              "material": {"bsdf": GLASS}}
    shapes = [sphere([-0.75, -0.5, 0.1], 0.5, GLASS), sphere([0.45, -0.65, -0.35], 0.35, GLASS), pillar,
              sphere([1.15, -0.6, 0.45], 0.4, {"type": "roughdielectric", "ior": 1.5, "alpha": 0.15}),
              rectangle([0, -1, 0], [8, 0, 0], [0, 0, 8], GREY)]
    return scene(shapes, [lamp([-0.6, 2.2, 0.9], 1.6, [9.0, 8.5, 8.0])], nbounces=7, background=[0.05, 0.06, 0.08],
                 camera={"position": [0, 0.9, -3.2], "lookAt": [0.1, -0.6, 0.2]})


def glossy(folder):
    """Varnish, lacquer and brushed metals on a polished floor, between lamps of three sizes."""
    kinds = ({"type": "plastic", "reflectance": [0.6, 0.15, 0.1]},
             {"type": "principled", "basecolor": [0.1, 0.3, 0.6], "roughness": 0.35, "clearcoat": 1.0},
             {"type": "principled", "basecolor": [0.9, 0.7, 0.3], "roughness": 0.3, "metallic": 1.0},
             {"type": "roughconductor", "alpha": 0.1}, {"type": "roughconductor", "alpha": 0.3})
    shapes = [sphere([0.75 * (k - 2), -0.65, 0.35 * (-1) ** k], 0.35, kind) for k, kind in enumerate(kinds)]
    floor = {"type": "principled", "basecolor": [0.35, 0.33, 0.3], "roughness": 0.4}
    wall = {"type": "principled", "basecolor": [0.4, 0.45, 0.5], "roughness": 0.7}
    shapes += [rectangle([0, -1, 0], [8, 0, 0], [0, 0, 8], {"bsdf": floor}),
               rectangle([0, 1, 2.5], [8, 0, 0], [0, 4, 0], {"bsdf": wall})]
    lamps = [lamp([x, 1.6, 0.8], side, colour) for x, side, colour in
             ((-1.6, 0.15, [360.0, 320.0, 240.0]), (0.0, 0.5, [36.0] * 3), (1.6, 1.2, [4.8, 5.6, 7.2]))]
    return scene(shapes, lamps, nbounces=5, camera={"position": [0, 0.5, -3.4], "lookAt": [0, -0.4, 0]})


def mesh_100k(folder):
    """A bumpy closed mesh of 100,000 triangles."""
    return path_scenes.mesh(folder)


def mesh_1m(folder):
    """The same of a million."""
    return path_scenes.mesh(folder, 1_000_000)


SCENES = {"binary_primitives": binary_primitives, "simple_phong": simple_phong, "scene": path_scenes.coursework,
          "mirror_image": mirror_image, "cornell": path_scenes.cornell, "caustics": caustics, "glossy": glossy,
          "metals_environment": path_scenes.conductors, "thin_lens": path_scenes.thin_lens,
          "thousand_lights": path_scenes.many_lights, "mesh_100k": mesh_100k, "mesh_1m": mesh_1m}  # fmt: skip


def write(name, folder, width=WIDTH, height=HEIGHT):
    """Write the files of a scene into a folder and return the scene file: box filter, no roulette."""
    document = SCENES[name](folder) | {"roulette": False, "filter": "box"}
    document["camera"] |= {"width": width, "height": height}
    path = folder / f"{name}.json"
    path.write_text(json.dumps(document))
    return path


def paint(material):
    """Return glossy paint of a coursework material's colour, with about as wide a highlight."""
    alpha = math.sqrt(2 / (material["specularexponent"] + 2))  # of the distribution of normals
    return {"type": "principled", "basecolor": material["diffusecolor"], "roughness": math.sqrt(alpha)}


def _stock(name, bsdf, nbounces):
    """Return a coursework scene for path tracing; what is no mirror gets the BSDF that `bsdf(material)` returns."""
    document = json.loads((ROOT / "scenes" / f"{name}.json").read_text())
    document |= {"rendermode": "pathtracer", "nbounces": nbounces}
    for shape in document["scene"]["shapes"]:
        material = shape.get("material", {})
        mirror = material.get("isreflective", False)
        shape["material"] = {"bsdf": {"type": "mirror"} if mirror else bsdf(material)}
    return document


def _lamps(document):
    """Return the document with a small square lamp in the place of each point light."""
    world = document["scene"]
    world["lightsources"] = [lamp(light["position"], 0.25, [40.0] * 3) for light in world["lightsources"]]
    return document
