"""Local frames: orthonormal, right-handed, along the tangent where one is asked for, and inverse to themselves."""

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import Vector3f
from renderer.core.frame import Frame

COUNT = 100_000


def unit_vectors(seed, count=COUNT):
    """Return unit vectors as (3, count) float32, the axes among them."""
    w = np.random.default_rng(seed).normal(size=(3, count))
    w[:, :6] = np.hstack([np.eye(3), -np.eye(3)])
    w[:, 6] = (1e-4, 1e-4, -1)  # near where the frame of a normal has its seam
    return (w / np.linalg.norm(w, axis=0)).astype(np.float32)


def axes(frame):
    """Return t, b, n as (3, count) float64 each."""
    return [np.asarray((part + dr.zeros(Vector3f, COUNT)).numpy(), float) for part in (frame.t, frame.b, frame.n)]


def assert_orthonormal(t, b, n):
    """Check lengths, angles and handedness."""
    for one, other in ((t, b), (b, n), (n, t)):
        np.testing.assert_allclose((one * other).sum(0), 0, atol=2e-6)
        np.testing.assert_allclose((one * one).sum(0), 1, atol=4e-6)
    np.testing.assert_allclose(np.cross(t.T, b.T), n.T, atol=4e-6)


def test_frame_of_a_normal_is_orthonormal():
    """Any normal has a right-handed frame, the poles included."""
    n = unit_vectors(1)
    t, b, kept = axes(Frame.of(Vector3f(*n)))
    assert_orthonormal(t, b, kept)
    np.testing.assert_array_equal(kept, n)


def tangents(n, seed):
    """Return vectors of any length that are not along n."""
    rng = np.random.default_rng(seed)
    v = rng.normal(size=n.shape) * 10.0 ** rng.uniform(-6, 6, n.shape[1])
    angle = abs((v * n).sum(0)) / np.linalg.norm(v, axis=0)
    v[:, angle > 0.99] = np.roll(n, 1, axis=0)[:, angle > 0.99]
    return v.astype(np.float32)


def test_frame_along_a_tangent_follows_it():
    """t is the tangent's part across the normal, of whatever length it is."""
    n = unit_vectors(2)
    dp_du = tangents(n, 3)
    t, b, kept = axes(Frame.along(Vector3f(*n), Vector3f(*dp_du)))
    across = dp_du - n * (n.astype(float) * dp_du).sum(0)
    steep = np.linalg.norm(across, axis=0) > 0.1 * np.linalg.norm(dp_du, axis=0)
    assert steep.mean() > 0.9
    assert_orthonormal(t[:, steep], b[:, steep], kept[:, steep])
    np.testing.assert_allclose(t[:, steep], (across / np.linalg.norm(across, axis=0))[:, steep], atol=1e-5)


@pytest.mark.oracle
def test_frame_along_a_tangent_is_that_of_mitsuba():
    """The frame is what Mitsuba makes of a shading normal and dp_du."""
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("llvm_ad_rgb")
    n = unit_vectors(4)
    dp_du = tangents(n, 5)
    si = dr.zeros(mi.SurfaceInteraction3f, COUNT)
    si.sh_frame.n, si.dp_du = mi.Normal3f(*map(mi.Float, n)), mi.Vector3f(*map(mi.Float, dp_du))
    si.initialize_sh_frame()
    t, b, _ = axes(Frame.along(Vector3f(*n), Vector3f(*dp_du)))
    steep = abs((n * t).sum(0)) < 1e-6
    for ours, theirs in ((t, si.sh_frame.s), (b, si.sh_frame.t)):
        np.testing.assert_allclose(ours[:, steep], np.asarray(theirs.numpy(), float)[:, steep], atol=2e-5)
    assert steep.mean() > 0.9


def test_there_and_back_again():
    """to_world undoes to_local, and z is along the normal."""
    n, v = unit_vectors(6), unit_vectors(7)
    frame = Frame.of(Vector3f(*n))
    local = frame.to_local(Vector3f(*v))
    np.testing.assert_allclose(local.z.numpy(), (n.astype(float) * v).sum(0), atol=1e-6)
    np.testing.assert_allclose(frame.to_world(local).numpy(), v, atol=2e-6)
