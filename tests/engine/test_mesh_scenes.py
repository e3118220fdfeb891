"""Scenes with meshes and with many triangles: one picture, whatever finds the hits and however the work is split."""

import json

import drjit as dr
import numpy as np
import pytest

from renderer.core import rows
from renderer.core.backend import Float, UInt32, Vector3f
from renderer.core.errors import SceneError
from renderer.core.records import Surface
from renderer.engine.render import render
from renderer.scene.arrange import STRUCTURES
from renderer.scene.geometry import leave
from renderer.scene.loader import load, override
from tests.support.meshes import Model, lump, mesh, write
from tests.support.scenes import MATT, loaded, point_light

FEATURES = ("material_mesh", "shape_mesh", "shape_mesh_smooth", "shape_mesh_transform", "texture_mesh")
LIGHTS = [point_light([2, 3, -4])]
SQUARE = Model(np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0.0]]), np.array([[0, 3, 2], [0, 2, 1]]))
BOARD = MATT | {"texture": {"type": "checkerboard"}}


def colours(scene, **settings):
    """Return the (H, W, 3) picture."""
    channels = render(scene, **settings).channels()
    return np.stack([channels[name] for name in "RGB"], axis=-1)


def texture_coordinates(scene):
    """Return u and v, (H, W) each."""
    channels = render(override(scene, mode="uv")).channels()
    return channels["U"], channels["V"]


@pytest.mark.parametrize("name", FEATURES)
def test_every_structure_gives_the_same_bytes(root, name):
    """What a ray meets does not depend on what finds it."""
    scene = override(load(root / "scenes" / "features" / f"{name}.json"), width=90, height=60)
    whole = colours(scene)
    assert whole.std() > 0.05, "an even picture shows nothing"
    for accel in STRUCTURES:
        assert np.array_equal(colours(scene, accel=accel), whole), accel


def test_triangles_outside_of_a_structure_give_the_same_picture(root):
    """They are then tested by another formula, so the same is within rounding."""
    scene = override(load(root / "scenes" / "features" / "shape_triangle_soup.json"), width=90, height=60)
    pictures = {accel: colours(scene, accel=accel) for accel in STRUCTURES}
    outside = pictures.pop("none")
    assert np.abs(outside - pictures["auto"]).max() < 1e-5
    for accel, picture in pictures.items():
        assert np.array_equal(picture, pictures["auto"]), accel


def test_threads_do_not_change_a_bit(root):
    """Also with mirrors, glass and a hierarchy."""
    scene = override(load(root / "scenes" / "features" / "material_mesh.json"), width=90, height=60, samples=4)
    before, pictures = dr.thread_count(), []
    try:
        for threads in (1, 2, 5):
            dr.set_thread_count(threads)
            pictures.append(colours(scene))
    finally:
        dr.set_thread_count(before)
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])


def test_order_of_shapes_does_not_show(tmp_path):
    """Meshes and others, named in another order, are the same scene but for the numbers of its shapes."""
    write(tmp_path / "a.ply", lump())
    write(tmp_path / "b.obj", lump(50))
    ball = {"type": "sphere", "center": [-0.9, 0.5, -0.5], "radius": 0.4, "material": MATT}
    shapes = [mesh("a.ply", MATT), mesh("b.obj", MATT, {"translate": [0.8, -0.3, -0.4]}), ball]
    whole = colours(loaded(tmp_path, shapes, LIGHTS))
    for order in ((2, 1, 0), (1, 2, 0), (0, 2, 1)):
        assert np.array_equal(colours(loaded(tmp_path, [shapes[k] for k in order], LIGHTS)), whole)


def sheets(count, material):
    """Return squares of two triangles each, one before the other, the foremost with uv of its own."""
    made = []
    for k in range(count):
        z = k / count
        corners = ({"v0": [-1, -1, z], "v1": [-1, 1, z], "v2": [1, 1, z]},
                   {"v0": [-1, -1, z], "v1": [1, 1, z], "v2": [1, -1, z]})  # fmt: skip
        uv = {"uv0": [0, 1], "uv1": [0, 0], "uv2": [1, 0]}, {"uv0": [0, 1], "uv1": [1, 0], "uv2": [1, 1]}
        made += [{"type": "triangle", **corner, **own, "material": material} for corner, own in zip(corners, uv)]
    return made


@pytest.mark.parametrize("material", [MATT, BOARD], ids=["plain", "textured"])
@pytest.mark.parametrize("count", [1, rows.UNROLL_LIMIT])
def test_texture_coordinates_of_triangles_are_theirs(tmp_path, count, material):
    """Few or many, textured or not: u runs to the right, and v down, over the square that is seen first."""
    scene = loaded(tmp_path, sheets(count, material))
    u, v = texture_coordinates(scene)
    seen = u + v != 0
    assert seen.sum() > 20
    x, y = np.meshgrid(np.arange(16) + 0.5 - 8, np.arange(12) + 0.5 - 6)
    step = 4 * np.tan(np.radians(20)) / 6  # width of a pixel where the square is
    assert np.allclose(u[seen], 0.5 + x[seen] * step / 2, atol=1e-5)
    assert np.allclose(v[seen], 0.5 + y[seen] * step / 2, atol=1e-5)


@pytest.mark.parametrize("material", [MATT, BOARD], ids=["plain", "textured"])
@pytest.mark.parametrize("mirrored", [False, True])
def test_mesh_without_texture_coordinates_has_those_of_triangles(tmp_path, mirrored, material):
    """(0, 0), (1, 0) and (0, 1) at the corners, in the order of the file, whatever other meshes bring."""
    write(tmp_path / "plain.ply", SQUARE)
    write(tmp_path / "other.ply", lump(8).but(vertices=lump(8).vertices + [0, 0, 50]))
    steps = [{"scale": [-1, 1, 1]}] if mirrored else []
    alone, beside = (texture_coordinates(loaded(tmp_path, [mesh("plain.ply", material, *steps), *other]))
                     for other in ([], [mesh("other.ply", BOARD)]))  # fmt: skip
    x, y = np.meshgrid(np.arange(16) + 0.5 - 8, np.arange(12) + 0.5 - 6)
    step = 4 * np.tan(np.radians(20)) / 6
    x, y = (-x if mirrored else x) * step / 2 + 0.5, 0.5 - y * step / 2  # from the first corner, 0 to 1
    seen = (abs(x - 0.5) < 0.5) & (abs(y - 0.5) < 0.5) & (abs(x - y) > 1e-6)
    # in the upper triangle the second corner is the upper left one and the third the upper right one; so on
    u, v = np.where(y > x, y - x, y), np.where(y > x, x, x - y)
    for pair in (alone, beside):
        assert np.allclose(pair[0][seen], u[seen], atol=1e-5) and np.allclose(pair[1][seen], v[seen], atol=1e-5)


def test_interpolated_normal_that_faces_away_is_not_used(tmp_path):
    """Normals that lean to the far side would turn what is seen dark; the triangle's own serves there."""
    normals = np.array([[0.0, 0.1, -1], [0.0, 0.1, -1], [0.0, 1, 0.4], [0.0, 1, 0.4]])
    write(tmp_path / "a.ply", SQUARE.but(normals=normals))
    light = point_light([0, 0, -1e4])
    material = MATT | {"kd": 1.0, "diffusecolor": [1, 1, 1]}
    picture = colours(loaded(tmp_path, [mesh("a.ply", material)], [light], ambientlight=[0, 0, 0]))[..., 0]
    y = 0.5 - (np.arange(12) + 0.5 - 6) * 4 * np.tan(np.radians(20)) / 12
    down, up = normals[[0, 2]] / np.linalg.norm(normals[[0, 2]], axis=1, keepdims=True)
    n = (1 - y)[:, None] * down + y[:, None] * up
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    towards = np.stack([0 * y, (y - 0.5) * 2, 4 + 0 * y], axis=1)
    facing = (n * towards).sum(1) < 0  # as the viewer sees it
    expected = np.where(facing, -n[:, 2], 1.0)
    rows_seen = (y > 0.02) & (y < 0.98)
    assert facing[rows_seen].any() and not facing[rows_seen].all()
    assert np.allclose(picture[rows_seen, 8], expected[rows_seen], atol=2e-3)


@pytest.mark.parametrize("name, text, told", [
    ("a.obj", "v 0 0 0\nf 1 1 7\n", "a.obj:2"),
    ("a.ply", "ply\nformat ascii 1.0\nend_header\n", "a.ply"),
])
def test_mistake_in_a_mesh_file_is_told_with_its_shape(tmp_path, name, text, told):
    """The file, the line, and the place in the scene."""
    (tmp_path / name).write_text(text)
    with pytest.raises(SceneError) as caught:
        render(loaded(tmp_path, [mesh(name, MATT)]))
    (problem,) = caught.value.problems
    assert problem.key_path == "scene.shapes[0].filename" and told in problem.message


def test_the_soup_is_what_the_script_makes(root, tmp_path):
    """The meshes and the soup of the feature scenes can be made anew."""
    import runpy

    made = runpy.run_path(str(root / "scenes" / "meshes" / "make_meshes.py"))
    assert made["torus"]() == (root / "scenes" / "meshes" / "torus.obj").read_text()
    assert made["rock"]() == (root / "scenes" / "meshes" / "rock.ply").read_text()
    soup = made["soup"]()
    assert soup == (root / "scenes" / "features" / "shape_triangle_soup.json").read_text()
    corners = {tuple(shape[v]) for shape in json.loads(soup)["scene"]["shapes"][1:] for v in ("v0", "v1", "v2")}
    assert len(corners) == 3 * made["TRIANGLES"]


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_rays_leave_by_the_side_of_the_triangle(up):
    """Not by that of the interpolated normal, of which a ray may be on the other side."""
    surface = Surface(Vector3f(0), Vector3f(0, 0, 1), rounding=Float(0.25), n_smooth=dr.normalize(Vector3f(1, 0, 0.1)))
    ray = leave(surface, UInt32(3), dr.normalize(Vector3f(-up, 0, 0.05 * up)))
    assert ray.o.z[0] == 0.25 * up and ray.left_inwards[0] == (up < 0) and ray.left_index[0] == 3
