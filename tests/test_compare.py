"""Measures of how far pictures are apart: closed forms, symmetries, and what is refused."""

import math
import tracemalloc
from importlib.util import find_spec

import numpy as np
import pytest

from renderer import compare
from renderer.core.srgb import decoded

flip_there = pytest.mark.skipif(find_spec("flip_evaluator") is None, reason="its makers offer no package here")
FLIP = pytest.param(compare.flip, marks=flip_there)
SEEN = (compare.psnr, compare.ssim, FLIP)
MEASURES = (compare.mse, compare.relative_mse, *SEEN)
EQUAL = {"mse": 0.0, "relative_mse": 0.0, "psnr": math.inf, "ssim": 1.0, "flip": 0.0}
SHAPE = (24, 32, 3)


def noise(seed=1, scale=1.0):
    """Return a picture of random radiance."""
    return np.random.default_rng(seed).random(SHAPE) * scale


def even(value):
    """Return a picture of one colour."""
    return np.broadcast_to(np.float64(value), SHAPE)


@pytest.mark.parametrize("measure", MEASURES)
def test_equal_pictures_are_not_apart(measure):
    """Every measure has its best value there."""
    assert measure(noise(), noise()) == pytest.approx(EQUAL[measure.__name__], abs=1e-12)


def test_even_offset_is_its_square():
    """An offset of 0.1 is a squared error of 0.01, whatever lies under it."""
    assert compare.mse(noise() + 0.1, noise()) == pytest.approx(0.01, rel=1e-12)


@pytest.mark.parametrize("reference, expected", [(0.0, 0.04 / 0.01), (0.3, 0.04 / 0.1), (10.0, 0.04 / 100.01)])
def test_relative_error_is_relative_to_the_reference(reference, expected):
    """Squared, with 0.01 under dark pixels."""
    assert compare.relative_mse(even(reference + 0.2), even(reference)) == pytest.approx(expected, rel=1e-12)


def test_error_in_one_channel_of_one_pixel_is_averaged():
    """Means go over pixels and channels."""
    picture = noise().copy()
    picture[3, 5, 1] += 2
    assert compare.mse(picture, noise()) == pytest.approx(4 / picture.size, rel=1e-12)


def test_psnr_is_of_encoded_values():
    """Encoded 0.6 against encoded 0.5 is a tenth of the peak: 20 dB."""
    assert compare.psnr(even(decoded(0.6)), even(decoded(0.5))) == pytest.approx(20, rel=1e-6)
    assert compare.psnr(even(decoded(0.03)), even(decoded(0.02))) == pytest.approx(40, rel=1e-6)


@pytest.mark.parametrize("a, b", [(0.2, 0.7), (0.0, 1.0)])
def test_ssim_of_even_pictures_is_its_luminance_term(a, b):
    """(2 a b + C) / (a^2 + b^2 + C) with C = 0.01^2 for a range of 1; contrast and structure are 1."""
    expected = (2 * a * b + 1e-4) / (a**2 + b**2 + 1e-4)
    assert compare.ssim(even(decoded(a)), even(decoded(b))) == pytest.approx(expected, rel=1e-6)


def test_ssim_agrees_with_a_window_by_hand():
    """One window in the middle of 11 x 11 pixels, its moments under Gaussian weights, the constants of the paper."""
    x, y = noise(2)[:11, :11], noise(3)[:11, :11]
    offsets = np.arange(11) - 5
    weights = np.exp(-(offsets[:, None] ** 2 + offsets**2) / (2 * 1.5**2))[..., None]
    weights = weights / weights.sum()

    def mean(values):
        return (weights * values).sum(axis=(0, 1))

    mx, my = mean(x), mean(y)
    vx, vy, both = mean(x * x) - mx**2, mean(y * y) - my**2, mean(x * y) - mx * my
    c1, c2 = 0.01**2, 0.03**2
    index = (2 * mx * my + c1) * (2 * both + c2) / ((mx**2 + my**2 + c1) * (vx + vy + c2))
    linear = [np.vectorize(decoded)(side) for side in (x, y)]
    assert compare.ssim(*linear) == pytest.approx(index.mean(), rel=1e-6)


@flip_there
def test_flip_of_black_and_white_is_its_colour_term():
    """Even pictures have no edges: what counts is the distance of lightness 0 and 100, mapped as the paper says.

    Distances go to the power 0.7; the largest is that of green and blue (CIELAB after Hunt's correction), and 0.4 of it
    is mapped to 0.95.
    """
    green, blue = np.array([87.737, -86.185, 83.181]), np.array([32.303, 79.197, -107.864])
    green[1:], blue[1:] = green[1:] * 0.01 * green[0], blue[1:] * 0.01 * blue[0]
    largest = (abs(green[0] - blue[0]) + np.hypot(*(green - blue)[1:])) ** 0.7
    distance, knee = 100**0.7, 0.4 * largest
    expected = 0.95 + (distance - knee) / (largest - knee) * 0.05
    assert compare.flip(even(0.0), even(1.0)) == pytest.approx(expected, abs=1e-4)


@flip_there
def test_flip_is_that_of_its_makers():
    """The same as their evaluator says of linear pictures in [0, 1], reference first."""
    from flip_evaluator import flip_python_api

    x, y = (noise(seed).astype(np.float32) for seed in (2, 3))
    _, expected, _ = flip_python_api.evaluate(y, x, "LDR", inputsRGB=False, applyMagma=False)
    assert compare.flip(x, y) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("measure", [compare.mse, *SEEN])
def test_most_measures_are_symmetric(measure):
    """Which of two pictures is the reference matters to the relative error alone."""
    x, y = noise(2), noise(3)
    assert measure(x, y) == pytest.approx(measure(y, x), rel=1e-5)
    assert compare.relative_mse(x, 2 * x) < 0.5 * compare.relative_mse(2 * x, x)


@pytest.mark.parametrize("measure", SEEN)
def test_exposure_comes_before_clipping(measure):
    """Two bright pictures are both white, until the exposure brings them down."""
    x, y = 1 + noise(2), 1 + noise(3)
    assert measure(x, y) == pytest.approx(EQUAL[measure.__name__])
    assert measure(x, y, exposure=0.5) == pytest.approx(measure(0.5 * x, 0.5 * y))
    assert measure(x, y, exposure=0.5) != pytest.approx(EQUAL[measure.__name__], abs=1e-3)


@pytest.mark.parametrize("measure", MEASURES)
def test_more_noise_is_further_away(measure):
    """Each measure puts three levels of noise in their order."""
    reference, error = 0.5 * noise(2), noise(3) - 0.5
    values = [measure(reference + level * error, reference) for level in (0.01, 0.05, 0.2)]
    assert sorted(values, reverse=measure in (compare.psnr, compare.ssim)) == values


@pytest.mark.parametrize("measure", MEASURES)
def test_pictures_are_left_as_they_are(measure):
    """Single precision is taken, computed with in double precision, and not written to."""
    x, y = noise(2).astype(np.float32), noise(3).astype(np.float32)
    kept = x.copy(), y.copy()
    assert isinstance(measure(x, y), float)
    assert (x == kept[0]).all() and (y == kept[1]).all()


def test_small_differences_keep_their_digits():
    """Double precision: an offset of 1e-9 on radiance 100 is its square."""
    assert compare.mse(even(100 + 1e-9), even(100.0)) == pytest.approx(1e-18, rel=1e-4)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("picture, told", [
    (np.ones((24, 31, 3)), "31 x 24 pixels, and the reference 32 x 24"),
    (np.ones((24, 32)), r"picture has shape \(24, 32\)"),
    (np.ones((24, 32, 4)), r"picture has shape \(24, 32, 4\)"),
    (np.ones((0, 32, 3)), r"picture has shape \(0, 32, 3\)"),
])  # fmt: skip
def test_wrong_shapes_are_refused(measure, picture, told):
    """Nothing is broadcast."""
    with pytest.raises(ValueError, match=told):
        measure(picture, noise())


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_nan_and_infinity_are_refused_with_their_place(measure, value):
    """On either side; a black pixel or a zero must not come of them."""
    spoilt = noise().copy()
    spoilt[7, 9, 2] = spoilt[8, 1] = value
    with pytest.raises(ValueError, match="the picture is NaN or infinite in 2 pixels, first at x 9, y 7"):
        measure(spoilt, noise())
    with pytest.raises(ValueError, match="the reference is NaN"):
        measure(noise(), spoilt)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("count", [11, 13])  # rows at a time, of 48: few are left at the end, or many
def test_bands_change_nothing(measure, count, monkeypatch):
    """Large pictures are taken in bands; windows and filters reach beyond their edges, and all have their weight."""
    x, y = (np.random.default_rng(seed).random((48, 16, 3)) * np.linspace(0.2, 1, 48)[:, None, None] for seed in (2, 3))
    whole = measure(x, y)
    monkeypatch.setattr(compare, "BAND", 16 * count)
    assert measure(x, y) == pytest.approx(whole, rel=1e-12 if measure is not compare.flip else 1e-7)


def test_nan_is_found_in_any_band(monkeypatch):
    """Counted over all of them; the first keeps its place in the whole picture."""
    spoilt = noise().copy()
    spoilt[7, 9, 2] = spoilt[20, 1] = math.nan
    monkeypatch.setattr(compare, "BAND", 5 * 32)
    assert compare.not_finite(spoilt) == "NaN or infinite in 2 pixels, first at x 9, y 7"
    assert compare.not_finite(spoilt[8:]) == "NaN or infinite in 1 pixel, first at x 1, y 12"
    assert compare.not_finite(noise()) is None


@pytest.mark.parametrize("measure", [compare.mse, compare.relative_mse, compare.psnr, compare.ssim])
def test_memory_hardly_depends_on_the_size(measure, monkeypatch):
    """Less is taken on the way than a copy of the picture in double precision would need."""
    monkeypatch.setattr(compare, "BAND", 2**12)
    picture = np.broadcast_to(np.float32(0.5), (512, 512, 3))
    measure(picture, picture)  # imports and caches
    tracemalloc.start()
    measure(picture, picture)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 0.5 * picture.size * 8


@pytest.mark.parametrize("exposure", [0, -1, math.nan, math.inf])
def test_exposure_without_meaning_is_refused(exposure):
    """All pictures would be equal."""
    with pytest.raises(ValueError, match="exposure"):
        compare.psnr(noise(), noise(), exposure=exposure)


def test_picture_smaller_than_a_window_is_refused():
    """In words, and not in those of a library."""
    with pytest.raises(ValueError, match="11 x 11 pixels at least; these pictures have 32 x 10"):
        compare.ssim(noise()[:10], noise()[:10])
