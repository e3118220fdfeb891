"""Path-traced scenes thrown together at random, against Mitsuba: whatever is combined must not change what it means.

Kernels hold what the scene has, so that each combination is code of its own. Counts cross the limits from which shapes
lie in a hierarchy, and BSDFs and lights in tables.
"""

import numpy as np
import pytest

from tests.oracle.test_paths_scenes import write_files
from tests.support.paths import Case, ours, scene
from tests.support.stats import compare

pytestmark = pytest.mark.oracle

SCENES = {"few": (3, 6), "some": (6, 14), "many": (24, 40), "soup": (80, 120)}  # shapes
SEEDS = [
    pytest.param(size, seed, marks=[pytest.mark.slow] if seed > 0 else [])
    for size, count in zip(SCENES, (4, 4, 2, 1)) for seed in range(count)
]
KINDS_OF_SHAPES = ("sphere", "cylinder", "box", "rectangle", "disk", "triangle", "convex", "mesh")
SAMPLES = 64
FLAT = ("rectangle", "disk", "triangle")  # Mitsuba has two of each that shines, which are not one sheet of glass


class Dice:
    """Draws parts of scenes."""

    def __init__(self, seed):
        self._rng = np.random.default_rng(seed)

    def one(self, *choices):
        """Return one of the choices."""
        return choices[self._rng.integers(len(choices))]

    def number(self, low=0.0, high=1.0):
        """Return a number."""
        return float(self._rng.uniform(low, high))

    def count(self, low, high):
        """Return a whole number, both ends included."""
        return int(self._rng.integers(low, high + 1))

    def vector(self, reach=1.0, middle=(0.0, 0.0, 0.0)):
        """Return a point of a cube."""
        return [float(c + reach * x) for c, x in zip(middle, self._rng.uniform(-1, 1, 3))]

    def colour(self, low=0.1, high=0.9):
        """Return a colour."""
        return [self.number(low, high) for _ in range(3)]

    def chance(self, share):
        """Return True in a share of cases."""
        return bool(self._rng.random() < share)

    def texturable(self, plain, texture):
        """Return the value or, at times, the texture."""
        return texture if self.chance(0.25) else plain

    def bsdf(self):
        """Return a BSDF."""
        kind = self.one("diffuse", "diffuse", "mirror", "conductor", "roughconductor", "dielectric", "roughdielectric",
                        "plastic", "principled")
        made = {"type": kind}
        if kind in ("diffuse", "mirror", "conductor", "roughconductor", "plastic"):
            made["reflectance"] = self.texturable(self.colour(), self.one("texture.png", self.board()))
        if kind in ("dielectric", "roughdielectric", "plastic"):
            made["ior"] = self.number(1.2, 1.9)
        if kind.startswith("rough"):
            made |= {"alpha": self.texturable(self.number(0.1, 0.6), "grey.png"),
                     "distribution": self.one("ggx", "beckmann")}
        if kind == "principled":
            made |= {"basecolor": self.texturable(self.colour(), "texture.png"), "roughness": self.number(0.3, 1.0),
                     "metallic": self.texturable(self.number(), "numbers.png")}
            made |= {key: self.number() for key in ("specular", "speculartint", "anisotropic", "sheen", "sheentint",
                                                    "clearcoat", "clearcoatgloss") if self.chance(0.4)}
        return made

    def board(self):
        """Return a checkerboard."""
        return {"type": "checkerboard", "color1": self.colour(), "color2": self.colour(), "scale": self.number(2, 6)}

    def material(self):
        """Return a material: a BSDF, or the coursework's."""
        placed = {"scaleU": self.number(0.5, 3), "scaleV": self.number(0.5, 3),
                  "texturefilter": self.one("nearest", "bilinear"), "texturewrap": self.one("repeat", "clamp")}
        if self.chance(0.7):
            placed["bsdf"] = self.bsdf()
            if self.chance(0.15) and "dielectric" not in placed["bsdf"]["type"]:
                placed |= self.one({"normalmap": "normals.png"}, {"bumpmap": "heights.png", "bumpscale": 0.03})
            return placed
        placed |= {"kd": self.number(), "ks": self.number(0, 0.6), "specularexponent": self.number(0, 60),
                   "diffusecolor": self.colour(), "specularcolor": self.colour()}
        if self.chance(0.3):
            placed["texture"] = self.one("texture.png", self.board())
        if self.chance(0.5):
            placed |= {self.one("isreflective", "isrefractive"): True,
                       "reflectivity": self.one(1.0, self.number(0.1, 0.8)),
                       "refractiveindex": self.number(1.2, 1.8), "roughness": self.one(0.0, self.number(0.1, 0.5))}
        return placed

    def shape(self, size):
        """Return a shape of about a size, somewhere in view."""
        kind, c = self.one(*KINDS_OF_SHAPES), self.vector(1.1, (0, 0.1, 0.3))
        made = {"type": kind, "material": self.material()}
        if kind == "sphere":
            made |= {"center": c, "radius": size}
        elif kind == "cylinder":
            made |= {"center": c, "axis": self.vector(), "radius": 0.6 * size, "height": size}
        elif kind == "box":
            made |= {"min": c, "max": [x + size * self.number(0.5, 1.5) for x in c]}
        elif kind == "rectangle":
            made |= {"center": c, "u": self.vector(2 * size), "v": self.vector(2 * size)}
        elif kind == "disk":
            made |= {"center": c, "normal": self.vector(), "radius": size}
        elif kind == "triangle":
            made |= {f"v{k}": self.vector(1.5 * size, c) for k in range(3)}
        elif kind == "convex":
            made |= {"vertices": [self.vector(1.3 * size, c) for _ in range(7)]}
        else:
            turn = {"rotate": {"axis": self.vector(), "angle": self.number(0, 360)}}
            made |= {"filename": "lump.ply", "normals": "flat",
                     "transform": [{"scale": 0.8 * size}, turn, {"translate": c}]}
        if self.chance(0.12) and not (kind in FLAT and transmits(made["material"])):
            made["emission"] = self.colour(0.2, 1.5)
        return made

    def light(self):
        """Return a light above the scene."""
        kind = self.one("pointlight", "spot", "directional", "arealight", "disklight")
        p = self.vector(1.2, (0, 2.6, -0.8))
        down = self.vector(0.4, (0, -1, 0.3))
        made = {"type": kind, "intensity": self.colour(1.0, 3.0)}
        if kind == "directional":
            return made | {"direction": down}
        made["position"] = p
        if kind == "spot":
            made |= {"direction": down, "cutoff": self.number(30, 60)}
        elif kind == "arealight":
            made |= {"u": [self.number(0.5, 1.5), 0.1, 0.2], "v": [0.1, 0.2, self.number(0.5, 1.5)],
                     "twosided": self.chance(0.5)}
        elif kind == "disklight":
            made |= {"normal": down, "radius": self.number(0.3, 0.8), "twosided": self.chance(0.5)}
        return made

    def scene(self, low, high):
        """Return a document with so many shapes over a floor."""
        shapes = self.count(low, high)
        size = 0.9 / shapes**0.45
        floor = {"type": self.one("plane", "rectangle"), "material": {"bsdf": {"type": "diffuse"}}}
        floor |= {"point": [0, -1.2, 0], "normal": [0, 1, 0]} if floor["type"] == "plane" else {
            "center": [0, -1.2, 0], "u": [0, 0, 12], "v": [12, 0, 0]}
        lights = [self.light() for _ in range(self.one(0, 1, 2, 4, 12))]
        if self.chance(0.4) or not lights:
            lights.append({"type": "environment", "filename": "sky.hdr", "rotation": self.number(0, 360),
                           "intensity": self.colour(0.3, 0.6)})
        made = [self.shape(size * self.number(0.6, 1.3)) for _ in range(shapes)]
        lens = {"type": "thinlens", "apertureRadius": 0.1} if self.chance(0.3) else {}
        return scene(floor, *made, lights=lights, bounces=self.count(1, 6), background=self.colour(0.0, 0.6),
                     camera=lens, roulette=self.chance(0.5), sampler=self.one("sobol", "independent"))


def transmits(material):
    """Return whether light passes a material."""
    return material["bsdf"]["type"].endswith("dielectric") if "bsdf" in material else "isrefractive" in material


@pytest.mark.parametrize(("size", "seed"), SEEDS)
def test_random_scene(judge, size, seed):
    """Our picture has Mitsuba's expectation."""
    document = Dice([seed, len(size), *SCENES[size]]).scene(*SCENES[size])
    case = Case(document, "", None, SAMPLES, (write_files,))
    verdict = compare(ours(judge.load(case, document), SAMPLES), judge.reference(case))
    assert not verdict.refused, verdict
