"""Random numbers with a fixed seed, so that a failure can be repeated."""

import numpy as np
import pytest


@pytest.fixture
def rng():
    """A generator that every test starts from the same state."""
    return np.random.default_rng(20240229)
