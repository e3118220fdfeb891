"""What a sampler provides: numbers in [0, 1) that depend on seed, pixel, sample number and dimension alone.

- `Kind(pixel, seed)`: pixel numbers in lanes, an opaque seed; what does not depend on the sample is computed here.
- `u2(sample, dimension) -> Vector2f`: a pair; `dimension` counts pairs (an int, or UInt32 in lanes).
- `u1(sample, dimension) -> Float`: one number; the same dimension must not be asked for both.

Who uses which dimension: 0 position in the pixel, 1 position on the lens, from 2 on the integrator.
"""

from __future__ import annotations

from dataclasses import dataclass

from renderer.core.backend import UInt32
from renderer.core.registry import Registry

PIXEL, LENS, PATH = 0, 1, 2  # dimensions

KINDS = Registry()


def register(name):
    """Return a class decorator that registers a sampler under its name in the scene file."""

    def enter(sampler):
        KINDS.add(name, sampler)
        return sampler

    return enter


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
