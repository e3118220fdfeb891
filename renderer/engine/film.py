"""What a picture's samples add up to, one lane a pixel.

Sums are compensated [Kahan1965]: what rounding cuts off is kept and added to the next sample, so that the error is that
of a few roundings, however many samples there are. Samples are added one by one in their order, so that sums do not
depend on how passes split them. A sample that is NaN or infinite is left out and counted. The compiler may fuse
multiplications and additions, but not reorder them (the tests hold that): FastMath keeps the compensation.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float, UInt32, Vector3f

LARGEST = 3.4e38  # float32's, rounded down; comparisons with it are false for NaN


def is_finite(colour):
    """Return whether no component is NaN or infinite, nor their sum."""
    return abs(dr.sum(colour)) <= LARGEST


@dataclass
class Film:
    """Sums of radiance and of squared luminance, and the number of samples left out; None where nobody asked."""

    total: Vector3f
    rest: Vector3f | None  # what rounding added to `total` too much; None for a single sample
    lost: UInt32

    @staticmethod
    def empty(pixels, single=False):
        """Return a film without samples; a `single` one takes one sample a pixel."""
        zero = dr.zeros(Vector3f, pixels)
        return Film(zero, None if single else dr.zeros(Vector3f, pixels), dr.zeros(UInt32, pixels))

    def add(self, colour, where):
        """Return the film with one sample more in the lanes `where`."""
        finite = is_finite(colour)
        colour = dr.select(where & finite, colour, 0)
        lost = self.lost + dr.select(where & ~finite, UInt32(1), 0)
        if self.rest is None:
            return Film(self.total + colour, None, lost)
        colour = colour - self.rest
        total = self.total + colour
        return Film(total, (total - self.total) - colour, lost)

    def mean(self, samples):
        """Return the mean radiance of the samples that are not lost, of `samples` in all; 0 where all are."""
        if self.rest is None:
            return self.total
        count = Float(dr.opaque(UInt32, samples) - self.lost)
        return self.total / dr.select(count > 0, count, 1)
