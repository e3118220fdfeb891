"""Surfaces of triangles from the leaf records that rays found them in."""

import drjit as dr
import numpy as np
import pytest

from renderer.accel import watertight
from renderer.accel.records import LEAF, NO_PRIMITIVE, PRIMITIVE, TAG, WORDS
from renderer.core.backend import UInt32
from renderer.engine.render import render
from renderer.scene.loader import from_dict
from renderer.scene.meshes import plain_triangles
from renderer.scene.paths import compile_paths
from renderer.scene import structures
from renderer.scene.structures import structure_over
from tests.accel.test_pairs import sphere
from tests.support.documents import CAMERA

SPHERE = np.array([np.roll(corners, k % 3, axis=0) for k, corners in enumerate(sphere(12))])
FACES = np.arange(3 * len(SPHERE)).reshape(-1, 3)
TURNED = np.where(np.arange(len(FACES))[:, None] % 2, FACES, FACES[:, ::-1])


def test_corners_are_the_triangles_own():
    """In their order but for a rotation, so that normals keep their direction."""
    triangles = plain_triangles(SPHERE.reshape(-1, 3), FACES)
    words = structure_over(triangles)._records.numpy().reshape(-1, WORDS)
    leaves = words[words[:, TAG] >= LEAF]
    seen = []
    for word in (PRIMITIVE, watertight.SECOND):
        rows = leaves[leaves[:, word] != NO_PRIMITIVE]
        found = watertight.corners([UInt32(np.ascontiguousarray(column)) for column in rows.T], UInt32(rows[:, word]))
        found, own = np.stack([corner.numpy().T for corner in found], 1), SPHERE[rows[:, word]]
        assert np.logical_or.reduce([(np.roll(own, k, 1) == found).all((1, 2)) for k in range(3)]).all()
        seen += rows[:, word].tolist()
    assert triangles.as_in_records and sorted(seen) == list(range(len(SPHERE)))
    turned = plain_triangles(SPHERE.reshape(-1, 3), TURNED)
    structure_over(turned)
    assert not turned.as_in_records


@pytest.mark.parametrize("beside", [0, 1])
def test_picture_does_not_depend_on_where_surfaces_come_from(beside, tmp_path, monkeypatch):
    """But for rounding, which turns a few paths; `beside` the mesh, other triangles have shapes of their own."""
    lines = [f"v {x} {y} {z}" for x, y, z in SPHERE.reshape(-1, 3).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (FACES + 1).tolist()]
    (tmp_path / "sphere.obj").write_text("\n".join(lines))
    loaded, pictures = from_dict(document(beside), directory=tmp_path), []
    for alike in (True, False):
        monkeypatch.setattr(structures, "turn_alike", lambda *_, alike=alike: alike)
        triangles = compile_paths(loaded).triangles
        assert triangles.as_in_records == alike
        last = dr.opaque(UInt32, triangles.first + triangles.count - 1)
        assert triangles.shape(last, True)[0] == 1 + 1 + beside  # after the floor and the lamp
        channels = render(loaded).channels()
        pictures.append(np.stack([channels[c] for c in "RGB"]))
    assert pictures[0].std() > 0.1 and np.abs(pictures[0] - pictures[1]).mean() < 1e-4 * pictures[0].mean()


def document(beside):
    """Return a scene of the mesh on a floor under a lamp; `beside` triangles lie far below."""
    matt = {"bsdf": {"type": "diffuse", "reflectance": [0.7, 0.5, 0.3]}}
    shapes = [{"type": "mesh", "filename": "sphere.obj", "material": matt},
              {"type": "rectangle", "center": [0, -1, 0], "u": [6, 0, 0], "v": [0, 0, 6], "material": matt}]
    shapes += [{"type": "triangle", "v0": [0, -5, 0], "v1": [1, -5, 0], "v2": [0, -5, 1], "material": matt}] * beside
    light = {"type": "arealight", "position": [1, 3, -1], "u": [1, 0, 0], "v": [0, 0, 1], "intensity": [20, 20, 20]}
    camera = {**CAMERA, "width": 32, "height": 24, "position": [0, 0.5, -4], "lookAt": [0, 0, 0]}
    return {"rendermode": "pathtracer", "nbounces": 4, "samples": 16, "camera": camera,
            "scene": {"backgroundcolor": [0.1, 0.2, 0.3], "lightsources": [light], "shapes": shapes}}
