"""Light of small lamps over mirrors, path traced, which is drawn by a way of its own: against Mitsuba, and without it.

Mitsuba finds such light by chance only, so that its pictures are noisy here: the same scenes are also held against our
own pictures without that way, and twins with another lamp, mirror or number of bounces are refused there.
"""

import pytest

from tests.support.documents import changed
from tests.support.paths import Case, ours, scene, times
from tests.support.stats import P_LEAST, compare

pytestmark = pytest.mark.oracle

GREY = {"bsdf": {"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]}}
MIRROR = {"bsdf": {"type": "mirror", "reflectance": [0.9, 0.8, 0.7]}}
PAINTED = {"kd": 0.6, "ks": 0.2, "isreflective": True, "reflectivity": 0.6, "diffusecolor": [0.8, 0.5, 0.4]}
GLASS = {"bsdf": {"type": "dielectric", "ior": 1.5}}
FLOOR = {"type": "rectangle", "center": [0, -0.9, 0], "u": [0, 0, 6], "v": [6, 0, 0], "material": GREY}
WALL = {"type": "rectangle", "center": [0, 0.5, 1.6], "u": [6, 0, 0], "v": [0, 4, 0], "material": GREY}
LAMP = {"type": "disklight", "position": [-0.9, 1.5, -1.0], "normal": [0.9, -1.5, 1.0], "radius": 0.2,
        "intensity": [40, 35, 30]}
SQUARE = {"type": "arealight", "position": [0.9, 1.2, -1.2], "u": [0.3, 0, 0.1], "v": [0.1, 0.3, 0.1],
          "intensity": [20, 25, 30]}
BALL = {"type": "sphere", "center": [0.3, -0.3, 0.2], "radius": 0.6, "material": MIRROR}
SMALL = {"type": "sphere", "center": [-0.9, -0.6, 0.4], "radius": 0.3, "material": MIRROR}
PANE = {"type": "rectangle", "center": [0.8, -0.1, 0.6], "u": [1.0, 0.1, -0.9], "v": [0.1, 1.4, 0.1],
        "material": MIRROR}
ROUND = {"type": "disk", "center": [0.6, -0.6, 0.2], "normal": [-0.5, 0.7, -0.6], "radius": 0.5, "material": MIRROR}
SHARD = {"type": "triangle", "v0": [0.2, -0.9, 0.8], "v1": [1.3, -0.8, 0.1], "v2": [0.9, 0.6, 0.7], "material": MIRROR}
BLOCK = {"type": "box", "min": [-0.5, -0.9, -0.6], "max": [-0.2, -0.2, -0.3], "material": GREY}
AT_BALL = {"type": "disklight", "position": [-0.336, 0.08, -0.31], "normal": [0.707, -0.424, 0.566], "radius": 0.12,
           "intensity": [90, 80, 70], "twosided": False}  # so near that most of its light goes over the ball
SHINING = {"type": "rectangle", "center": [-0.9, 0.8, 0.0], "u": [0.4, 0, 0.2], "v": [0, 0.4, 0.1], "material": MIRROR,
           "emission": [9, 8, 7]}


def lit(*shapes, lights=(LAMP,), bounces=3, **settings):
    """Return the document of shapes on the floor, before the wall."""
    return scene(*shapes, FLOOR, WALL, lights=lights, bounces=bounces, **settings)


SCENES = {
    "ball": lit(BALL),
    "ball_painted": lit({**BALL, "material": PAINTED}),
    "ball_two_bounces": lit(BALL, bounces=2),
    "ball_one_bounce": lit(BALL, bounces=1),
    "ball_alone_lights": lit(BALL, bounces=2, lights=[AT_BALL]),
    "balls": lit(BALL, SMALL),
    "pane": lit(PANE),
    "disk": lit(ROUND),
    "triangle": lit(SHARD),
    "painted_pane": lit({**PANE, "material": PAINTED}),
    "ball_and_pane": lit(BALL, {**PANE, "center": [-0.9, 0.2, 0.8]}),
    "shadowed": lit(BALL, BLOCK),
    "two_lamps": lit(BALL, PANE, lights=[LAMP, SQUARE]),
    "one_sided": lit(BALL, PANE, lights=[{**SQUARE, "twosided": False}, {**LAMP, "twosided": False}]),
    "shining_mirror": lit(BALL, SHINING, lights=()),
    "behind_glass": lit(BALL, {"type": "sphere", "center": [-0.6, 0.4, -0.7], "radius": 0.3, "material": GLASS}),
    "inside_a_ball": scene({"type": "sphere", "center": [0, 0, 0], "radius": 5.0,
                            "material": {**PAINTED, "reflectivity": 0.3}}, BLOCK, FLOOR, lights=[LAMP], bounces=3),
    "many_mirrors": lit(BALL, SMALL, PANE, ROUND, {**SHARD, "v0": [-1.3, 0.4, 0.9]}),
    "sky_too": lit(BALL, PANE, background=[0.3, 0.4, 0.5]),
    "glossy": lit(BALL, {**BLOCK, "material": {"bsdf": {"type": "roughconductor", "alpha": 0.2}}}),
    "lens": lit(BALL, camera={"type": "thinlens", "apertureRadius": 0.1}),
}
SAMPLES = 256
TWINS = {  # what is changed without the way over mirrors, and must be refused
    "ball": ("scene.shapes.0.radius", times(1.02)), "ball_alone_lights": ("scene.shapes.0.radius", times(1.01)),
    "pane": ("scene.shapes.0.material.bsdf.reflectance", times(0.95)),
    "balls": ("scene.shapes.1.center", [-0.9, -0.5, 0.4]), "two_lamps": ("scene.lightsources.1.intensity", times(1.02)),
    "ball_painted": ("scene.shapes.0.material.reflectivity", times(1.03)), "ball_two_bounces": ("nbounces", 3),
    "one_sided": ("scene.lightsources.0.twosided", True),
}
REFERENCE_SAMPLES = 512
BOUND = 0.02


def by_chance(judge, document):
    """Return our pictures of a document without the way over mirrors."""
    return ours(judge.load(Case(document, "", None), {**document, "mirrorlight": False}), 4 * SAMPLES)


def demand(verdict):
    """Demand equality of what is seen by chance in few pixels only."""
    assert verdict.coarse_p >= P_LEAST and verdict.bound < BOUND, verdict


SHORT = ("ball", "pane", "two_lamps", "sky_too")  # of these the quick tests ask chance too; Mitsuba is always asked


@pytest.mark.parametrize("name", SCENES)
def test_light_over_mirrors(judge, name):
    """Our picture has Mitsuba's expectation."""
    case = Case(SCENES[name], "", None, REFERENCE_SAMPLES)
    demand(compare(ours(judge.load(case, SCENES[name]), SAMPLES), judge.reference(case)))


@pytest.mark.parametrize("name", [pytest.param(name, marks=() if name in SHORT else pytest.mark.slow)
                                  for name in SCENES])
def test_ways_over_mirrors_change_noise_only(judge, name):
    """With and without them the expectation is the same."""
    with_ways = ours(judge.load(Case(SCENES[name], "", None), SCENES[name]), SAMPLES)
    demand(compare(with_ways, by_chance(judge, SCENES[name])))


@pytest.mark.parametrize("name", TWINS)
def test_twin_is_refused(judge, name):
    """What is a little wrong in one of the two pictures is seen."""
    right = ours(judge.load(Case(SCENES[name], "", None), SCENES[name]), SAMPLES)
    assert compare(right, by_chance(judge, changed(SCENES[name], *TWINS[name]))).coarse_p < P_LEAST
