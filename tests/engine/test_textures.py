"""Texture files that turn out to be unusable when the scene is built."""

import pytest

from renderer.core.errors import SceneError
from renderer.engine.render import render
from renderer.scene.loader import load
from tests.support.scenes import MATT, document, write


def test_damaged_texture_is_told_with_its_place_in_the_scene(tmp_path):
    """File, line, column and key path of the mention, and the path of the image with what is wrong about it."""
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n not really")
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    scene = write(tmp_path, document([ball, ball | {"material": MATT | {"texture": "broken.png"}}]))
    with pytest.raises(SceneError) as caught:
        render(load(str(scene)))
    (problem,) = caught.value.problems
    assert problem.key_path == "scene.shapes[1].material.texture"
    assert problem.file == str(scene) and problem.line == 1
    assert scene.read_text()[problem.column - 1 :].startswith('"broken.png"')
    assert str(tmp_path / "broken.png") in problem.message
