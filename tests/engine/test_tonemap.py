"""Tone mapping against its formulae, value by value."""

import numpy as np
import pytest

from renderer.core.backend import Float
from renderer.engine.render import render
from renderer.engine.tonemap import to_bytes
from tests.support.scenes import loaded

VALUES = np.array([0, 1e-4, 0.003, 0.0031308, 0.01, 0.25, 0.5, 0.999, 1, 1.5, 20, 1e20], np.float64)
CURVES = {
    "linear": lambda x: x,
    "reinhard": lambda x: x / (1 + x),
    "filmic": lambda x: (2.51 * x**2 + 0.03 * x) / (2.43 * x**2 + 0.59 * x + 0.14),
}


def srgb(x):
    """Return the sRGB encoding in double precision."""
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("encoding", ["linear", "srgb"])
@pytest.mark.parametrize("scale", [0.1, 1.0, 3.0])
@pytest.mark.parametrize("curve", CURVES)
def test_curve_follows_its_formula(curve, scale, encoding):
    """Scale, curve, clip, encode, round: at most one step of 255 off where the formula meets a rounding edge."""
    got = to_bytes(Float(VALUES), Float(scale), curve, encoding).numpy().astype(int)
    x = np.clip(CURVES[curve](VALUES * scale), 0, 1)
    expected = 255 * (srgb(x) if encoding == "srgb" else x)
    assert np.abs(got - expected).max() <= 0.5 + 1e-3
    assert len(set(got)) >= 5


def test_not_a_number_is_black():
    """A picture never hides a NaN as white."""
    assert to_bytes(Float([float("nan"), 0.5]), Float(1), "linear", "linear").numpy().tolist() == [0, 128]


def test_published_background_value(tmp_path):
    """0.25 is 64 of 255 at the coursework's exposure of 0.1, twice that at 0.2, and overrides win."""
    picture = render(loaded(tmp_path))
    assert set(picture.rgb8()) == {64}
    assert set(picture.rgb8(exposure=0.2)) == {128}
    assert set(picture.rgb8(tonemap="reinhard")) == {51}
    assert set(picture.rgb8(encoding="srgb")) == {137}
    assert set(render(loaded(tmp_path, tonemap="reinhard")).rgb8()) == {51}
    assert set(render(loaded(tmp_path, camera={"exposure": 0.4})).rgb8()) == {255}


def test_path_traced_pictures_are_encoded(tmp_path):
    """After exposure, by the sRGB curve, unless told otherwise; pictures of other modes stay proportional to light."""
    settings = {"backgroundcolor": [0.05, 0.1, 0.4], "camera": {"width": 2, "height": 1, "exposure": 0.2}}
    colour = np.array(settings["backgroundcolor"], np.float64) * 2
    traced = render(loaded(tmp_path, rendermode="pathtracer", samples=2, **settings))
    phong = render(loaded(tmp_path, rendermode="phong", **settings))
    for picture, encoding, expected in (
        (traced, None, srgb(colour)), (traced, "linear", colour), (phong, None, colour), (phong, "srgb", srgb(colour)),
    ):
        got = np.frombuffer(picture.rgb8(encoding=encoding), np.uint8).reshape(2, 3)
        assert np.abs(got - 255 * expected).max() <= 0.5 + 1e-3
    assert np.allclose(traced.channels()["B"], 0.4)
