"""Textures of path-traced materials: each record's own, decoded or not, at the right scale."""

import numpy as np
import pytest
from PIL import Image

from renderer.bsdfs import KINDS
from renderer.core import srgb
from renderer.core.backend import Bool, Float, UInt32, Vector2f, Vector3f
from renderer.core.errors import SceneError
from renderer.core.records import Ray
from renderer.core.rows import Rows
from renderer.scene.arrange import arrange
from renderer.scene.geometry import Geometry
from renderer.scene.loader import from_dict
from renderer.scene.texturing import AS_WRITTEN, COLOUR, NUMBER, Texturing, use_of, uses_of
from tests.shapes.test_contract import vectors
from tests.support.scenes import document

rng = np.random.default_rng(8)
PICTURE = rng.integers(0, 256, (5, 7, 3), np.uint8)
OTHER = rng.integers(0, 256, (2, 3, 3), np.uint8)
UV = rng.uniform(-1, 2, (4000, 2)).astype(np.float32)
BOARD = {"type": "checkerboard", "color1": [0.1, 0.2, 0.3], "color2": [0.9, 0.8, 0.7], "scale": 2}


@pytest.fixture
def folder(tmp_path):
    """A folder with two pictures."""
    Image.fromarray(PICTURE).save(tmp_path / "a.png")
    Image.fromarray(OTHER).save(tmp_path / "b.png")
    return tmp_path


def scene(folder, *materials):
    """Return the loaded scene of a ball for each material."""
    balls = [{"type": "sphere", "center": [3 * k, 0, 0], "radius": 1, "material": m} for k, m in enumerate(materials)]
    return from_dict(document(balls, rendermode="pathtracer", backgroundcolor=[1, 1, 1]), directory=folder)


def slot_of(loaded, key, form, at_bsdf=True):
    """Return the slot of one key of all materials."""
    materials = [shape.material for _, shape in loaded.shapes]
    uses = [use_of(m, m.bsdf if at_bsdf else m, key) for m in materials]
    texturing = Texturing(loaded, loaded.shapes)
    scales = [material.bumpscale for material in materials]
    return texturing.heights(uses, scales) if form == "heights" else texturing.slot(uses, form)


def at(slot, number, uv, plain):
    """Return the values of record `number` in lanes, asked by a lane index."""
    lanes = UInt32(np.full(len(uv), number, np.uint32))
    return slot.value(slot.rows.row(lanes, Bool(True)), Vector2f(uv[:, 0], uv[:, 1]), Bool(True), plain).numpy()


def bilinear(values, uv):
    """Return the repeated, interpolated values (H, W, C) at (N, 2) coordinates."""
    height, width = values.shape[:2]
    x, y = uv[:, 0] * width - 0.5, uv[:, 1] * height - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = (x - i)[:, None], (y - j)[:, None]
    texel = lambda i, j: values[j % height, i % width]  # noqa: E731
    return ((texel(i, j) * (1 - a) + texel(i + 1, j) * a) * (1 - b)
            + (texel(i, j + 1) * (1 - a) + texel(i + 1, j + 1) * a) * b)  # fmt: skip


LINEAR = np.array(srgb.BYTES)


def test_colours_are_decoded_before_they_are_mixed(folder):
    """Each record has its own picture, scale and filter, or none."""
    diffuse = lambda reflectance: {"bsdf": {"type": "diffuse", "reflectance": reflectance}}  # noqa: E731
    loaded = scene(
        folder, diffuse("a.png"), diffuse([0.5, 0.25, 0.125]), diffuse("b.png") | {"scaleU": 3, "scaleV": 0.5},
        diffuse(BOARD), diffuse("b.png") | {"texturefilter": "nearest"},
    )
    slot = slot_of(loaded, "reflectance", COLOUR)
    plain = Vector3f(0.5, 0.25, 0.125)
    uv = UV.astype(float)
    assert np.abs(at(slot, 0, UV, plain).T - bilinear(LINEAR[PICTURE], uv)).max() < 5e-5
    assert np.allclose(at(slot, 1, UV, plain).T, [0.5, 0.25, 0.125])
    assert np.abs(at(slot, 2, UV, plain).T - bilinear(LINEAR[OTHER], uv * [3, 0.5])).max() < 1e-4
    odd = np.floor(2 * uv).sum(1) % 2 == 1
    assert np.allclose(at(slot, 3, UV, plain).T, np.where(odd[:, None], BOARD["color2"], BOARD["color1"]))
    texels = np.floor(uv * [3, 2]).astype(int) % [3, 2]
    wrong = np.abs(at(slot, 4, UV, plain).T - LINEAR[OTHER][texels[:, 1], texels[:, 0]]).max(1) > 5e-5
    assert wrong.sum() < 5


def test_every_byte_is_decoded_as_the_standard_says(folder):
    """To 4e-5 of its value; white stays white, and no byte gets brighter than it."""
    Image.fromarray(np.arange(256, dtype=np.uint8).reshape(1, 256)).save(folder / "ramp.png")
    loaded = scene(folder, {"bsdf": {"type": "diffuse", "reflectance": "ramp.png"}, "texturefilter": "nearest"})
    uv = np.stack([(np.arange(256) + 0.5) / 256, np.full(256, 0.5)], 1).astype(np.float32)
    red = at(slot_of(loaded, "reflectance", COLOUR), 0, uv, Vector3f(0))[0]
    assert red[0] == 0 and abs(red[255] - 1) < 3e-7
    assert np.abs(red[1:] / LINEAR[1:] - 1).max() < 4e-5
    assert (np.diff(red) > 0).all()


def test_numbers_are_red_as_written(folder):
    """Of pictures and of boards."""
    rough = lambda alpha: {"bsdf": {"type": "roughconductor", "alpha": alpha}}  # noqa: E731
    slot = slot_of(scene(folder, rough("a.png"), rough(0.3), rough(BOARD)), "alpha", NUMBER)
    got = at(slot, 0, UV, Float(0.3))
    assert np.abs(got - bilinear(PICTURE[..., :1] / 255, UV.astype(float))[:, 0]).max() < 2e-5
    assert np.allclose(at(slot, 1, UV, Float(0.3)), 0.3)
    assert np.allclose(np.unique(at(slot, 2, UV, Float(0.3))), [0.1, 0.9])


def test_one_texture_for_all_needs_no_choice(folder):
    """The value of a single record is the texture's, without a lane index."""
    slot = slot_of(scene(folder, {"normalmap": "a.png"}), "normalmap", AS_WRITTEN, at_bsdf=False)
    got = slot.value(slot.rows[0], Vector2f(UV[:, 0], UV[:, 1]), Bool(True), None).numpy().T
    assert np.abs(got - bilinear(PICTURE / 255, UV.astype(float))).max() < 2e-5


def test_slopes_are_differences_of_heights(folder):
    """Per unit of the surface's own coordinates, so the repetitions count."""
    bumps = {"bumpmap": "a.png", "scaleU": 2, "scaleV": 0.5, "texturefilter": "nearest", "bumpscale": -0.3}
    slot = slot_of(scene(folder, bumps, {}), "bumpmap", "heights", at_bsdf=False)
    got = at(slot, 0, UV, Vector2f(0)).T
    uv, heights, step = UV.astype(float), -0.3 * PICTURE[..., :1] / 255, 1e-6
    wanted = np.stack([
        (bilinear(heights, (uv + move) * [2, 0.5]) - bilinear(heights, (uv - move) * [2, 0.5]))[:, 0] / (2 * step)
        for move in ([step, 0], [0, step])
    ], 1)  # fmt: skip
    assert (np.abs(got - wanted).max(1) > 1e-3).sum() < 5  # those that step over a texel's middle
    assert not at(slot, 1, UV, Vector2f(0)).any()


def test_parameters_of_a_bsdf_are_overlaid(folder):
    """A record's row shows the textures' values in their columns, and its own in the others."""
    kind = KINDS["roughconductor"]
    rough = lambda **keys: {"bsdf": {"type": "roughconductor", **keys}}  # noqa: E731
    loaded = scene(folder, rough(alpha="a.png", reflectance="b.png"), rough(alpha=0.25, reflectance=[0.5, 0.6, 0.7]))
    members = [(shape.material, shape.material.bsdf) for _, shape in loaded.shapes]
    rows = Rows([kind.pack(bsdf, 1.0) for _, bsdf in members])
    parameters = Texturing(loaded, loaded.shapes).parameters(kind, members)
    (reflectance, _), (alpha, _) = kind.textured["reflectance"], kind.textured["alpha"]
    for number in range(2):
        lanes = UInt32(np.full(len(UV), number, np.uint32))
        pick = lambda rows: rows.row(lanes, Bool(True))  # noqa: B023, E731
        p = parameters.over(pick, pick(rows), Vector2f(UV[:, 0], UV[:, 1]), Bool(True))
        wide = [np.broadcast_to(part, len(UV)) for part in p.vector(reflectance).numpy()]
        if number:
            assert np.allclose(wide, np.array([[0.5], [0.6], [0.7]])) and np.allclose(p[alpha].numpy(), 0.25)
        else:
            assert np.abs(np.array(wide).T - bilinear(LINEAR[OTHER], UV.astype(float))).max() < 5e-5
            expected = bilinear(PICTURE[..., :1] / 255, UV.astype(float))[:, 0]
            assert np.abs(p[alpha].numpy() - expected).max() < 2e-5
            assert np.array_equal(p[reflectance + 1].numpy(), wide[1])
        others = set(range(rows.width)) - {alpha, *range(reflectance, reflectance + 3)}
        assert all(np.allclose(p[c].numpy(), pick(rows)[c].numpy()) for c in others)
    first, second = (uses_of(kind, *member) for member in members)
    assert first != second and second == (None, None)


def test_without_textures_there_is_no_slot(folder):
    """And nothing in the kernel."""
    loaded = scene(folder, {"bsdf": {"type": "diffuse"}, "texture": "a.png"})
    assert slot_of(loaded, "reflectance", COLOUR) is None
    assert slot_of(loaded, "bumpmap", "heights", at_bsdf=False) is None
    members = [(shape.material, shape.material.bsdf) for _, shape in loaded.shapes]
    assert Texturing(loaded, loaded.shapes).parameters(KINDS["diffuse"], members) is None


@pytest.mark.parametrize(("material", "where"), [
    ({"texture": "bad.png"}, "texture"), ({"normalmap": "bad.png"}, "normalmap"),
    ({"bsdf": {"type": "roughconductor", "alpha": "bad.png"}}, "bsdf.alpha"),
])
def test_a_damaged_picture_is_told_with_its_place(folder, material, where):
    """At the key that names it."""
    (folder / "bad.png").write_bytes(b"not a picture")
    loaded = scene(folder, {}, material)
    with pytest.raises(SceneError) as caught:
        Texturing(loaded, loaded.shapes)
    (problem,) = caught.value.problems
    assert problem.key_path == f"scene.shapes[1].material.{where}"


@pytest.mark.parametrize(("material", "mode", "wanted"), [
    ({"bsdf": {"type": "diffuse", "reflectance": BOARD}}, "pathtracer", True),
    ({"bsdf": {"type": "diffuse", "reflectance": BOARD}}, "phong", False),
    ({"bumpmap": "a.png"}, "pathtracer", True),
    ({"texture": BOARD}, "phong", True),
    ({"texture": BOARD, "bsdf": {"type": "diffuse"}}, "pathtracer", False),
    ({"bsdf": {"type": "principled", "anisotropic": 0.5}}, "pathtracer", True),
])
def test_triangles_in_a_structure_keep_their_coordinates_where_they_count(folder, material, mode, wanted):
    """For textures, maps and stretched highlights of the mode; elsewhere vertices stay small."""
    triangle = {"type": "triangle", "v0": [0, 0, 0], "v1": [1, 0, 0], "v2": [0, 1, 0], "uv1": [0.5, 0.5]}
    content = document([triangle | {"material": material}], rendermode=mode, backgroundcolor=[1, 1, 1])
    _, geometry = arrange(from_dict(content, directory=folder), "bvh")
    o, d = np.array([[0.5, 0.25, -1.0]]), np.array([[0.0, 0, 1]])
    scene = Geometry(**geometry)
    ray = Ray(vectors(o), vectors(d))
    uv = scene.surface(ray, scene.intersect(ray), with_uv=True).uv.numpy().ravel()
    # corner weights are 1/2 and 1/4
    assert np.allclose(uv, [0.25, 0.5] if wanted else [0.5, 0.25], atol=1e-6)
