"""Maps of normals and heights turn the shading frame as a surface of that shape would."""

import numpy as np
import pytest
from PIL import Image

from renderer.core.backend import Bool
from renderer.core.records import Ray
from renderer.scene.loader import from_dict
from renderer.scene.relief import Relief
from renderer.scene.tables import compile_scene
from renderer.scene.texturing import Texturing
from tests.shapes.test_contract import vectors
from tests.support.scenes import document
from tests.scene.test_texturing import bilinear

rng = np.random.default_rng(4)
SHEET = {"type": "rectangle", "center": [0.1, 0.2, 0.3], "u": [1.2, 0.4, -0.3], "v": [-0.3, 0.9, 0.5]}
HEIGHTS = rng.integers(0, 256, (6, 9), np.uint8)


def frames(folder, shape, o, d):
    """Return frames (t, b, n as (N, 3)) and surfaces where rays meet a shape."""
    loaded = from_dict(document([shape], rendermode="pathtracer"), directory=folder)
    scene = compile_scene(loaded)
    materials = [shape.material for _, shape in loaded.shapes]
    relief = Relief(Texturing(loaded, loaded.shapes), materials)
    assert not relief.flat
    ray = Ray(vectors(o), vectors(d))
    hit = scene.intersect(ray)
    assert hit.valid.numpy().all()
    surface = scene.surface(ray, hit, with_uv=True, with_tangents=True)
    frame = relief.frame(hit.index, surface, Bool(True))
    parts = [np.broadcast_to(part.numpy().T, o.shape).astype(float) for part in (frame.t, frame.b, frame.n)]
    return parts, surface.uv.numpy().T.astype(float)


def aimed_at_sheet(count=2000):
    """Return rays that meet the sheet inside."""
    target = SHEET["center"] + rng.uniform(-0.49, 0.49, (count, 2)) @ [SHEET["u"], SHEET["v"]]
    o = target + rng.normal(size=target.shape)
    d = target - o
    return o, d / np.linalg.norm(d, axis=1, keepdims=True)


def orthonormal(parts):
    """Return whether frames are right-handed and orthonormal."""
    t, b, n = parts
    return np.allclose(np.cross(t, b), n, atol=1e-5) and np.allclose(np.linalg.norm(n, axis=1), 1, atol=1e-5)


@pytest.mark.parametrize("bumpscale", [0.1, -0.4])
def test_bumps_are_those_of_the_moved_surface(tmp_path, bumpscale):
    """Judged by differences of points that are moved by the map's heights, on a sheet that is not square."""
    Image.fromarray(HEIGHTS).convert("RGB").save(tmp_path / "h.png")
    o, d = aimed_at_sheet()
    shape = SHEET | {"material": {"bumpmap": "h.png", "bumpscale": bumpscale}}
    (t, b, n), uv = frames(tmp_path, shape, o, d)
    u, v = np.array(SHEET["u"]), np.array(SHEET["v"])
    up = np.cross(u, v) / np.linalg.norm(np.cross(u, v))

    def moved(uv):
        return uv @ [u, v] + bumpscale * bilinear(HEIGHTS[..., None] / 255, uv) * up

    step = 1e-6
    along = [(moved(uv + move) - moved(uv - move)) / (2 * step) for move in ([step, 0], [0, step])]
    expected = np.cross(*along)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    assert (np.abs(n - expected).max(1) > 1e-4).sum() < 10  # but for those that step over a texel's middle
    assert orthonormal((t, b, n))
    assert np.abs(n @ up).min() < 0.95, "a flat surface would show nothing"
    assert np.abs((t * np.cross(n, u)).sum(1)).max() < 1e-5 and (t @ u).min() > 0


@pytest.mark.parametrize(("byte", "local"), [
    ((128, 128, 255), (0.004, 0.004, 1)), ((230, 128, 200), (0.804, 0.004, 0.569)),
    ((128, 10, 200), (0.004, -0.922, 0.569)),
])
def test_normals_are_in_the_frame_of_the_texture(tmp_path, byte, local):
    """Red along u, green along v made square to it, blue outwards."""
    Image.new("RGB", (2, 2), byte).save(tmp_path / "n.png")
    o, d = aimed_at_sheet(50)
    parts, _ = frames(tmp_path, SHEET | {"material": {"normalmap": "n.png"}}, o, d)
    u, v = np.array(SHEET["u"]), np.array(SHEET["v"])
    n = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    t = u / np.linalg.norm(u)
    expected = np.array(local) @ [t, np.cross(n, t), n]
    assert np.allclose(parts[2], expected / np.linalg.norm(expected), atol=2e-3)
    assert orthonormal(parts)


def test_a_flat_map_leaves_a_ball_as_it_is(tmp_path):
    """Its normal, with t along growing longitude."""
    Image.new("RGB", (2, 2), (77, 77, 77)).save(tmp_path / "h.png")
    o = rng.normal(size=(500, 3)) * 4
    d = -o / np.linalg.norm(o, axis=1, keepdims=True)
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 2, "material": {"bumpmap": "h.png"}}
    (t, b, n), _ = frames(tmp_path, ball, o[np.linalg.norm(o, axis=1) > 2.1], d[np.linalg.norm(o, axis=1) > 2.1])
    outwards = -d[np.linalg.norm(o, axis=1) > 2.1]
    assert np.allclose(n, outwards, atol=1e-5) and orthonormal((t, b, n))
    assert np.abs(t[:, 1]).max() < 1e-5 and (np.cross([0, -1, 0], n) * t).sum(1).min() > 0


def test_without_maps_all_is_flat(tmp_path):
    """And nothing is asked."""
    loaded = from_dict(document([SHEET], rendermode="pathtracer"), directory=tmp_path)
    assert Relief(Texturing(loaded, loaded.shapes), [shape.material for _, shape in loaded.shapes]).flat
