"""The R2 sequence: constants, range, evenness and independence of neighbours."""

import numpy as np

from renderer.core.backend import UInt32
from renderer.samplers.r2 import R2, STEP_X, STEP_Y

PLASTIC = np.roots([1, 0, -1, -1]).real.max()


def points(pixel, count, seed=0):
    """Return (count, 2) samples of one pixel."""
    numbers = UInt32(np.arange(count, dtype=np.uint32))
    return R2(UInt32(pixel), UInt32(seed)).u2(numbers).numpy().T


def test_steps_are_powers_of_the_plastic_number():
    """2^32 / g and 2^32 / g^2 with g^3 = g + 1."""
    assert abs(STEP_X - 2**32 / PLASTIC) < 1 and abs(STEP_Y - 2**32 / PLASTIC**2) < 1


def test_values_stay_below_one():
    """u = 1 would fall into the next pixel."""
    u = points(7, 100_000)
    assert u.min() >= 0 and u.max() < 1


def test_prefixes_are_evenly_spread():
    """Integrals converge faster than with random points: error below a third of theirs."""
    errors = []
    for pixel in range(50):
        u = points(pixel, 256)
        errors.append(np.mean((u[:, 0] ** 2 + u[:, 1] < 0.8)) - np.mean(np.add.outer(GRID**2, GRID) < 0.8))
    random_error = np.sqrt(0.25 / 256)
    assert np.sqrt(np.mean(np.square(errors))) < random_error / 3


GRID = (np.arange(1000) + 0.5) / 1000


def test_pixels_and_seeds_are_shifted_independently():
    """First samples of neighbours are uncorrelated and cover the square."""
    pixels = UInt32(np.arange(40_000, dtype=np.uint32))
    for seed in (0, 1):
        u = R2(pixels, UInt32(seed)).u2(UInt32(0)).numpy()
        assert abs(np.corrcoef(u[0, :-1], u[0, 1:])[0, 1]) < 0.02 and abs(np.corrcoef(u)[0, 1]) < 0.02
        assert np.abs(np.histogram2d(*u, bins=10, range=[[0, 1]] * 2)[0] - 400).max() < 5 * np.sqrt(400)
