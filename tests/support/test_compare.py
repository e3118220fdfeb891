"""The gates accept what rounding does and refuse deliberately wrong pictures."""

import numpy as np
import pytest

from tests.support import compare
from tests.support.compare import Mismatch

HEIGHT, WIDTH = 40, 60
RNG = np.random.default_rng(3)
PICTURE = RNG.uniform(0.1, 0.9, (HEIGHT, WIDTH, 3))
LABELS = np.where(np.arange(WIDTH) < 30, 0, compare.NO_SHAPE) * np.ones((HEIGHT, 1), int)
NOTHING = np.zeros((HEIGHT, WIDTH), bool)
EVERYTHING = ~NOTHING
STILL = np.zeros((HEIGHT, WIDTH))


def spoilt(rows, columns, amount):
    """Return PICTURE with `amount` added in a block."""
    result = PICTURE.copy()
    result[rows, columns] += amount
    return result


def test_colour_accepts_rounding():
    """Differences in the last digits of float32 pass."""
    compare.check_colour(PICTURE.astype(np.float32), PICTURE, LABELS)


def test_colour_accepts_few_edge_pixels():
    """Two visibly different pixels of 2400 pass where the mean hardly moves."""
    wrong = spoilt(slice(3, 4), slice(5, 6), 0.1)
    wrong[20, 20] -= 0.1
    compare.check_colour(wrong, PICTURE, LABELS)


@pytest.mark.parametrize("wrong", [
    pytest.param(PICTURE + 3e-6, id="median"),
    pytest.param(spoilt(slice(0, 20), slice(None), 2e-3), id="mean"),
    pytest.param(spoilt(slice(None, None, 8), slice(None, None, 30), 0.02), id="share"),
    pytest.param(spoilt(slice(10, 15), slice(10, 15), 0.02), id="patch"),
    pytest.param(spoilt(slice(0, 1), slice(0, 40), 0.011), id="one_row"),
    pytest.param(PICTURE * [1.01, 1.0, 1.0], id="one_percent_of_one_channel"),
    pytest.param(PICTURE[..., ::-1], id="channels_swapped"),
    pytest.param(PICTURE[::-1], id="upside_down"),
    pytest.param(spoilt(slice(10, 20), slice(10, 20), np.nan), id="nan"),
    pytest.param(PICTURE[:-1], id="size"),
])
def test_colour_refuses(wrong):
    """A common error, a bias, many wrong pixels, a solid patch, NaN and another size are refused."""
    with pytest.raises(Mismatch):
        compare.check_colour(wrong, PICTURE)


def test_colour_refuses_a_small_wrong_shape():
    """A shape of a tenth of the picture that is off by 5e-5 is found through its own median."""
    labels = LABELS.copy()
    labels[:8, :30] = 7
    wrong = PICTURE + np.where(labels == 7, 5e-5, 0)[..., None]
    compare.check_colour(wrong, PICTURE)
    with pytest.raises(Mismatch, match="shape 7"):
        compare.check_colour(wrong, PICTURE, labels)


def test_colour_refuses_a_wrong_highlight():
    """A fifth of a shape off by less than a visible step is found through the shape's quantile."""
    wrong = spoilt(slice(0, 10), slice(0, 30), 3e-4)
    with pytest.raises(Mismatch, match="90% quantile over shape 0"):
        compare.check_colour(wrong, PICTURE, LABELS)


@pytest.mark.parametrize(("size", "found"), [((5, 5), True), ((5, 4), False), ((1, 40), False), ((9, 7), True)])
def test_patch_is_a_filled_square(size, found):
    """Only a filled square of five pixels counts, also in the corner of the picture; a line does not."""
    wrong = NOTHING.copy()
    wrong[: size[0], : size[1]] = True
    assert compare.has_patch(wrong) == found


def test_shapes_may_differ_where_uncertain():
    """Different and uncertain pixels are counted."""
    uncertain = NOTHING.copy()
    uncertain[0, :5] = True
    ours = LABELS.copy()
    ours[0, :3] = 4
    assert compare.check_shapes(ours, LABELS, uncertain) == (3, 5)


def test_shapes_refuse_one_unexplained_pixel():
    """A single pixel that no rounding explains is refused."""
    ours = LABELS.copy()
    ours[9, 9] = 4
    with pytest.raises(Mismatch, match="1 pixels differ"):
        compare.check_shapes(ours, LABELS, NOTHING)


def test_shapes_refuse_a_mask_that_is_mostly_uncertain():
    """A comparison in which everything is excused says nothing and fails."""
    with pytest.raises(Mismatch, match="uncertain"):
        compare.check_shapes(LABELS, LABELS, EVERYTHING)


@pytest.mark.parametrize("name", compare.TOLERANCES)
def test_values_accept_rounding_and_refuse_more(name):
    """Each value passes at a hundredth of its tolerance and is refused at ten times that tolerance."""
    small, large = (PICTURE * (1 + f * compare.TOLERANCES[name]) for f in (0.01, 10))
    pick = (lambda v: v[..., 0]) if name == "depth" else (lambda v: v)
    compare.check_values(name, pick(small), pick(PICTURE), EVERYTHING, STILL)
    with pytest.raises(Mismatch):
        compare.check_values(name, pick(large), pick(PICTURE), EVERYTHING, STILL)


def test_values_refuse_nan_and_nothing_to_compare():
    """NaN is never close, and an empty comparison fails."""
    with pytest.raises(Mismatch):
        compare.check_values("normal", spoilt(slice(0, 9), slice(0, 9), np.nan), PICTURE, EVERYTHING, STILL)
    with pytest.raises(Mismatch, match="no pixel"):
        compare.check_values("normal", PICTURE, PICTURE, NOTHING, STILL)


def test_values_allow_for_spread_in_its_pixels_only():
    """Where the value changes within rounding of the ray it may differ by as much, elsewhere not."""
    wrong, spread = spoilt(slice(5, 12), slice(5, 12), 0.01), STILL.copy()
    with pytest.raises(Mismatch):
        compare.check_values("normal", wrong, PICTURE, EVERYTHING, spread)
    spread[5:12, 5:12] = 0.02
    compare.check_values("normal", wrong, PICTURE, EVERYTHING, spread)


def test_periodic_u_is_compared_around_the_circle():
    """u of 0 and 1 are the same on round shapes, and v is not."""
    theirs = np.full((HEIGHT, WIDTH, 2), 0.9999999)
    ours = theirs - [1.0, 0.0]
    compare.check_values("uv", ours, theirs, EVERYTHING, STILL, EVERYTHING)
    with pytest.raises(Mismatch):
        compare.check_values("uv", ours, theirs, EVERYTHING, STILL, NOTHING)
    with pytest.raises(Mismatch):
        compare.check_values("uv", theirs - [0.0, 1.0], theirs, EVERYTHING, STILL, EVERYTHING)
