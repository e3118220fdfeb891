"""What the report's part on path tracing draws and measures."""

import numpy as np
import pytest

from benchmarks import path_scenes as measured_scenes
from renderer.bsdfs import KINDS as BSDFS
from renderer.lights import KINDS as LIGHTS
from tools.report import path_scenes, pathtracer
from tools.report.pathtracer import error, radiance, small


def test_balls_show_every_kind_of_bsdf():
    """Kinds are those of the registry; a material without `bsdf` is the coursework's."""
    shown = {material.get("bsdf", {}).get("type", "coursework") for material in path_scenes.BALLS}
    assert shown == set(BSDFS) and len(path_scenes.BALLS) == 2 * path_scenes.A_ROW


def test_tables_tell_every_kind_of_bsdf_and_light():
    """`light_` and `bsdf_` of the benchmark `features` have the same names."""
    assert set(BSDFS) - set(pathtracer.BSDFS) == {"coursework"}
    assert set(LIGHTS) <= set(pathtracer.LIGHTS)


@pytest.mark.parametrize("name", ["bsdfs", "lights", "plates"])
def test_scenes_are_lit(name):
    """Each loads without a warning of anything unknown, and is neither black nor burnt out."""
    picture = radiance(small(getattr(path_scenes, name)(), 4, path_scenes.FOLDER))
    assert 0.02 < np.median(picture[picture > 0]) < 1 and np.isfinite(picture).all()


def test_strategies_have_one_mean():
    """Light found by lights alone and by BSDFs alone is the same light; neither is found twice, as without weights."""
    loaded = small(path_scenes.plates(), 256, path_scenes.FOLDER)
    means = {patch: radiance(loaded, patch=patch).mean() for patch in pathtracer.STRATEGIES.values()}
    assert max(means.values()) / min(means.values()) < 1.03 and len(set(means.values())) == len(means)


@pytest.mark.parametrize("patch", ["lights by power", "lights alike"])
def test_other_choices_of_lights_are_as_right_and_noisier(patch):
    """Probabilities follow the patch: the mean stays."""
    document = measured_scenes.many_lights(None)
    usual, other = (radiance(small(document, 64), patch=name) for name in ("", patch))
    assert other.mean() == pytest.approx(usual.mean(), rel=0.03)
    assert np.abs(np.diff(other, axis=1)).mean() > 1.05 * np.abs(np.diff(usual, axis=1)).mean()


def test_error_is_relative():
    """A tenth everywhere, of what is bright; black pixels count by DARK."""
    bright = np.full((4, 4, 3), 50.0)
    assert error(1.1 * bright, bright) == pytest.approx(0.1, rel=1e-4)
    assert error(np.full((2, 2, 3), 0.1), np.zeros((2, 2, 3))) == pytest.approx(1.0)
