"""How far a picture is from a reference: five measures.

All take `(picture, reference)`: (H, W, 3) linear radiance, anything that numpy takes, and compute in double precision.
`mse` and `relative_mse` judge radiance as it is. `psnr`, `ssim` and `flip` judge what is seen: both pictures are first
multiplied by `exposure`, clipped to [0, 1] and encoded by the curve of sRGB.

A picture with NaN or infinite values has no distance from anything, so all of them raise ValueError for one, and for
pictures of different sizes. `ssim` and `flip` need the packages of the extra `compare`, imported when they are called.
"""

from __future__ import annotations

import math

import numpy as np

DARK = 0.01  # added to squares of the reference, so that errors of black pixels stay finite
WINDOW = 11  # pixels: side of the Gaussian window of SSIM [Wang2004, sec. III.B]
WINDOW_SIGMA = 1.5  # pixels: its standard deviation


def mse(picture, reference) -> float:
    """Return the mean squared error over pixels and channels, radiance squared."""
    x, y = _checked(picture, reference)
    return float(np.mean((x - y) ** 2))


def relative_mse(picture, reference) -> float:
    """Return the mean of (x - r)^2 / (r^2 + 0.01) over pixels and channels, r being the reference."""
    x, y = _checked(picture, reference)
    return float(np.mean((x - y) ** 2 / (y**2 + DARK)))


def psnr(picture, reference, exposure=1.0) -> float:
    """Return the peak signal-to-noise ratio of the encoded pictures in dB; infinite where they are equal."""
    x, y = _encoded_pair(picture, reference, exposure)
    error = np.mean((x - y) ** 2)
    return -10 * math.log10(error) if error else math.inf


def ssim(picture, reference, exposure=1.0) -> float:
    """Return the structural similarity of the encoded pictures, averaged over channels: 1 where they are equal.

    Gaussian windows of 11 x 11 pixels [Wang2004]; smaller pictures raise ValueError.
    """
    from skimage.metrics import structural_similarity

    x, y = _encoded_pair(picture, reference, exposure)
    height, width, _ = x.shape
    if min(height, width) < WINDOW:
        raise ValueError(f"SSIM needs {WINDOW} x {WINDOW} pixels at least; these pictures have {width} x {height}")
    return float(structural_similarity(x, y, channel_axis=-1, data_range=1.0, gaussian_weights=True,
                                       sigma=WINDOW_SIGMA, use_sample_covariance=False))  # fmt: skip


def flip(picture, reference, exposure=1.0) -> float:
    """Return the mean LDR FLIP error [Andersson2020], 0 (equal) to 1, at the 67 pixels a degree that it assumes.

    Raises ModuleNotFoundError where its makers offer no package: on other machines than x86-64, and Python 3.14.
    """
    from flip_evaluator import flip_python_api

    x, y = (encoded.astype(np.float32) for encoded in _encoded_pair(picture, reference, exposure))
    _, mean, _ = flip_python_api.evaluate(y, x, "LDR", inputsRGB=True, applyMagma=False)
    return float(mean)


def _encoded_pair(picture, reference, exposure):
    """Return both pictures as a screen shows them, in [0, 1]."""
    if not (math.isfinite(exposure) and exposure > 0):
        raise ValueError(f"the exposure is {exposure}, and must be positive and finite")
    return tuple(_encoded(np.clip(side * exposure, 0, 1)) for side in _checked(picture, reference))


def _encoded(x):
    """Return the encoding of IEC 61966-2-1 for x in [0, 1]."""
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def _checked(picture, reference):
    """Return both as (H, W, 3) float64, or raise ValueError."""
    x, y = np.asarray(picture, np.float64), np.asarray(reference, np.float64)
    for name, side in (("picture", x), ("reference", y)):
        if side.ndim != 3 or side.shape[2] != 3 or not side.size:
            raise ValueError(f"the {name} has shape {side.shape}, and (height, width, 3) is needed")
    if x.shape != y.shape:
        sizes = [f"{side.shape[1]} x {side.shape[0]}" for side in (x, y)]
        raise ValueError(f"the picture has {sizes[0]} pixels, and the reference {sizes[1]}")
    for name, side in (("picture", x), ("reference", y)):
        _demand_finite(name, side)
    return x, y


def _demand_finite(name, side):
    """Raise ValueError with the first place where a picture is NaN or infinite."""
    wrong = ~np.isfinite(side).all(axis=2)
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        raise ValueError(f"the {name} is NaN or infinite in {wrong.sum()} pixels, first at x {column}, y {row}")
