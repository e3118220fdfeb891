"""Tangents are the derivatives of points by texture coordinates, judged by differences of these along the surface."""

import numpy as np
import pytest

from renderer.core.records import Ray
from renderer.scene.tables import compile_scene
from tests.shapes.test_contract import EXAMPLES, rays_at, size, vectors
from tests.support.scenes import SHAPES, loaded

STEP = 2e-3  # of a shape's size
BOUNDED_UV = ("sphere", "cylinder", "disk")  # u is an angle


def surface_at(scene, p, d):
    """Return normals, uv and tangents (N, ...) where rays along d meet the scene near points p, and which do."""
    ray = Ray(vectors(p - 0.05 * d), vectors(d))
    hit = scene.intersect(ray)
    found = scene.surface(ray, hit, with_uv=True, with_tangents=True)
    parts = (found.p, found.n_geo, found.uv, found.dp_du, found.dp_dv)
    arrays = [np.broadcast_to(part.numpy().T, (len(p), len(part))).astype(float) for part in parts]
    return arrays, hit.valid.numpy()


def misfit(scene, o, d, step, periodic):
    """Return how badly tangents explain the change of uv along the surface, relative, for points far from edges."""
    ray = Ray(vectors(o), vectors(d))
    hit = scene.intersect(ray)
    valid = hit.valid.numpy()
    o, d = o[valid], d[valid]
    p = o + hit.t.numpy()[valid][:, None] * d
    (p, n, uv, dp_du, dp_dv), ok = surface_at(scene, p, d)
    rng = np.random.default_rng(2)
    way = np.cross(n, rng.normal(size=p.shape))
    way *= step / np.linalg.norm(way, axis=1, keepdims=True)
    (p1, n1, uv1, _, _), ok1 = surface_at(scene, p + way, d)
    (p0, n0, uv0, _, _), ok0 = surface_at(scene, p - way, d)
    steep = np.abs((n * d).sum(1)) > 0.3
    keep = ok & ok0 & ok1 & steep & ((n0 * n1).sum(1) > 0.999) & (np.abs(p1 - p0).max(1) < 4 * step)
    change = uv1 - uv0
    if periodic:
        change[:, 0] -= np.round(change[:, 0])
        keep &= np.linalg.norm(dp_du, axis=1) > 100 * step  # the angle changes too fast near a pole
    told = change[:, :1] * dp_du + change[:, 1:] * dp_dv
    return (np.linalg.norm(told - (p1 - p0), axis=1) / np.linalg.norm(p1 - p0, axis=1))[keep]


@pytest.mark.parametrize("shape", [example for example in EXAMPLES if size(example.values[0]) < 20])
def test_tangents_are_derivatives(tmp_path, rng, shape):
    """For every kind, away from edges and poles; in large shapes differences of coordinates drown in rounding."""
    scene = compile_scene(loaded(tmp_path, [shape]))
    error = misfit(scene, *rays_at(shape, rng), STEP, shape["type"] in BOUNDED_UV)
    assert len(error) > 100
    assert np.median(error) < 2e-3 and np.quantile(error, 0.98) < 0.03


@pytest.mark.parametrize("corners", [{}, {"uv0": [0.3, 0.1], "uv1": [0.9, 0.8], "uv2": [-0.4, 2.0]}, {"uv2": [2, 0]}],
                         ids=["usual", "any", "on a line"])
@pytest.mark.parametrize("accel", ["none", "bvh"])
def test_triangles_follow_their_corners(tmp_path, rng, accel, corners):
    """One by one and in a structure; where the coordinates lie on a line, both tangents still span the plane."""
    shape = SHAPES["triangle"][0] | corners
    scene = compile_scene(loaded(tmp_path, [shape | {"material": {"texture": BOARD}}]), accel)
    o, d = rays_at(shape, rng)
    if corners.get("uv2") != [2, 0]:
        error = misfit(scene, o, d, STEP, False)
        assert len(error) > 100 and np.quantile(error, 0.99) < 0.02
        return
    (_, n, _, dp_du, dp_dv), valid = surface_at(scene, o + 0.05 * d, d)
    across = np.cross(dp_du, dp_dv)[valid]
    assert np.abs(np.abs((across * n[valid]).sum(1)) / np.linalg.norm(across, axis=1) - 1).max() < 1e-4


BOARD = {"type": "checkerboard"}


@pytest.mark.parametrize(("shape", "towards"), [
    ({"type": "sphere", "center": [0, 0, 0], "radius": 1}, [0, -1, 0]),
    ({"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 1}, [0, -1, 0]),
    ({"type": "cylinder", "center": [0, 0, 0], "axis": [0, 1, 0], "radius": 1, "height": 1}, [0, -1, 0]),
])
def test_poles_have_directions(tmp_path, shape, towards):
    """At the very pole tangents are finite, not 0, and along the surface."""
    scene = compile_scene(loaded(tmp_path, [shape]))
    o, d = np.array([[0.0, 3, 0]]), np.array([towards], float)
    (_, n, _, dp_du, dp_dv), valid = surface_at(scene, o + 0.05 * d, d)
    assert valid.all()
    for tangent in (dp_du, dp_dv):
        assert np.isfinite(tangent).all() and np.linalg.norm(tangent) > 0
        assert abs((tangent * n).sum()) < 1e-6 * np.linalg.norm(tangent)
