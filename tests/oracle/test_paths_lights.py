"""Each light by itself, path traced, against Mitsuba; and one percent of it changed on our side, which is refused."""

import pytest

from tests.support.paths import Case, scene, times

pytestmark = pytest.mark.oracle

CHALK = {"bsdf": {"type": "diffuse", "reflectance": [0.8, 0.6, 0.4]}}
GREY = {"bsdf": {"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]}}
FLOOR = {"type": "rectangle", "center": [0, -0.7, 0], "u": [0, 0, 9], "v": [9, 0, 0], "material": GREY}
BALL = {"type": "sphere", "center": [0.1, 0.0, 0.0], "radius": 0.7, "material": CHALK}
LIGHTS = {
    "pointlight": {"type": "pointlight", "position": [1.0, 2.5, -1.5], "intensity": [9, 8, 7]},
    "spot": {"type": "spot", "position": [1.0, 2.5, -1.5], "direction": [-1.0, -2.9, 1.6], "intensity": [9, 8, 7],
             "cutoff": 25.0, "beamwidth": 10.0},
    "spot_hard": {"type": "spot", "position": [1.0, 2.5, -1.5], "direction": [-1.0, -2.9, 1.6], "intensity": [9, 8, 7],
                  "cutoff": 20.0, "beamwidth": 19.9},
    "spot_default": {"type": "spot", "position": [1.0, 2.5, -1.5], "direction": [-1.0, -2.9, 1.6],
                     "intensity": [9, 8, 7]},
    "directional": {"type": "directional", "direction": [-0.4, -1.0, 0.6], "intensity": [2, 1.8, 1.6]},
    "arealight": {"type": "arealight", "position": [0.6, 2.0, -0.8], "u": [1, 0, 0.2], "v": [-0.2, 0, 1],
                  "intensity": [9, 8, 7]},
    "arealight_oblique": {"type": "arealight", "position": [0.6, 1.4, -0.2], "u": [1, 0.3, 0.2], "v": [0.4, 0.1, 0.9],
                          "intensity": [9, 8, 7]},
    "arealight_seen": {"type": "arealight", "position": [0.9, 0.5, -0.6], "u": [0.7, 0.0, 0.5], "v": [0.2, 0.8, 0.1],
                       "intensity": [4, 5, 3]},
    "arealight_onesided": {"type": "arealight", "position": [0.9, 0.5, -0.6], "u": [0.7, 0.0, 0.5],
                           "v": [0.2, 0.8, 0.1], "intensity": [4, 5, 3], "twosided": False},
    "arealight_turned": {"type": "arealight", "position": [0.9, 0.5, -0.6], "u": [0.2, 0.8, 0.1],
                         "v": [0.7, 0.0, 0.5], "intensity": [4, 5, 3], "twosided": False},
    "disklight": {"type": "disklight", "position": [0.6, 2.0, -0.8], "normal": [-0.2, -1, 0.1], "radius": 0.6,
                  "intensity": [9, 8, 7]},
    "disklight_seen": {"type": "disklight", "position": [0.9, 0.5, -0.6], "normal": [0.6, 0.2, 1], "radius": 0.4,
                       "intensity": [4, 5, 3]},
    "disklight_onesided": {"type": "disklight", "position": [0.9, 0.5, -0.6], "normal": [-0.8, -0.5, 0.6],
                           "radius": 0.4, "intensity": [4, 5, 3], "twosided": False},
}
SEVERAL = [LIGHTS["pointlight"], LIGHTS["arealight"], LIGHTS["disklight_seen"], LIGHTS["spot"], LIGHTS["directional"]]
MANY = [{"type": "disklight", "position": [0.4 * (k % 5) - 0.8, 1.0 + 0.2 * (k % 3), 0.4 * (k // 5) - 0.8],
         "normal": [0.1 * (k % 4), -1, 0.1 * (k % 7)], "radius": 0.05 + 0.01 * (k % 4),
         "intensity": [3.0 + k % 5, 4.0, 7.0 - k % 3]} for k in range(25)]
SAMPLES = {name: 256 for name in LIGHTS if name.startswith(("arealight", "disklight"))}  # shadows are noisy
SAMPLES |= {"arealight_onesided": 512, "arealight_turned": 512, "arealight_oblique": 512}
INTENSITY = "scene.lightsources.0.intensity"

CASES = {
    **{name: Case(scene(BALL, FLOOR, lights=[light]), INTENSITY, times(1.01), SAMPLES.get(name, 64))
       for name, light in LIGHTS.items()},
    "background": Case(scene(BALL, FLOOR, background=[0.8, 0.9, 1.1]), "scene.backgroundcolor", times(1.01)),
    "background_and_lamp": Case(scene(BALL, FLOOR, background=[0.4, 0.5, 0.6], lights=[LIGHTS["arealight"]]),
                                "scene.backgroundcolor", times(1.02)),
    "several": Case(scene(BALL, FLOOR, lights=SEVERAL), "scene.lightsources.2.intensity", times(1.03), 256),
    "many": Case(scene(BALL, FLOOR, lights=MANY), INTENSITY, times(1.5), 512),
    "spot_cutoff": Case(scene(BALL, FLOOR, lights=[LIGHTS["spot"]]), "scene.lightsources.0.cutoff", times(1.01)),
    "spot_beamwidth": Case(scene(BALL, FLOOR, lights=[LIGHTS["spot"]]), "scene.lightsources.0.beamwidth", times(1.03)),
    "lamp_size": Case(scene(BALL, FLOOR, lights=[LIGHTS["arealight"]]), "scene.lightsources.0.u", times(1.01), 256),
    "disk_size": Case(scene(BALL, FLOOR, lights=[LIGHTS["disklight"]]), "scene.lightsources.0.radius", times(1.01),
                      256),
}


@pytest.mark.parametrize("name", CASES)
def test_light(judge, name):
    """Our picture has Mitsuba's expectation, and a light that is a little wrong does not."""
    judge.decide(CASES[name])
