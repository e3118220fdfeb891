"""What a sampler provides: numbers in [0, 1) that depend on seed, pixel, sample number and dimension alone.

- `Kind(pixel, seed)`: pixel numbers in lanes, an opaque seed; what does not depend on the sample is computed here.
- `u2(sample, dimension) -> Vector2f`: a pair; `dimension` counts pairs (an int, or UInt32 in lanes).
- `u1(sample, dimension) -> Float`: one number; the same dimension must not be asked for both.

Who uses which dimension: 0 position in the pixel, 1 position on the lens, from 2 on the integrator.
"""

from __future__ import annotations

from dataclasses import dataclass

from renderer.core.backend import Float, UInt32
from renderer.core.hashing import mix
from renderer.core.registry import Registry

PIXEL, LENS, PATH = 0, 1, 2  # dimensions

STEP = 0x9E3779B9  # odd, 2^32 over the golden ratio: keys of neighbouring dimensions differ in many bits
TO_UNIT = 2.0**-24

KINDS = Registry()
register = KINDS.under  # the sampler's name in the scene file


def key_of(pixel, seed):
    """Return the key of pixel numbers (UInt32)."""
    return mix(pixel + mix(UInt32(seed)))


def to_unit(bits):
    """Return the number in [0, 1) that the upper 24 of 32 random bits make."""
    return Float(bits >> 8) * TO_UNIT


@dataclass
class Draws:
    """The numbers of each lane's sample."""

    sampler: object
    sample: UInt32

    def u2(self, dimension):
        """Return a pair of numbers in [0, 1)."""
        return self.sampler.u2(self.sample, dimension)

    def u1(self, dimension):
        """Return a number in [0, 1)."""
        return self.sampler.u1(self.sample, dimension)
