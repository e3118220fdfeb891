"""What samplers promise: numbers in [0, 1), evenly distributed, without relation between pixels and dimensions."""

import math

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import UInt32
from renderer.samplers import KINDS, sobol
from renderer.samplers.base import Draws

PIXELS = 40_000
BINS = 16
SEEDS = (0, 1, 2**32 - 1)
# 99.99 % of chi-square with BINS^2 - 1 degrees of freedom
CHI2_MOST = 347.0
MOST_CORRELATION = 4.5 / np.sqrt(PIXELS)  # 4.5 standard deviations

every_kind = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)


def points(kind, pixel, sample, dimension, seed=0):
    """Return (count, 2) numbers; each of the arguments may be an array."""
    pixel, sample, dimension = (UInt32(np.asarray(x, dtype=np.uint32).ravel()) for x in (pixel, sample, dimension))
    return kind(pixel, dr.opaque(UInt32, seed)).u2(sample, dimension).numpy().T


def net_errors(points):
    """Return how many elementary intervals of area 1 / count hold another number than one of the points."""
    count = len(points)
    bits, wrong = count.bit_length() - 1, 0
    for columns in (2**k for k in range(bits + 1)):
        rows = count // columns
        cell = np.floor(points[:, 0] * columns) * rows + np.floor(points[:, 1] * rows)
        wrong += count - len(np.unique(cell))
    return wrong


@every_kind
@pytest.mark.parametrize("seed", SEEDS)
def test_numbers_are_equally_distributed(kind, seed):
    """Over pixels, and over dimensions of one pixel, for first and later samples; chi-square of pairs."""
    many = np.arange(PIXELS)
    for pixel, sample, dimension in ((many, 0, 0), (many, 5, 9), (many, 2**24 - 1, 3), (7, 0, many), (7, 63, many)):
        u = points(kind, pixel, sample, dimension, seed)
        assert u.min() >= 0 and u.max() < 1
        found = np.histogram2d(*u.T, bins=BINS, range=[[0, 1]] * 2)[0]
        assert np.sum((found - PIXELS / BINS**2) ** 2) / (PIXELS / BINS**2) < CHI2_MOST


@every_kind
@pytest.mark.parametrize("sample", [0, 1, 2, 37])
def test_pixels_dimensions_and_seeds_are_unrelated(kind, sample):
    """Numbers of neighbours, of any two of the first dimensions, and of two seeds do not correlate."""
    pixels = np.arange(PIXELS)
    first = np.concatenate([points(kind, pixels, sample, dimension).T for dimension in range(8)])
    rows = [*first, *points(kind, pixels + 1, sample, 0).T, *points(kind, pixels + 1200, sample, 1).T,
            *points(kind, pixels, sample, 0, seed=1).T]  # fmt: skip
    # also their distances from the middle, and their lower bits
    for shape in (lambda u: u, lambda u: abs(u - 0.5), lambda u: 64 * u % 1):
        related = np.corrcoef([shape(row) for row in rows]) - np.eye(len(rows))
        assert np.abs(related).max() < MOST_CORRELATION


@every_kind
def test_number_depends_on_its_names_alone(kind):
    """Not on the other lanes, nor on what was asked before; a lane's dimension counts like a literal one."""
    rng = np.random.default_rng(1)
    pixel, sample, dimension = (rng.integers(0, high, 500) for high in (2**28, 2**24, 300))
    together = points(kind, pixel, sample, dimension, 3)
    for k in (0, 77, 499):
        assert np.array_equal(points(kind, pixel[k], sample[k], dimension[k], 3)[0], together[k])
        lane = kind(UInt32(int(pixel[k])), dr.opaque(UInt32, 3)).u2(UInt32(int(sample[k])), int(dimension[k]))
        assert np.array_equal(lane.numpy()[:, 0], together[k])


@every_kind
def test_single_numbers_are_as_evenly_spread(kind):
    """u1 is uniform over pixels, and Draws hands on the sample at hand."""
    sampler = kind(dr.arange(UInt32, PIXELS), dr.opaque(UInt32, 4))
    u = Draws(sampler, UInt32(6)).u1(5).numpy()
    assert np.array_equal(u, sampler.u1(UInt32(6), 5).numpy()) and u.min() >= 0 and u.max() < 1
    assert np.abs(np.histogram(u, bins=100, range=(0, 1))[0] - PIXELS / 100).max() < 5 * np.sqrt(PIXELS / 100)
    assert np.array_equal(Draws(sampler, UInt32(6)).u2(5).numpy(), sampler.u2(UInt32(6), 5).numpy())


@pytest.mark.parametrize("dimension", [0, 1, 2, 3, 77])
@pytest.mark.parametrize("bits", [1, 2, 5, 8, 12])
def test_sobol_prefixes_are_nets(bits, dimension):
    """2^k samples: one in every elementary interval of area 2^-k, as are the next 2^k, in every pixel."""
    count = 2**bits
    for pixel in (0, 1, 1199):
        for start in (0, count, 6 * count):
            u = points(KINDS["sobol"], np.full(count, pixel), start + np.arange(count), dimension)
            assert net_errors(u) == 0
            assert len(np.unique(u[:, 0])) > count / 2


def test_net_errors_tells_nets_from_others():
    """The measure of the test above is 0 for the Hammersley points, and not for a regular or a random grid."""
    i = np.arange(64)
    radical = sum(((i >> k) & 1) / 2.0 ** (k + 1) for k in range(6))
    assert net_errors(np.stack([i / 64, radical], 1)) == 0
    assert net_errors(np.stack([i % 8 / 8, i // 8 / 8], 1)) > 0
    assert net_errors(np.random.default_rng(0).random((64, 2))) > 64


def errors(kind, integrand, samples, pixels=4000):
    """Return the root mean square error over pixels of the mean of an integrand of the numbers of six dimensions."""
    pixel = np.repeat(np.arange(pixels), samples)
    sample = np.tile(np.arange(samples), pixels)
    u = [points(kind, pixel, sample, np.full(pixel.shape, dimension)) for dimension in range(6)]
    return np.sqrt(np.mean((integrand(u).reshape(pixels, samples).mean(1) - integrand.mean) ** 2))


def edge(u):
    """Return whether points of one pair are on one side of a line."""
    return (0.7 * u[0][:, 0] + 0.5 * u[0][:, 1] < 0.45).astype(float)


def diagonal(u):
    """Return whether points of one pair are on one side of the diagonal, along which unscrambled nets have points."""
    return (u[2][:, 0] < u[2][:, 1]).astype(float)


def across(u):
    """Return a product over two pairs: nothing is gained by even spreading within each, and little may be lost."""
    return 12 * (u[1][:, 0] - 0.5) * (u[4][:, 0] - 0.5)


edge.mean, diagonal.mean, across.mean = 0.45**2 / 2 / 0.7 / 0.5, 0.5, 0.0


@pytest.mark.parametrize("integrand, samples, least, most", [
    (edge, 16, 0.0, 0.5), (edge, 256, 0.0, 0.25), (diagonal, 16, 0.0, 0.6), (diagonal, 256, 0.0, 0.3),
    (across, 16, 0.9, 1.4), (across, 64, 0.9, 1.4),
])
def test_sobol_errors_against_independent_ones(integrand, samples, least, most):
    """Edges converge faster, and pairs of dimensions are decorrelated: copies of one pair would give 4 or 8 times."""
    ratio = errors(KINDS["sobol"], integrand, samples) / errors(KINDS["independent"], integrand, samples)
    assert least <= ratio < most


def test_sobol_without_its_shuffle_would_be_noticed(monkeypatch):
    """The last test bites: with the same permutation in all dimensions, their products do not converge."""
    def copied(self, sample, dimension):
        _, key, other, third = shuffled(self, sample, dimension)
        return dr.brev(sample), key, other, third

    shuffled = sobol.Sobol._first
    monkeypatch.setattr(sobol.Sobol, "_first", copied)
    assert errors(sobol.Sobol, across, 64) > 2 * errors(KINDS["independent"], across, 64)


def test_second_coordinate_has_the_pascal_matrix():
    """Entry (i, j) is binomial(j, i) modulo 2, for all 32 bits."""
    columns = sobol._pascal(UInt32([1 << (31 - j) for j in range(32)])).numpy()
    expected = [sum(math.comb(j, i) % 2 << (31 - i) for i in range(32)) for j in range(32)]
    assert list(columns) == expected
