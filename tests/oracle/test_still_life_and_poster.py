"""Two scenes of our own, the morning still life and the poster, against Mitsuba at a small size; twins are refused."""

import json

import pytest

from tests.support import oracle as sides
from tests.support.compare import Mismatch
from tests.support.documents import changed
from tests.support.paths import SIZE, Case, Judge, times

pytestmark = pytest.mark.oracle

POSTER_SIZE = 320, 450  # pixels; of fewer, chance decides about quantiles over the glass ball


def whole(root, name):
    """Return the document of a scene in scenes/, and a function that gives a folder what its files are."""
    def files(folder):
        for part in ("meshes", "textures"):
            if not (folder / part).exists():
                (folder / part).symlink_to(root / "scenes" / part)

    return json.loads((root / "scenes" / f"{name}.json").read_text()), files


WIDER = 3.0  # times the sun's radius: single samples that glass focuses on it are a ninth as bright


@pytest.mark.slow
def test_morning(root, tmp_path):
    """The still life, under a wider sun of equal power, has Mitsuba's expectation; with 3 % more sun it has not."""
    document, files = whole(root, "morning")
    document |= {"sampler": "independent", "filter": "box"}
    document["camera"] |= dict(zip(("width", "height"), SIZE))
    (sun,) = (k for k, shape in enumerate(document["scene"]["shapes"]) if "emission" in shape)
    document = changed(document, f"scene.shapes.{sun}.radius", times(WIDER))
    document = changed(document, f"scene.shapes.{sun}.emission", times(WIDER**-2))
    case = Case(document, f"scene.shapes.{sun}.emission", times(1.03), 320, (files,))
    Judge(tmp_path).decide(case)


@pytest.fixture(scope="module")
def poster(root, tmp_path_factory):
    """The document, its folder, and Mitsuba's view of it."""
    folder = tmp_path_factory.mktemp("poster")
    document, files = whole(root, "poster")
    files(folder)
    return document, folder, sides.Oracle(sides.prepare(sides.write(folder, document), *POSTER_SIZE))


def test_poster(poster):
    """The poster is that of the exact counterpart, ray by ray."""
    _, _, oracle = poster
    for name in ("shape", "rgb"):
        oracle.check(name, sides.observe(oracle.loaded, name))


@pytest.mark.parametrize(("path", "value"), [
    ("lightsources.1.intensity", times(1.02)), ("lightsources.2.cutoff", 24), ("lightsources.0.intensity", [1.02] * 3),
    ("shapes.4.material.refractiveindex", 1.51), ("shapes.1.material.scaleU", 1.02),
])
def test_changed_poster(poster, path, value):
    """A lamp a little brighter, a cone narrower, brighter surroundings, other glass, a texture stretched: refused."""
    document, folder, oracle = poster
    wrong = changed(document, f"scene.{path}", value)
    with pytest.raises(Mismatch):
        oracle.check("rgb", sides.observe(sides.prepare(sides.write(folder, wrong, "wrong.json"), *POSTER_SIZE), "rgb"))
