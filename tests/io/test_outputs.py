"""Places for pictures are judged before the work and filled after it."""

import os

import pytest

from renderer.core.errors import RenderError, UsageError
from renderer.io import outputs


class Picture:
    """Two pixels that count how often they were asked for."""

    width, height = 2, 1

    def __init__(self):
        self.asked = 0

    def rgb8(self, tonemap, exposure, encoding):
        self.asked += 1
        return bytes(6)


def test_good_places_pass(tmp_path):
    """Existing and new files of every format, in any letters, are fine and stay untouched."""
    (tmp_path / "old.ppm").write_bytes(b"old")
    outputs.check([str(tmp_path / name) for name in ("old.ppm", "new.PNG", "new.exr")])
    assert os.listdir(tmp_path) == ["old.ppm"]


def test_link_to_another_output_is_found(tmp_path):
    """Two names of one file are one file."""
    (tmp_path / "link.ppm").symlink_to("real.ppm")
    with pytest.raises(UsageError, match="link.ppm: this output is given twice"):
        outputs.check([str(tmp_path / "real.ppm"), str(tmp_path / "link.ppm")])


def test_input_is_protected(tmp_path):
    """Under whatever name it is given."""
    with pytest.raises(UsageError, match="the scene is read from this file"):
        outputs.check([str(tmp_path / "." / "wood.ppm")], [tmp_path / "wood.ppm"])


def test_picture_is_graded_once_for_all_files(tmp_path):
    """Tone mapping a large picture is not free."""
    picture = Picture()
    outputs.write_all([str(tmp_path / "a.ppm"), str(tmp_path / "b.png")], picture, outputs.Grading(), {})
    assert picture.asked == 1


def test_failures_are_collected(tmp_path):
    """All that went wrong is told, and what can be written is."""
    paths = [str(tmp_path / name) for name in ("gone/a.ppm", "b.ppm", "gone/c.png")]
    with pytest.raises(RenderError) as caught:
        outputs.write_all(paths, Picture(), outputs.Grading(), {})
    assert [line.split(": ")[0] for line in str(caught.value).splitlines()] == [paths[0], paths[2]]
    assert os.path.exists(paths[1])
