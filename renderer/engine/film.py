"""What a picture's samples add up to, one lane a pixel.

Sums are compensated [Kahan1965]: what rounding adds too much is kept and taken from the next sample, so that the error
is that of a few roundings, however many samples there are. Samples are added one by one in their order, so that sums do
not depend on how passes split them. A sample that is NaN or infinite is left out and counted. The compiler may fuse
multiplications and additions, but not reorder them: FastMath keeps the compensation, and the tests hold that.

The variance of samples comes from compensated sums of luminance and its square, subtracted in double precision; the
squares' own roundings hide deviations below about 2^-12 of the luminance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr

from renderer.core.backend import Float, Float64, UInt32, Vector3f
from renderer.core.colour import luminance

LARGEST = 3.4e38  # float32's, rounded down; comparisons with it are false for NaN
LEAST_WEIGHT = 0.5  # mean of signs below which a few samples of a signed filter are not divided by it


def is_finite(colour):
    """Return whether no component is NaN or infinite, nor their sum."""
    return abs(dr.sum(colour)) <= LARGEST


@dataclass
class Film:
    """Sums over the samples of each pixel; those that nobody needs are None and are not computed."""

    total: Vector3f  # radiance
    rest: Vector3f | None  # what rounding added to `total` too much; None for a single sample
    lost: UInt32  # samples left out
    signs: Float | None = None  # of samples under a filter that is somewhere negative
    squares: Float | None = None  # of luminance
    squares_rest: Float | None = None

    @staticmethod
    def empty(pixels, single=False, signed=False, variance=False):
        """Return a film without samples; a `single` one takes one sample a pixel."""
        rest = None if single else dr.zeros(Vector3f, pixels)
        film = Film(dr.zeros(Vector3f, pixels), rest, dr.zeros(UInt32, pixels))
        if signed:
            film.signs = dr.zeros(Float, pixels)
        if variance:
            film.squares, film.squares_rest = dr.zeros(Float, pixels), dr.zeros(Float, pixels)
        return film

    def opaque(self):
        """Return the film as evaluated arrays of its own for every sum.

        `dr.make_opaque` would give equal zeros one array, and a kernel with fewer inputs than that of the next pass.
        """
        return Film(**{name: _opaque(getattr(self, name)) for name in self.__dataclass_fields__})

    def at(self, place, where):
        """Return a film of one lane for each place among this one's; 0 where not `where`."""
        return Film(**{name: kept if kept is None else dr.gather(type(kept), kept, place, where)
                       for name, kept in vars(self).items()})  # fmt: skip

    def put(self, film, place, where):
        """Write the lanes of another film to places of this one, which is evaluated."""
        for name, kept in vars(self).items():
            if kept is not None:
                dr.scatter(kept, getattr(film, name), place, where)

    def add(self, colour, where, negative=None):
        """Return the film with one sample more in the lanes `where`, subtracted where `negative`."""
        finite = is_finite(colour)
        kept = where & finite
        lost = self.lost + dr.select(where & ~finite, UInt32(1), 0)
        colour = dr.select(kept, colour, 0)
        film = replace(self, lost=lost)
        if self.signs is not None:
            colour = dr.select(negative, -colour, colour)
            film.signs = self.signs + dr.select(kept, dr.select(negative, Float(-1), 1), 0)
        if self.squares is not None:
            film.squares, film.squares_rest = _plus(self.squares, self.squares_rest, dr.square(luminance(colour)))
        if self.rest is None:
            film.total = self.total + colour
        else:
            film.total, film.rest = _plus(self.total, self.rest, colour)
        return film

    def count(self, samples):
        """Return how many of its samples, so many in all or an array of numbers, each pixel has kept."""
        return (dr.opaque(UInt32, samples) if isinstance(samples, int) else samples) - self.lost

    def mean(self, samples):
        """Return the mean radiance of the samples kept of so many; 0 where all are lost.

        A signed filter is normalised by its samples' own weight, so that what is even stays even.
        """
        if self.rest is None and self.signs is None:
            return self.total
        count = Float(self.count(samples))
        if self.signs is not None:
            least = LEAST_WEIGHT * count
            count = dr.select(abs(self.signs) < least, least, self.signs)
        return self.total / dr.select(count == 0, 1, count)

    def variance(self, samples):
        """Return the variance of each pixel's mean luminance, were its samples independent; 0 for less than 2."""
        count = Float64(self.count(samples))
        summed = luminance([Float64(total) - Float64(rest) for total, rest in zip(self.total, self.rest)])
        squares = Float64(self.squares) - Float64(self.squares_rest)
        spread = squares - dr.square(summed) / dr.select(count > 0, count, 1)
        divisor = count * (count - 1)
        return dr.select((divisor > 0) & (spread > 0), spread / dr.select(divisor > 0, divisor, 1), 0)


def relative_error(films, samples):
    """Return the root mean square of all pixels' standard errors over their mean luminance, as a number."""
    variance = brightness = pixels = 0
    for film in films:
        variance += dr.sum(film.variance(samples)).item()
        brightness += dr.sum(Float64(luminance(film.mean(samples)))).item()
        pixels += len(film.lost)
    return (variance * pixels) ** 0.5 / brightness if brightness > 0 else 0.0


def joined(films):
    """Return films as one, evaluated, their lanes one after the other; they are emptied, so as not to be kept twice."""
    whole = {}
    for name in Film.__dataclass_fields__:
        whole[name] = _joined([getattr(film, name) for film in films])
        dr.eval(whole[name])
        for film in films:
            setattr(film, name, None)
    return Film(**whole)


def _joined(sums):
    if sums[0] is None:
        return None
    if dr.depth_v(sums[0]) > 1:
        return type(sums[0])(*(dr.concat(list(channels)) for channels in zip(*sums)))
    return dr.concat(sums)


def _opaque(zeros):
    if zeros is None:
        return None
    if dr.depth_v(zeros) > 1:
        return type(zeros)(*map(_opaque, zeros))
    return dr.opaque(type(zeros), 0, len(zeros))


def _plus(total, rest, value):
    """Return the sum and what rounding added to it too much."""
    value = value - rest
    summed = total + value
    return summed, (summed - total) - value
