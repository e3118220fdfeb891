"""Independent numbers: hashes of seed, pixel, sample number and dimension."""

from renderer.core.backend import UInt32, Vector2f
from renderer.core.hashing import mix
from renderer.samplers.base import STEP, key_of, register, to_unit


@register("independent")
class Independent:
    """See samplers/base.py."""

    def __init__(self, pixel, seed):
        self._key = key_of(pixel, seed)

    def _hash(self, sample, dimension):
        return mix(mix(self._key + sample) + UInt32(dimension) * STEP)

    def u1(self, sample, dimension):
        """Return one number in [0, 1)."""
        return to_unit(self._hash(sample, dimension))

    def u2(self, sample, dimension):
        """Return two numbers in [0, 1)."""
        x = self._hash(sample, dimension)
        return Vector2f(to_unit(x), to_unit(mix(x + STEP)))
