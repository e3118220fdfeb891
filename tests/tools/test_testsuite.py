"""The pictures that are handed in: sheets compare what they say they compare."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from renderer.core.errors import UsageError
from renderer.engine.render import render
from renderer.scene.loader import load, override
from tools import testsuite

RNG = np.random.default_rng(5)


@pytest.fixture
def ball(root):
    """A small path-traced scene."""
    return override(load(root / "scenes/features/bsdf_diffuse.json"), width=48, height=32, samples=64)


@pytest.mark.parametrize("tonemap", ["linear", "reinhard", "filmic"])
def test_curves_are_those_of_pictures(ball, tonemap):
    """What is done to Mitsuba's radiance is what the renderer does to ours, but for a bit where rounding decides."""
    loaded = replace(ball, description=replace(ball.description, tonemap=tonemap))
    rendering = render(loaded)
    radiance = np.stack([rendering.channels()[name] for name in "RGB"], axis=-1)
    again = testsuite.coarse(testsuite.encoded(testsuite.toned(radiance, loaded.description)))
    assert np.abs(again - testsuite.picture_of(rendering)).max() < 1.01 / 255


@pytest.mark.oracle
def test_path_traced_pair_is_one_scene(ball):
    """Means of squares agree where noise is averaged; with a brighter lamp on one side they would not."""
    ours, theirs = testsuite.path_traced_twice(ball)
    assert ours.shape == theirs.shape == (32, 48, 3)
    assert np.abs(testsuite.blocks(ours - theirs)).max() < 0.03
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.01)


def test_blocks_are_means_of_squares():
    """Each pixel of a square has the mean of all; what is left of no square is dropped."""
    difference = RNG.normal(size=(2 * testsuite.BLOCK + 3, testsuite.BLOCK, 3))
    evened = testsuite.blocks(difference)
    assert evened.shape == (2 * testsuite.BLOCK, testsuite.BLOCK, 3)
    for row in (0, testsuite.BLOCK):
        square = difference[row : row + testsuite.BLOCK]
        mean = np.broadcast_to(square.mean((0, 1)), square.shape)
        np.testing.assert_allclose(evened[row : row + testsuite.BLOCK], mean)


def test_sheet_shows_ours_theirs_and_the_difference():
    """In that order, the difference enlarged."""
    ours, theirs = np.full((40, 60, 3), 0.51), np.full((40, 60, 3), 0.50)
    page = np.asarray(testsuite.sheet([("one", ours, theirs)], 1))
    width = testsuite.CELL[0] + 3
    shown = [page[testsuite.CELL[1] // 2, k * width + testsuite.CELL[0] // 2, 0] for k in range(3)]
    assert shown == [130, 128, round(255 * 0.01 * testsuite.DIFFERENCE_GAIN)]


def test_pictures_stand_side_by_side():
    """From the left, as they are given."""
    page = np.asarray(testsuite.beside([np.zeros((4, 6, 3)), np.full((4, 6, 3), 0.5)]))
    assert (page[:, :6] == 0).all() and (page[:, 9:] == 128).all() and page.shape == (4, 15, 3)


def test_comparison_shows_where_mirrors_are_missing(tmp_path):
    """Wrong picture, right one, and their difference: nothing in the background, much in the mirror's ball."""
    testsuite.compared(tmp_path)
    page = np.asarray(Image.open(tmp_path / "compared.png"))
    width, height = map(int, testsuite.COMPARED.split("x"))
    wrong, right, difference = page[:, :width], page[:, width + 4 : 2 * width + 4], page[:, -width:]
    assert page.shape == (height, 3 * width + 8, 3) and (wrong[:40] == right[:40])[:, :200].all()
    assert not difference[:40, :200].any() and difference[200, 300].max() > 200


def test_unknown_group_is_refused(tmp_path):
    """A misspelt name renders nothing."""
    with pytest.raises(SystemExit):
        testsuite.main([str(tmp_path), "nothing"])


def test_scenes_of_our_own_that_need_the_denoiser_stay_without_it(tmp_path, monkeypatch, capsys):
    """The others are written, as JPEG files of the size that their files say."""
    def missing():
        raise UsageError("no denoiser")

    monkeypatch.setattr("renderer.denoise.load", missing)
    monkeypatch.setattr(testsuite, "OWN", ("binary_primitives", "morning"))
    testsuite.own(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["binary_primitives.jpg"]
    with Image.open(tmp_path / "binary_primitives.jpg") as picture:
        assert picture.size == (1200, 800)
    assert f"{tmp_path / 'morning.jpg'} stays as it is: no denoiser" in capsys.readouterr().out
