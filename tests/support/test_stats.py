"""The gates for noisy pictures accept equals, and refuse what is a little wrong: one percent, a square, a pixel."""

import numpy as np
import pytest

from tests.support.compare import Mismatch
from tests.support.stats import BOUND, compare, demand_equal

SIZE, BATCHES = (32, 48, 3), 16
RUNS = 300


def batches(rng, noise=0.05, count=BATCHES, factor=1.0, heavy=False):
    """Return noisy pictures of a slope with the expectation times `factor`; `heavy`: rare bright samples."""
    height, width, channels = SIZE
    picture = np.broadcast_to(np.linspace(0.2, 1.0, width)[None, :, None], SIZE) * np.linspace(0.5, 1, channels)
    shape = (count, *SIZE)
    if heavy:
        return factor * picture * rng.gamma(1 / 9, 9, shape)  # variance 9: as a caustic of 64 samples
    return factor * picture * (1 + noise * rng.standard_normal(shape))


@pytest.mark.parametrize("heavy", [False, True])
def test_false_alarms_are_as_rare_as_they_claim(heavy):
    """Of equal sides no more are refused at 1 % than 1 % and its own noise, also where samples are rarely bright."""
    rng = np.random.default_rng(1)
    p = np.array([compare(batches(rng, heavy=heavy), batches(rng, heavy=heavy)).p for _ in range(RUNS)])
    assert (p < 0.01).mean() <= 0.01 + 3 * np.sqrt(0.01 / RUNS)
    assert (p < 1e-4).sum() == 0


def test_statistics_are_uniform():
    """The p-values of the scale are spread evenly over 0 to 1: neither blind nor shy."""
    rng = np.random.default_rng(2)
    p = np.sort([compare(batches(rng), batches(rng)).scale for _ in range(RUNS)])
    assert np.abs(p - (np.arange(RUNS) + 0.5) / RUNS).max() < 1.9 / np.sqrt(RUNS)  # Kolmogorov and Smirnov at 0.1 %


@pytest.mark.parametrize(("factor", "refused"), [(1.01, 1.0), (0.99, 1.0), (1.003, 0.9), (1.0, 0.0)])
def test_common_factor_is_found(factor, refused):
    """One percent is always found, three thousandths nearly always, at 5 % noise a pixel and batch."""
    rng = np.random.default_rng(3)
    found = np.mean([compare(batches(rng), batches(rng, factor=factor)).refused for _ in range(40)])
    assert found >= refused if refused else found == 0


def test_wrong_square_is_found():
    """Five percent in one square of the picture, and nothing elsewhere."""
    rng = np.random.default_rng(4)
    factor = np.ones(SIZE)
    factor[8:16, 16:24] = 1.05
    assert all(compare(batches(rng), batches(rng, factor=factor)).block < 1e-6 for _ in range(20))


def test_wrong_pixel_is_found():
    """One pixel of another brightness, as at an edge or under a lost highlight."""
    rng = np.random.default_rng(5)
    factor = np.ones(SIZE)
    factor[9, 9] = 1.5
    assert all(compare(batches(rng), batches(rng, factor=factor)).pixel < 1e-6 for _ in range(20))


def test_many_small_errors_are_found():
    """Squares that are by turns too bright and too dark: no common factor, and no square stands out for itself."""
    rng = np.random.default_rng(6)
    board = 1 + 0.006 * (2 * ((np.indices((4, 6)).sum(0)) % 2) - 1)
    factor = np.kron(board, np.ones((8, 8)))[..., None]
    verdicts = [compare(batches(rng), batches(rng, factor=factor)) for _ in range(20)]
    assert all(v.chi2 < 1e-6 for v in verdicts) and np.median([v.scale for v in verdicts]) > 1e-3


def test_pictures_without_noise():
    """Rounding is no difference where nothing is noisy; a thousandth is."""
    flat = np.full((BATCHES, *SIZE), 0.5)
    assert compare(flat, flat * (1 + 3e-5)).p > 0.01
    assert compare(flat, flat * 1.002).refused
    assert compare(flat * 0, flat * 0).p == 1
    assert compare(flat * 0, flat).refused


def test_too_few_samples_do_not_pass():
    """Where noise hides an error of half a percent, the gate asks for more samples, and takes them."""
    rng = np.random.default_rng(7)
    with pytest.raises(Mismatch, match="too few samples"):
        demand_equal(batches(rng, noise=2.0), batches(rng, noise=2.0))
    assert demand_equal(batches(rng), batches(rng)).bound < BOUND
    with pytest.raises(Mismatch, match="differ"):
        demand_equal(batches(rng), batches(rng, factor=1.02))


def test_samples_too_rare_for_single_pixels():
    """Where few pixels have a bright sample at all, pixels give false alarms, and squares of them do not."""
    rng = np.random.default_rng(9)
    rare = [batches(rng, noise=1e-3) + 0.05 * rng.poisson(0.04, (BATCHES, *SIZE)) for _ in range(2)]
    even = batches(rng, noise=1e-3) + 0.05 * 0.04
    assert compare(rare[0], even).p < 1e-4 < compare(rare[0], even).coarse_p
    assert compare(rare[0] * 1.02, even).coarse_p < 1e-4


def test_unusable_pictures_are_no_pictures():
    """Too few batches, and values that are not finite, are mistakes of the test."""
    rng = np.random.default_rng(8)
    few = batches(rng, count=8)
    with pytest.raises(AssertionError):
        compare(few, few)
    bad = batches(rng)
    bad[0, 0, 0, 0] = np.nan
    with pytest.raises(AssertionError):
        compare(bad, batches(rng))
