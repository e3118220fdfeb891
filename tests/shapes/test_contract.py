"""What every kind of shape must do, for every registered kind and each of its example settings."""

import numpy as np
import pytest

from renderer.core.backend import Bool, UInt32, Vector3f
from renderer.core.records import NO_SHAPE, Ray
from renderer.scene.geometry import leave
from renderer.scene.tables import compile_scene
from renderer.shapes import KINDS
from tests.support.distances import march, signed_distance
from tests.support.scenes import SHAPES, loaded

RAYS = 20_000
EXAMPLES = [pytest.param(shape, id=f"{kind}{number}") for kind, settings in SHAPES.items()
            for number, shape in enumerate(settings)]  # fmt: skip
SOLIDS = [example for example in EXAMPLES if KINDS[example.values[0]["type"]].solid]


def size(shape):
    """Return the greatest coordinate in a shape's description, the scale of its rounding errors."""
    return max(abs(np.asarray(value, float)).max() for name, value in shape.items() if name != "type")


def vectors(array):
    """Return an (N, 3) array as lanes."""
    return Vector3f(*np.ascontiguousarray(np.asarray(array, np.float32).T))


def rays_at(shape, rng, count=RAYS, inside=False):
    """Return float32 origins around (or inside) a shape and unit directions towards points near it."""
    target = rng.uniform(-1, 1, (count, 3))
    if shape["type"] == "plane":
        target += shape["point"]
    if shape["type"] == "triangle":
        weights = 1.5 * rng.dirichlet((1, 1, 1), count) - 0.5 / 3  # a triangle 1.5 times as large
        target = weights @ np.array([shape["v0"], shape["v1"], shape["v2"]])
    if shape["type"] == "rectangle":
        target = rng.uniform(-0.7, 0.7, (count, 2)) @ np.array([shape["u"], shape["v"]]) + shape["center"]
    o = rng.normal(size=(count, 3)) * 3
    if inside:
        candidates = rng.uniform(-1, 1, (count * 200 if size(shape) < 20 else count, 3))
        o = candidates[signed_distance(shape, candidates) < -1e-4][:count]
        target = rng.normal(size=o.shape) + o
    o = o.astype(np.float32).astype(np.float64)
    d = target[: len(o)] - o
    d = (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(np.float32).astype(np.float64)
    return o, d / np.linalg.norm(d, axis=1, keepdims=True)


def seen(scene, shape, rng):
    """Return what RAYS rays towards a shape hit, and the surface there with its texture coordinates."""
    o, d = rays_at(shape, rng)
    ray = Ray(vectors(o), vectors(d))
    hit = scene.intersect(ray)
    return hit, scene.surface(ray, hit, with_uv=True)


@pytest.fixture
def compiled(request, tmp_path):
    """The compiled scene of one shape."""
    return compile_scene(loaded(tmp_path, [request.param])), request.param


def test_every_registered_kind_has_examples():
    """A new kind is tested as soon as it is registered."""
    assert set(SHAPES) == set(KINDS)


@pytest.mark.parametrize("compiled", EXAMPLES, indirect=True)
def test_distance_agrees_with_marching(compiled, rng):
    """The closest hit is where marching along the ray in double precision first meets the shape."""
    check_distances(*compiled, *rays_at(compiled[1], rng, 4000))


@pytest.mark.parametrize("compiled", SOLIDS, indirect=True)
def test_distance_from_inside_agrees_with_marching(compiled, rng):
    """From inside a solid its far side is hit."""
    check_distances(*compiled, *rays_at(compiled[1], rng, 4000, inside=True))


def check_distances(scene, shape, o, d):
    """Compare the closest hits with marching; only a ray within rounding of a silhouette may differ."""
    hit = scene.intersect(Ray(vectors(o), vectors(d)))
    t, valid = hit.t.numpy(), hit.valid.numpy()
    expected = march(shape, o, d)
    decided = ~np.isnan(expected)
    assert decided.mean() > 0.95, "the yardstick itself must be able to tell"
    differ = decided & (valid != np.isfinite(expected))
    # a ray that passes the silhouette within rounding may go either way
    closest = signed_distance(shape, o + np.where(np.isfinite(expected), expected, t)[:, None] * d)
    assert differ.sum() <= 4 and np.all(np.abs(closest[differ]) < 1e-5 * size(shape))
    both = decided & valid & np.isfinite(expected)
    assert both.sum() > 100
    error = np.abs(t - expected)[both]
    # rounding of the far end of the shape, and of the distance: grazing rays magnify both
    assert np.quantile(error, 0.99) < 4e-6 * (size(shape) + np.median(expected[both]))


@pytest.mark.parametrize("compiled", EXAMPLES, indirect=True)
def test_surface_point_is_on_the_shape(compiled, rng):
    """The surface point satisfies the implicit equation to within a few roundoffs."""
    scene, shape = compiled
    hit, surface = seen(scene, shape, rng)
    p = surface.p.numpy().T[hit.valid.numpy()]
    scale = size(shape) + np.abs(p).max(1)
    assert len(p) > 100
    assert np.all(np.abs(signed_distance(shape, p)) < 8 * 2.0**-24 * scale)


def given_normal(shape):
    """Return the normal of a sheet, of any length."""
    match shape["type"]:
        case "triangle":
            return np.cross(np.subtract(shape["v1"], shape["v0"]), np.subtract(shape["v2"], shape["v0"]))
        case "rectangle":
            return np.cross(shape["u"], shape["v"])
    return np.asarray(shape["normal"])


@pytest.mark.parametrize("compiled", EXAMPLES, indirect=True)
def test_normal_agrees_with_finite_differences(compiled, rng):
    """The normal is the gradient of the signed distance, away from edges; a sheet's is given or its winding's."""
    scene, shape = compiled
    hit, surface = seen(scene, shape, rng)
    valid = hit.valid.numpy()
    p = surface.p.numpy().T[valid].astype(float)
    n = np.broadcast_to(surface.n_geo.numpy().T, (RAYS, 3))[valid]
    assert np.allclose(np.linalg.norm(n, axis=1), 1, atol=1e-6)
    if not KINDS[shape["type"]].solid:
        expected = given_normal(shape)
        assert np.allclose(n, expected / np.linalg.norm(expected), atol=1e-6)
        return
    step = 1e-4
    gradient = np.stack([signed_distance(shape, p + step * e) - signed_distance(shape, p - step * e)
                         for e in np.eye(3)], axis=1) / (2 * step)  # fmt: skip
    smooth = np.abs(np.linalg.norm(gradient, axis=1) - 1) < 1e-6
    assert smooth.mean() > 0.4
    assert np.abs(gradient[smooth] - n[smooth]).max() < 2e-3


@pytest.mark.parametrize("compiled", EXAMPLES, indirect=True)
def test_a_ray_that_leaves_outwards_does_not_hit_again(compiled, rng):
    """No shape shadows itself: convex shapes cannot be met again by a ray that leaves them."""
    scene, shape = compiled
    hit, surface = seen(scene, shape, rng)
    out = rng.normal(size=(RAYS, 3))
    n = surface.n_geo.numpy().T
    out *= np.sign((out * n).sum(1, keepdims=True))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    again = scene.intersect(leave(surface, hit.index, vectors(out)))
    assert not (again.valid & hit.valid).numpy().any()


@pytest.mark.parametrize("compiled", SOLIDS, indirect=True)
def test_a_ray_that_leaves_inwards_hits_the_far_side(compiled, rng):
    """A refracted ray always comes out again, a chord's length later."""
    scene, shape = compiled
    hit, surface = seen(scene, shape, rng)
    inwards = rng.normal(size=(RAYS, 3))
    n = surface.n_geo.numpy().T
    cos = (inwards * n).sum(1, keepdims=True) / np.linalg.norm(inwards, axis=1, keepdims=True)
    inwards *= -np.sign(cos)
    inwards /= np.linalg.norm(inwards, axis=1, keepdims=True)
    far = scene.intersect(leave(surface, hit.index, vectors(inwards)))
    steep = hit.valid.numpy() & (np.abs(cos[:, 0]) > 1e-2)
    assert steep.sum() > 100
    assert far.valid.numpy()[steep].all()
    end = surface.p.numpy().T + far.t.numpy()[:, None] * inwards
    scale = size(shape) + np.abs(end).max(1)
    assert np.all(np.abs(signed_distance(shape, end))[steep] < 1e-5 * scale[steep])


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("compiled", EXAMPLES, indirect=True)
def test_axis_parallel_rays_meet_the_shape(compiled, axis, rng):
    """Direction components that are exactly zero, and origins in the plane of a face, neither miss nor give NaN."""
    scene, shape = compiled
    o = rng.uniform(-0.6, 0.6, (2000, 3)).astype(np.float32).astype(float)
    if shape["type"] == "box":
        o[:200, (axis + 1) % 3] = np.float32(shape["max"][(axis + 1) % 3])
    o[:, axis] = -3
    d = np.zeros_like(o)
    d[:, axis] = 1
    hit = scene.intersect(Ray(vectors(o), vectors(d)))
    t, expected = hit.t.numpy(), march(shape, o, d)
    assert not np.isnan(t).any()
    rest = slice(200, None) if shape["type"] == "box" else slice(None)  # rays within a face may go either way
    decided = ~np.isnan(expected[rest])
    wrong = hit.valid.numpy()[rest] != np.isfinite(expected[rest])
    assert (wrong & decided).sum() <= 2
    good = hit.valid.numpy() & np.isfinite(expected)
    assert np.allclose(t[good], expected[good], atol=2e-5 * size(shape), rtol=1e-4)


@pytest.mark.parametrize("compiled", EXAMPLES, indirect=True)
def test_any_hit_agrees_with_closest_hit(compiled, rng):
    """A segment is blocked exactly when the closest hit lies before its end."""
    scene, shape = compiled
    o, d = rays_at(shape, rng)
    ray = Ray(vectors(o), vectors(d), UInt32(np.full(RAYS, NO_SHAPE, np.uint32)), Bool(False))
    hit = scene.intersect(ray)
    typical = np.median(hit.t.numpy()[hit.valid.numpy()])
    length = (typical * rng.uniform(0.1, 2, RAYS)).astype(np.float32)
    blocked = scene.occluded(ray, type(hit.t)(length), Bool(np.ones(RAYS, bool))).numpy()
    t = hit.t.numpy()
    near_end = np.abs(t - length) < 1e-5 * length
    assert np.array_equal(blocked[~near_end], (t < length)[~near_end])
    assert 0 < blocked.sum() < RAYS


@pytest.mark.parametrize("compiled", EXAMPLES, indirect=True)
def test_texture_coordinates_are_finite_and_in_range(compiled, rng):
    """Shapes with a natural extent map to the unit square."""
    scene, shape = compiled
    hit, surface = seen(scene, shape, rng)
    uv = surface.uv.numpy().T[hit.valid.numpy()]
    assert np.isfinite(uv).all()
    if shape["type"] not in ("plane", "convex"):
        assert uv.min() > -1e-3 and uv.max() < 1 + 1e-3
        assert np.ptp(uv, axis=0).min() > (0.1 if size(shape) < 20 else 1e-4)
