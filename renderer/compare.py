"""How far a picture is from a reference: five measures.

All take `(picture, reference)`: (H, W, 3), anything that numpy takes, and compute in double precision. `mse` and
`relative_mse` judge linear radiance as it is. `psnr`, `ssim` and `flip` judge what is seen: both pictures are first
multiplied by `exposure`, clipped to [0, 1] and encoded by the curve of sRGB. `psnr_of_seen`, `ssim_of_seen` and
`flip_of_seen` take pictures that already are what is seen, of one size and without NaN.

A picture with NaN or infinite values has no distance from anything, so the five raise ValueError for one, and for
pictures of different sizes. SSIM and FLIP need the packages of the extra `compare`, imported when they are called.

Large pictures are taken in bands of rows, so that the memory needed hardly depends on their size.
"""

from __future__ import annotations

import math

import numpy as np

from renderer.core.tones import shown

BAND = 2**20  # pixels computed at a time: SSIM takes 44 and FLIP 110 bytes for each
DARK = 0.01  # added to squares of the reference, so that errors of black pixels stay finite
WINDOW = 11  # pixels: side of the Gaussian window of SSIM [Wang2004, sec. III.B]
WINDOW_SIGMA = 1.5  # pixels: its standard deviation
FLIP_REACH = 10  # pixels: 3 sigma of FLIP's widest filter, sqrt(0.04 / 2) / pi degrees of 67 pixels [Andersson2020]


class Rows:
    """A picture whose rows are computed from another's when they are asked for: `picture[rows]` as of an array."""

    def __init__(self, pixels, change):
        self.shape, self._pixels, self._change = pixels.shape, pixels, change

    def __getitem__(self, rows):
        return self._change(self._pixels[rows])


def mse(picture, reference) -> float:
    """Return the mean squared error over pixels and channels, radiance squared."""
    return _mean(*_checked(picture, reference), lambda x, r: (x - r) ** 2)


def relative_mse(picture, reference) -> float:
    """Return the mean of (x - r)^2 / (r^2 + 0.01) over pixels and channels, r being the reference."""
    return _mean(*_checked(picture, reference), lambda x, r: (x - r) ** 2 / (r**2 + DARK))


def psnr(picture, reference, exposure=1.0) -> float:
    """Return the peak signal-to-noise ratio of the encoded pictures in dB; infinite where they are equal."""
    return psnr_of_seen(*_encoded_pair(picture, reference, exposure))


def ssim(picture, reference, exposure=1.0) -> float:
    """Return the structural similarity of the encoded pictures, averaged over channels: 1 where they are equal.

    Gaussian windows of 11 x 11 pixels [Wang2004]; smaller pictures raise ValueError.
    """
    return ssim_of_seen(*_encoded_pair(picture, reference, exposure))


def flip(picture, reference, exposure=1.0) -> float:
    """Return the mean LDR FLIP error [Andersson2020], 0 (equal) to 1, at the 67 pixels a degree that it assumes.

    Raises ModuleNotFoundError where its makers offer no package: on other machines than x86-64, and Python 3.14.
    """
    return flip_of_seen(*_encoded_pair(picture, reference, exposure))


def psnr_of_seen(x, y) -> float:
    """Return the PSNR of pictures in [0, 1]."""
    error = _mean(x, y, lambda a, b: (a - b) ** 2)
    return -10 * math.log10(error) if error else math.inf


def ssim_of_seen(x, y) -> float:
    """Return the SSIM of pictures in [0, 1]."""
    from skimage.metrics import structural_similarity

    height, width, _ = x.shape
    if min(height, width) < WINDOW:
        raise ValueError(f"SSIM needs {WINDOW} x {WINDOW} pixels at least; these pictures have {width} x {height}")
    edge, total = WINDOW // 2, []
    for rows in bands(height - 2 * edge, width):  # of windows' middles, which keep away from the edges
        both = (_doubles(side[rows.start : rows.stop + 2 * edge]) for side in (x, y))
        index = structural_similarity(*both, channel_axis=-1, data_range=1.0, gaussian_weights=True,
                                      sigma=WINDOW_SIGMA, use_sample_covariance=False)  # fmt: skip
        total.append(index * (rows.stop - rows.start))
    return math.fsum(total) / (height - 2 * edge)


def flip_of_seen(x, y) -> float:
    """Return the FLIP error of pictures in [0, 1]."""
    from flip_evaluator import flip_python_api

    height, width, _ = x.shape
    total = []
    for rows in bands(height, width):
        first = max(rows.start - FLIP_REACH, 0)
        both = (np.ascontiguousarray(side[first : rows.stop + FLIP_REACH], np.float32) for side in (y, x))
        errors, _, _ = flip_python_api.evaluate(*both, "LDR", inputsRGB=True, applyMagma=False, computeMeanError=False)
        total.append(errors[rows.start - first : rows.stop - first].sum(dtype=np.float64))
    return math.fsum(total) / (height * width)


def bands(height, width):
    """Yield slices of rows that cover a picture, each of about BAND pixels."""
    count = max(BAND // width, 1)
    for start in range(0, height, count):
        yield slice(start, min(start + count, height))


def _mean(x, y, function):
    """Return the mean of a function of both pictures over pixels and channels."""
    height, width, channels = x.shape
    sums = (function(_doubles(x[rows]), _doubles(y[rows])).sum() for rows in bands(height, width))
    return math.fsum(sums) / (height * width * channels)


def _doubles(values):
    return np.asarray(values, np.float64)


def _encoded_pair(picture, reference, exposure):
    """Return both pictures as a screen shows them, in [0, 1]."""
    if not (math.isfinite(exposure) and exposure > 0):
        raise ValueError(f"the exposure is {exposure}, and must be positive and finite")

    def encoded(rows):
        return shown(_doubles(rows) * exposure, "linear", "srgb", np.where)

    return tuple(Rows(side, encoded) for side in _checked(picture, reference))


def _checked(picture, reference):
    """Return both as they are, or as arrays, or raise ValueError."""
    x, y = (side if hasattr(side, "shape") else np.asarray(side, np.float64) for side in (picture, reference))
    for name, side in (("picture", x), ("reference", y)):
        if len(side.shape) != 3 or side.shape[2] != 3 or not math.prod(side.shape):
            raise ValueError(f"the {name} has shape {side.shape}, and (height, width, 3) is needed")
    if x.shape != y.shape:
        sizes = [f"{side.shape[1]} x {side.shape[0]}" for side in (x, y)]
        raise ValueError(f"the picture has {sizes[0]} pixels, and the reference {sizes[1]}")
    for name, side in (("picture", x), ("reference", y)):
        if trouble := not_finite(side):
            raise ValueError(f"the {name} is {trouble}")
    return x, y


def not_finite(pixels):
    """Return in words how many pixels are NaN or infinite, and where the first is; None where there are none."""
    count, first = 0, None
    for rows in bands(*pixels.shape[:2]):
        wrong = ~np.isfinite(pixels[rows]).all(axis=2)
        if wrong.any():
            row, column = np.argwhere(wrong)[0]
            first = first or f"x {column}, y {rows.start + row}"
            count += np.count_nonzero(wrong)
    return f"NaN or infinite in {count} pixel{'' if count == 1 else 's'}, first at {first}" if count else None
