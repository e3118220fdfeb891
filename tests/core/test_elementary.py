"""Elementary functions against numpy's in double precision, over the whole range that each promises."""

import math

import numpy as np
import pytest

from renderer.core import elementary
from renderer.core.backend import Float

COUNT = 1_000_001
NEAR_ZERO = 3e-7 if elementary.ON_GPU else 1e-12  # of logarithms
SLACK = 20 if elementary.ON_GPU else 1  # its instructions are approximate


def asked(function, x):
    """Return the function of float32 numbers, in double precision."""
    found = function(Float(x))
    return [np.asarray(part.numpy(), float) for part in (found if isinstance(found, tuple) else (found,))]


def test_sine_and_cosine_of_turns():
    """All of one turn, both ends included."""
    u = np.linspace(0, 1, COUNT, dtype=np.float32)
    sine, cosine = asked(elementary.sincos_turns, u)
    np.testing.assert_allclose(sine, np.sin(2 * math.pi * u.astype(float)), atol=3e-7 * SLACK)
    np.testing.assert_allclose(cosine, np.cos(2 * math.pi * u.astype(float)), atol=3e-7 * SLACK)
    np.testing.assert_allclose(sine**2 + cosine**2, 1, atol=4e-7 * SLACK)


def test_sine_and_cosine_of_an_eighth():
    """An eighth of a turn to both sides."""
    q = np.linspace(-1, 1, COUNT, dtype=np.float32)
    sine, cosine = asked(elementary.sincos_eighth, q)
    np.testing.assert_allclose(sine, np.sin(math.pi / 4 * q.astype(float)), atol=1e-7 * SLACK)
    np.testing.assert_allclose(cosine, np.cos(math.pi / 4 * q.astype(float)), atol=1e-7 * SLACK)


def test_angles_in_the_plane():
    """All quadrants, the axes and the origin included."""
    phi = np.linspace(-math.pi, math.pi, COUNT)
    size = 10.0 ** np.linspace(-6, 6, COUNT)
    y, x = (np.concatenate([wave * size, corner]).astype(np.float32) for wave, corner in
            ((np.sin(phi), [0, 1, -1, 0, 0]), (np.cos(phi), [0, 0, 0, 1, -1])))  # fmt: skip
    found = np.asarray(elementary.atan2(Float(y), Float(x)).numpy(), float)
    np.testing.assert_allclose(found, np.arctan2(y.astype(float), x), atol=4e-7 * SLACK)


def test_polar_angle():
    """From pole to pole; relative where it is small."""
    theta = np.concatenate([np.linspace(0, math.pi, COUNT), 10.0 ** np.linspace(-30, 0, COUNT)])
    cosine, sine = np.cos(theta).astype(np.float32), np.sin(theta).astype(np.float32)
    found = np.asarray(elementary.polar(Float(cosine), Float(sine)).numpy(), float)
    exact = np.arctan2(sine.astype(float), cosine)
    np.testing.assert_allclose(found, exact, rtol=3e-7 * SLACK, atol=1e-30)


def test_logarithm():
    """All magnitudes, and the neighbourhood of 1 relative to the logarithm itself."""
    x = np.concatenate([10.0 ** np.linspace(-37, 38, COUNT), 1 + np.linspace(-0.3, 0.4, COUNT)]).astype(np.float32)
    (found,) = asked(elementary.log2, x)
    np.testing.assert_allclose(found, np.log2(x.astype(float)), rtol=2.5e-7 * SLACK, atol=NEAR_ZERO)


@pytest.mark.parametrize("x", [0.0, 1e-45, -1.0])
def test_logarithm_outside_its_range_is_finite(x):
    """Arguments that no logarithm has do not bring NaN or infinity, which a multiplication with 0 would keep."""
    assert np.isfinite(asked(elementary.log2, np.array([x], np.float32))[0]).all()


def test_power_of_two():
    """All results that are normal, and what lies below."""
    x = np.linspace(-100, 127.4, COUNT, dtype=np.float32)
    (found,) = asked(elementary.exp2, x)
    np.testing.assert_allclose(found, np.exp2(x.astype(float)), rtol=2.5e-7 * SLACK)
    (below,) = asked(elementary.exp2, np.array([-100.5, -200, -1e30], np.float32))
    assert (below <= 2.0**-99).all() and (below >= 0).all()


def test_integer_powers_are_exact():
    """2^n for whole n."""
    n = np.arange(-100, 128).astype(np.float32)
    (found,) = asked(elementary.exp2, n)
    np.testing.assert_allclose(found, np.exp2(n.astype(float)), rtol=1e-6 if elementary.ON_GPU else 0)


def test_logarithm_of_what_is_next_to_one():
    """Relative to the logarithm itself, down to differences from 1 that float32 cannot have."""
    rest = np.concatenate([10.0 ** np.linspace(-30, -0.01, COUNT), np.linspace(0.2, 0.999, COUNT)]).astype(np.float32)
    exact = np.log1p(-rest.astype(float)) / math.log(2)
    x = (1 - rest.astype(float)).astype(np.float32)
    found = elementary.log2_below_1(Float(x), Float(rest)).numpy().astype(float)
    near = rest < 0.9
    np.testing.assert_allclose(found[near], exact[near], rtol=4e-7 * SLACK)
    assert (found <= 0).all() and np.isfinite(elementary.log2_below_1(Float(0), Float([1.0, 2.0])).numpy()).all()


def test_power_of_two_and_what_it_lacks():
    """Each relative to itself, for exponents that are nearly 0 and for those whose power is."""
    x = -np.concatenate([10.0 ** np.linspace(-30, 0, COUNT), np.linspace(0.4, 99, COUNT)]).astype(np.float32)
    power, lack = asked(elementary.exp2_both, x)
    np.testing.assert_allclose(power, np.exp2(x.astype(float)), rtol=3e-7 * SLACK)
    np.testing.assert_allclose(lack, -np.expm1(x.astype(float) * math.log(2)), rtol=3e-7 * SLACK)
    power, lack = asked(elementary.exp2_both, np.array([0, -200, -1e30], np.float32))
    assert lack[0] == 0 and (lack[1:] == 1).all() and (power[1:] > 0).all()
