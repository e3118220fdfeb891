"""The R2 sequence: two-dimensional points i * (1/g, 1/g^2) modulo 1, with g^3 = g + 1, shifted for every pixel.

One multiplication an axis; prefixes of any length are evenly spread, so samples can be added later. Source of the
constants: [Roberts2018]. Each pixel adds its own shift [Cranley1976], from a hash, so that neighbours differ.
A sample depends only on seed, pixel and sample number.
"""

from renderer.core.backend import Float, UInt32, Vector2f
from renderer.core.hashing import mix

STEP_X, STEP_Y = 3242174889, 2447445414  # 2^32 / g and 2^32 / g^2, g = 1.32471795724474602596
TO_UNIT = 2.0**-24


class R2:
    """Two numbers a sample for each pixel."""

    def __init__(self, pixel, seed):
        self._shift_x = mix(pixel + mix(UInt32(seed)))
        self._shift_y = mix(self._shift_x + 0x9E3779B9)

    def u2(self, sample, dimension=0):
        """Return two numbers in [0, 1) for a sample number."""
        x, y = self._shift_x + sample * STEP_X, self._shift_y + sample * STEP_Y
        return Vector2f(Float(x >> 8), Float(y >> 8)) * TO_UNIT
