"""Phong mode under other lights than points, against the exact counterpart; a little of each changed is refused."""

import numpy as np
import pytest
from PIL import Image

from tests.support import oracle as sides
from tests.support.compare import Mismatch
from tests.support.documents import GLASS, GROUND, MIRROR, changed, scene, shape

pytestmark = pytest.mark.oracle

SPOT = {"type": "spot", "position": [1.5, 2.5, -2.0], "direction": [-1.4, -2.4, 2.0], "intensity": [0.9, 0.8, 0.7],
        "cutoff": 20.0}
LIGHTS = {
    "spot": SPOT,
    "spot_beamwidth": {**SPOT, "beamwidth": 5.0},
    "directional": {"type": "directional", "direction": [-0.7, -1.0, 0.5], "intensity": [0.9, 0.8, 0.7]},
    "arealight": {"type": "arealight", "position": [1.5, 2.5, -2.0], "u": [1, 0, 0.3], "v": [0.2, 0.4, 1],
                  "intensity": [0.9, 0.8, 0.7]},
    "disklight": {"type": "disklight", "position": [1.5, 2.5, -2.0], "normal": [-1.4, -2.4, 2.0], "radius": 0.5,
                  "intensity": [0.9, 0.8, 0.7]},
}
SKY = {"type": "environment", "filename": "sky.png", "rotation": 30.0, "intensity": [1.0, 0.9, 0.8]}
SIZE = 150, 100


def write_sky(folder):
    """Write an image of what is all around."""
    texels = np.random.default_rng(2).integers(20, 255, (5, 8, 3)).astype(np.uint8)
    Image.fromarray(texels).save(folder / "sky.png")


def compare(folder, right, wrong=None):
    """Demand that our picture of `wrong` is Mitsuba's of the right document."""
    write_sky(folder)
    loaded = sides.prepare(sides.write(folder, right), *SIZE)
    oracle = sides.Oracle(loaded)
    if wrong:
        loaded = sides.prepare(sides.write(folder, wrong), *SIZE)
    oracle.check("rgb", sides.observe(loaded, "rgb"))


@pytest.mark.parametrize("name", LIGHTS)
def test_light(tmp_path, name):
    """The light and its shadow are where the counterpart has them; a percent more light is not."""
    document = scene(shape("box"), GROUND, lightsources=[LIGHTS[name]])
    compare(tmp_path, document)
    with pytest.raises(Mismatch):
        compare(tmp_path, document, changed(document, "scene.lightsources.0.intensity", [0.909, 0.808, 0.707]))


@pytest.mark.parametrize(("name", "key", "value"), [
    ("spot", "cutoff", 20.5), ("spot_beamwidth", "beamwidth", 6.0), ("directional", "direction", [-0.7, -1.0, 0.53]),
    ("arealight", "position", [1.5, 2.5, -1.9]), ("spot", "direction", [-1.4, -2.4, 2.1]),
])
def test_changed_light(tmp_path, name, key, value):
    """Cones, directions and places that are a little off are refused."""
    document = scene(shape("box"), GROUND, lightsources=[LIGHTS[name]])
    with pytest.raises(Mismatch):
        compare(tmp_path, document, changed(document, f"scene.lightsources.0.{key}", value))


@pytest.mark.parametrize("material", [MIRROR, GLASS])
@pytest.mark.parametrize("nbounces", [0, 1, 4])
def test_environment_is_seen(tmp_path, material, nbounces):
    """An image all around is seen behind the shapes, in mirrors and through glass, also where bounces run out."""
    document = scene(shape("sphere", material), GROUND, nbounces=nbounces, lightsources=[SKY, LIGHTS["directional"]])
    compare(tmp_path, document)


def test_turned_environment(tmp_path):
    """A degree of rotation is seen."""
    document = scene(shape("sphere", MIRROR), GROUND, lightsources=[SKY, LIGHTS["directional"]])
    with pytest.raises(Mismatch):
        compare(tmp_path, document, changed(document, "scene.lightsources.0.rotation", 31.0))
