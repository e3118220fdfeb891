"""The yardstick of crevices is the closed form."""

import numpy as np
import pytest

from tests.stability import crevices


@pytest.mark.parametrize("half", crevices.HALF_ANGLES)
def test_the_mean_over_a_wall_is_the_sine_of_half_the_angle(half):
    """Opening over walls, as crossed strings have it; to the evenness of the points."""
    assert crevices.sky(half, 1.0).mean() == pytest.approx(np.sin(half), rel=1e-3)
