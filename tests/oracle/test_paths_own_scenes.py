"""Scenes of our own against Mitsuba, small: a lake of lanterns, a shell of rings, shapes that mirrors throw on a wall.

They have what smallest scenes have not: thousands of shining meshes, and everything at once.
"""

import json

import pytest

from tests.support.documents import changed
from tests.support.paths import Case, Judge, ours, times
from tests.support.stats import P_LEAST, compare

pytestmark = [pytest.mark.oracle, pytest.mark.slow]

SIZE = {"width": 36, "height": 24}
LAMP = "scene.lightsources.0.intensity"


@pytest.fixture(scope="module")
def judge(root, tmp_path_factory):
    """Both sides, in a folder that has the meshes and images of the scenes."""
    folder = tmp_path_factory.mktemp("own")
    for name in ("meshes", "textures"):
        (folder / name).symlink_to(root / "scenes" / name)
    return Judge(folder)


@pytest.mark.parametrize("name, path, value, samples", [
    ("lanterns", LAMP, [1.05, 1.05, 1.05], 64), ("nautilus", LAMP, times(1.03), 320),
])  # fmt: skip
def test_own_scene(judge, root, name, path, value, samples):
    """A scene that is handed in has Mitsuba's expectation; with a brighter sky or lamp on our side not."""
    document = json.loads((root / "scenes" / f"{name}.json").read_text())
    document |= {"camera": {**document["camera"], **SIZE}, "sampler": "independent", "filter": "box"}
    case = Case(document, path, value, samples)
    judge.decide(case)


def test_light_by_way_of_mirrors(judge, root):
    """What mirrors throw on the wall, by means of squares: Mitsuba finds lamps in mirrors by chance, if wide."""
    document = json.loads((root / "scenes" / "reflections.json").read_text())
    document |= {"camera": {**document["camera"], **SIZE}, "sampler": "independent", "filter": "box"}
    for lamp in document["scene"]["lightsources"]:
        lamp["radius"] *= 5
    (disk,) = (number for number, shape in enumerate(document["scene"]["shapes"]) if shape["type"] == "disk")
    case = Case(document, f"scene.shapes.{disk}.material.bsdf.reflectance", times(0.6), 768)
    right, wrong = (compare(ours(judge.load(case, made), case.samples), judge.reference(case))
                    for made in (document, changed(document, case.path, case.value)))
    assert right.coarse_p > P_LEAST and right.bound < 0.03, right
    assert wrong.coarse_p < P_LEAST, wrong
