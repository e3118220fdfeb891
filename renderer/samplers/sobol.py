"""Owen-scrambled Sobol points, two dimensions at a time [Burley2020]."""

import drjit as dr

from renderer.core.backend import Float, UInt32, Vector2f
from renderer.core.hashing import mix
from renderer.samplers.base import register

TO_UNIT = 2.0**-24
STEP = 0x9E3779B9  # odd, 2^32 over the golden ratio: keys of neighbouring dimensions differ in many bits
PASCAL = ((1, 0xAAAAAAAA), (2, 0xCCCCCCCC), (4, 0xF0F0F0F0), (8, 0xFF00FF00), (16, 0xFFFF0000))  # shifts and masks


def _nested(x, key):
    """Return a permutation of UInt32 in which each bit depends on the lower ones alone [Laine2011]."""
    x = x ^ (x * 0x3D20ADEA)
    x = (x + key) * ((key >> 16) | 1)
    x = x ^ (x * 0x05526C56)
    return x ^ (x * 0x53A22864)


def _owen(x, key):
    """Return a permutation in which each bit depends on the higher ones alone."""
    return dr.brev(_nested(dr.brev(x), key))


def _pascal(x):
    """Return the product of the Pascal matrix modulo 2 and the bits of x, from the highest [Ahmed2024]."""
    for shift, mask in PASCAL:
        x = x ^ ((x << shift) & mask)
    return x


@register("sobol")
class Sobol:
    """See samplers/base.py."""

    def __init__(self, pixel, seed):
        self._key = mix(pixel + mix(UInt32(seed)))

    def _shuffled(self, sample, dimension):
        key = mix(self._key + UInt32(dimension) * STEP)
        return _nested(dr.brev(sample), key), key

    def u1(self, sample, dimension):
        """Return one number in [0, 1)."""
        x, key = self._shuffled(sample, dimension)
        return Float(_owen(x, key * STEP) >> 8) * TO_UNIT

    def u2(self, sample, dimension):
        """Return two numbers in [0, 1)."""
        x, key = self._shuffled(sample, dimension)
        y = _owen(_pascal(x), mix(key))
        return Vector2f(Float(_owen(x, key * STEP) >> 8), Float(y >> 8)) * TO_UNIT
