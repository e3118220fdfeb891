"""Scene files written by tests, and what the loader says about them."""

import json

import pytest

from renderer.core.errors import SceneError
from renderer.scene.loader import load


@pytest.fixture
def scene_file(tmp_path):
    """A function that writes text, bytes or a document to a scene file and returns its path."""

    def write(content):
        path = tmp_path / "s.json"
        if not isinstance(content, (str, bytes)):
            content = json.dumps(content)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return str(path)

    return write


@pytest.fixture
def refused(scene_file):
    """A function that returns the problems for which a file's content is refused."""

    def problems(content, **options):
        with pytest.raises(SceneError) as caught:
            load(scene_file(content), **options)
        return caught.value.problems

    return problems


@pytest.fixture
def document():
    """A good scene of every kind of shape, to spoil."""
    return {
        "camera": {"position": [0, 0, -5], "lookAt": [0, 0, 0]},
        "scene": {
            "lightsources": [{"type": "pointlight", "position": [9, 9, -9], "intensity": [1, 1, 1]}],
            "shapes": [
                {"type": "sphere", "center": [0, 0, 0], "radius": 1},
                {"type": "cylinder", "center": [3, 0, 0], "axis": [0, 1, 0], "radius": 1, "height": 1},
                {"type": "triangle", "v0": [0, 0, 0], "v1": [1, 0, 0], "v2": [0, 1, 0]},
                {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
                {"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
                {"type": "convex", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]},
            ],
        },
    }
