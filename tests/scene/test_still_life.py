"""The still life and the poster are what their scripts make, and what is turned is closed."""

import collections
import io

import numpy as np
import pytest
from PIL import Image

from renderer.io.mesh import read_mesh
from scenes import make_poster, make_still_life
from scenes.turning import turned

LEVELS = 3  # of 255 that another version of a JPEG library may differ by
SOLIDS = {"bowl": [make_still_life.bowl()], "vase": [make_still_life.jug()], "lemon": [make_still_life.lemon()],
          "carafe and what is below the water": list(make_still_life.carafe())}


@pytest.mark.parametrize(("script", "name"), [(make_still_life, "morning"), (make_poster, "poster")])
def test_scene_is_what_the_script_makes(root, script, name):
    """The scene file, as text."""
    assert script.scene() == (root / "scenes" / f"{name}.json").read_text()


@pytest.mark.parametrize("script", [make_still_life, make_poster])
def test_images_are_what_the_script_makes(root, script):
    """The images, but for a level where rounding decides, and what JPEG makes of it."""
    for name, image in script.textures().items():
        if name.endswith(".jpg"):
            file = io.BytesIO()
            image.save(file, "JPEG", quality=make_still_life.QUALITY)
            image = Image.open(file)
        stored = np.asarray(Image.open(root / "scenes" / "textures" / name), int)
        apart = np.abs(stored - np.asarray(image, int))
        assert apart.max() <= (LEVELS if name.endswith(".jpg") else 1), name


def test_meshes_are_what_the_script_makes(root, tmp_path):
    """The meshes, but for the last decimal."""
    for name, content in make_still_life.meshes().items():
        (tmp_path / name).write_bytes(content)
        made, stored = read_mesh(tmp_path / name), read_mesh(root / "scenes" / "meshes" / "morning" / name)
        assert (made.faces == stored.faces).all()
        np.testing.assert_allclose(made.vertices, stored.vertices, atol=1.5e-5)


@pytest.mark.parametrize("name", SOLIDS)
def test_what_is_turned_is_closed(name):
    """Every edge belongs to two triangles, once each way; the normals at corners are on the triangles' outer side."""
    edges, volume = collections.Counter(), 0.0
    for profile in SOLIDS[name]:
        points, normals, _, triangles = turned(profile)
        corners = points[triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("tc,tkc->tk", across, normals[triangles]) > 0).all()
        volume += np.einsum("tc,tc->", corners[:, 0], across) / 6
        names = [tuple(np.round(point, 9) + 0.0) for point in points]
        for a, b, c in triangles:
            edges.update([(names[a], names[b]), (names[b], names[c]), (names[c], names[a])])
    assert volume > 0
    assert all(count == 1 and edges[end, start] == 1 for (start, end), count in edges.items())


def test_a_turned_profile_with_a_gap_is_open():
    """The check above has teeth."""
    points, _, _, triangles = turned(make_still_life.lemon()[:-1])
    edges = collections.Counter()
    for corners in triangles:
        named = [tuple(np.round(points[k], 9) + 0.0) for k in corners]
        edges.update(zip(named, named[1:] + named[:1]))
    assert any(edges[end, start] != 1 for start, end in edges)
