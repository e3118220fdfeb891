"""What is special to triangles: edges that neighbours share, and rays within the plane."""

import numpy as np
import pytest

from renderer.core.records import Ray
from renderer.scene.tables import compile_scene
from tests.shapes.test_contract import vectors
from tests.support.scenes import loaded

CORNERS = np.array([[-1, -0.5, 2], [1, -0.5, 2], [1, -0.5, 0], [-1, -0.5, 0]])  # the coursework's floor


def quad(corners):
    """Return two triangles that share the diagonal from corner 0 to corner 2."""
    triangle = {"type": "triangle"}
    return [triangle | dict(zip(("v0", "v1", "v2"), np.take(corners, order, axis=0).tolist()))
            for order in ((0, 1, 2), (3, 0, 2))]  # fmt: skip


@pytest.mark.parametrize("offset", [0.0, 30.0, 1000.0])
@pytest.mark.parametrize("turned", [False, True])
def test_no_ray_slips_through_a_shared_edge(tmp_path, rng, turned, offset):
    """Rays to points on the diagonal, as exactly as float32 can aim, hit one of the two triangles."""
    corners = CORNERS @ np.linalg.qr(rng.normal(size=(3, 3)))[0] if turned else CORNERS
    corners = np.float32(corners + offset).astype(float)
    scene = compile_scene(loaded(tmp_path, quad(corners)))
    share = rng.uniform(0.01, 0.99, (100_000, 1))
    target = corners[0] * share + corners[2] * (1 - share)
    o = np.float32(offset + rng.normal(size=target.shape) * 2).astype(float)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    sine = np.abs((target - o) @ normal) / np.linalg.norm(target - o, axis=1) / np.linalg.norm(normal)
    steep = sine > 0.05  # flatter rays may miss the plane's patch by rounding of their own direction
    d = (target - o)[steep]
    hit = scene.intersect(Ray(vectors(o[steep]), vectors(d / np.linalg.norm(d, axis=1, keepdims=True))))
    missed = ~hit.valid.numpy()
    # far from the origin float32 cannot aim at the edge, and the quad's plane is only known to the rounding of o
    assert missed.sum() == 0


def test_a_gap_would_be_found(tmp_path, rng):
    """The test above has teeth: pulled apart by 1e-4, some rays get through."""
    triangles = quad(CORNERS)
    triangles[1] = triangles[1] | {name: [x - 1e-4, y, z - 1e-4] for name in ("v0", "v1", "v2")
                                   for x, y, z in [triangles[1][name]]}  # fmt: skip
    scene = compile_scene(loaded(tmp_path, triangles))
    share = rng.uniform(0.01, 0.99, (10_000, 1))
    target = CORNERS[0] * share + CORNERS[2] * (1 - share) - [0.5e-4, 0, 0.5e-4]
    o = target + [0.3, 2, -0.4]
    d = target - o
    hit = scene.intersect(Ray(vectors(o), vectors(d / np.linalg.norm(d, axis=1, keepdims=True))))
    assert not hit.valid.numpy().all()


@pytest.mark.parametrize("kind", ["triangle", "plane", "rectangle", "disk"])
@pytest.mark.parametrize("height", [-0.5, 0.0])
def test_a_ray_within_or_beside_the_plane_misses(tmp_path, rng, kind, height):
    """0 / 0 and x / 0 decide nothing."""
    flat = {
        "plane": {"point": [0, -0.5, 0], "normal": [0, 1, 0]},
        "rectangle": {"center": [0, -0.5, 0], "u": [2, 0, 0], "v": [0, 0, 2]},
        "disk": {"center": [0, -0.5, 0], "normal": [0, 1, 0], "radius": 2},
    }
    sheet = quad(CORNERS)[0] if kind == "triangle" else flat[kind] | {"type": kind}
    scene = compile_scene(loaded(tmp_path, [sheet]))
    o = rng.uniform(-2, 2, (5000, 3))
    o[:, 1] = height
    d = rng.normal(size=o.shape)
    d[:, 1] = 0
    d[:1000, 2] = 0
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    assert not scene.intersect(Ray(vectors(o), vectors(d))).valid.numpy().any()
