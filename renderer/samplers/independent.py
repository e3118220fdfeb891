"""Independent numbers: hashes of seed, pixel, sample number and dimension."""

from renderer.core.backend import Float, UInt32, Vector2f
from renderer.core.hashing import mix
from renderer.samplers.base import register

TO_UNIT = 2.0**-24
STEP = 0x9E3779B9  # odd, 2^32 over the golden ratio: keys of neighbouring dimensions differ in many bits


@register("independent")
class Independent:
    """See samplers/base.py."""

    def __init__(self, pixel, seed):
        self._key = mix(pixel + mix(UInt32(seed)))

    def _hash(self, sample, dimension):
        return mix(mix(self._key + sample) + UInt32(dimension) * STEP)

    def u1(self, sample, dimension):
        """Return one number in [0, 1)."""
        return Float(self._hash(sample, dimension) >> 8) * TO_UNIT

    def u2(self, sample, dimension):
        """Return two numbers in [0, 1)."""
        x = self._hash(sample, dimension)
        return Vector2f(Float(x >> 8), Float(mix(x + STEP) >> 8)) * TO_UNIT
