"""The files of our scenes are what their scripts make."""

import numpy as np
import pytest
from PIL import Image

from renderer.io.mesh import read_mesh
from scenes import make_lanterns, make_nautilus
from scenes.making import ply, text


@pytest.mark.parametrize("name, script", [("lanterns", make_lanterns), ("nautilus", make_nautilus)])
def test_scene_is_what_its_script_makes(root, name, script):
    """To the letter; meshes to a unit of the last digit that is written, as libraries may round otherwise."""
    scenes = root / "scenes"
    assert text(script.scene()) == (scenes / f"{name}.json").read_text()
    made = script.meshes()
    assert {path.stem for path in (scenes / "meshes" / name).iterdir()} == set(made)
    for stem, (vertices, uv, triangles) in made.items():
        path = scenes / "meshes" / name / f"{stem}.ply"
        held = read_mesh(str(path))
        assert path.stat().st_size == len(ply(vertices, triangles, uv=uv))
        np.testing.assert_allclose(held.vertices, vertices, rtol=0, atol=2e-5)
        np.testing.assert_allclose(held.uv, uv, rtol=0, atol=2e-5)
        np.testing.assert_array_equal(held.faces, triangles)


@pytest.mark.parametrize("name, made", [("ripples", make_lanterns.waves), ("mist", make_lanterns.mist)])
def test_image_is_what_the_script_makes(root, name, made):
    """To a unit of 8 bits."""
    held = np.asarray(Image.open(root / "scenes" / "textures" / f"{name}.png"), int)
    assert np.abs(held - np.asarray(made(), int)).max() <= 1


def test_sky_is_what_the_script_makes(root):
    """Half floats keep three digits."""
    from renderer.io.image import read_environment

    held = np.asarray(read_environment(str(root / "scenes" / "textures" / "dusk.exr")))
    np.testing.assert_allclose(held, make_lanterns.dusk().astype(float), rtol=2e-3)
