"""Choosing among many things with given weights, in lanes; weights are numpy arrays on the host.

Alias tables [Walker1977] need one look-up a choice: 2^bits places of equal probability are each shared by two things.
Inverse tables keep the order of things, so that random numbers that are spread evenly choose things that are, for two
to four times the look-ups: a search among the sums of weights, begun between bounds from a table [Chen1974].
"""

import dataclasses

import drjit as dr
import numpy as np

from renderer.core.backend import ArrayXu, Float, UInt32, from_host

WORDS = 2  # of a place: share of its first thing (Float), its second thing; the first is the place's own number
RANDOM_BITS = 24  # of numbers in [0, 1)


@dataclasses.dataclass(frozen=True)
class AliasTables:
    """Tables one after the other; in lanes, `first` and `bits` of a table tell its place and size."""

    _words: UInt32

    @classmethod
    def of(cls, tables):
        """Return the tables, their first places and their bits, of arrays (R, N) that each hold R rows of weights.

        No weight is negative, and no row all zero. The result's lists have one entry for each array.
        """
        words, firsts, bits, end = [], [], [], 0
        for rows in tables:
            rows = np.asarray(rows, np.float64)
            bits.append((rows.shape[1] - 1).bit_length())
            assert bits[-1] <= RANDOM_BITS, "more places than one random number tells apart"
            share, other = alias(rows, 2 ** bits[-1])
            words.append(np.stack([share.astype(np.float32).view(np.uint32), other.astype(np.uint32)], axis=-1).ravel())
            firsts.append(end)
            end += share.size
        return cls(from_host(UInt32, np.concatenate(words))), firsts, bits

    def choose(self, u, v, first, bits):
        """Return the thing that u and v in [0, 1) choose, and what is left of v, again even in [0, 1).

        `first` is the first place of a table (int, or UInt32 in lanes), `bits` its size (likewise). A place is taken
        from the first bits of u, so that all are equally likely; the others follow those of v, so that shares far below
        2^-24 are neither lost nor made as large as that.
        """
        number = UInt32(u * 2.0**RANDOM_BITS)
        place = number >> (RANDOM_BITS - bits)
        v = dr.fma(Float((number << bits) & (2**RANDOM_BITS - 1)), 4.0**-RANDOM_BITS, v)
        index = first + place
        words = dr.gather(ArrayXu, self._words, index, shape=(WORDS, dr.width(index)))
        share = dr.reinterpret_array(Float, words[0])
        own = v < share
        left = dr.select(own, v, v - share) / dr.select(own, share, 1 - share)
        return dr.select(own, place, words[1]), dr.select(left < 1, left, 0)


@dataclasses.dataclass(frozen=True)
class InverseTables:
    """Tables of the same size one after the other, by row; see the module docstring."""

    _sums: Float  # (R, N + 1): of the weights before each thing, the last one 1
    _bounds: UInt32  # (R, 2^bits + 1): the thing that k / 2^bits chooses; products with powers of 2 are exact
    _stride: UInt32  # N + 1, opaque
    _bits: int  # 2^bits >= N

    @classmethod
    def of(cls, weights):
        """Return the tables of (R, N) weights, none negative; rows that are all zero count for even ones."""
        rows, count = weights.shape
        bits = (count - 1).bit_length()
        sums, bounds = np.empty((rows, count + 1), np.float32), np.empty((rows, 2**bits + 1), np.uint32)
        marks = np.arange(2**bits + 1, dtype=np.float32) / np.float32(2**bits)
        exact = np.zeros(count + 1)  # of one row at a time, because images are large
        for row, own, found in zip(weights, sums, bounds):
            np.cumsum(row, dtype=np.float64, out=exact[1:])
            own[:] = exact / exact[-1] if exact[-1] > 0 else np.linspace(0, 1, count + 1)
            found[:] = np.searchsorted(own[:-1], marks, side="right") - 1
        stride = dr.opaque(UInt32, count + 1)
        return cls(from_host(Float, sums.ravel()), from_host(UInt32, bounds.ravel()), stride, bits)

    def choose(self, u, row):
        """Return the thing of a row's table (UInt32 in lanes) that u in [0, 1) chooses, and what is left of u."""
        base, mark = row * self._stride, UInt32(u * 2.0**self._bits)
        place = (row << self._bits) + row + mark
        low, high = (dr.gather(UInt32, self._bounds, place + k) for k in range(2))

        def halve(low, high):
            middle = (low + high + 1) >> 1
            beyond = dr.gather(Float, self._sums, base + middle) > u
            return dr.select(beyond, low, middle), dr.select(beyond, middle - 1, high)

        low, _ = dr.while_loop((low, high), lambda low, high: low < high, halve, label="inverse table")
        start = dr.gather(Float, self._sums, base + low)
        width = dr.gather(Float, self._sums, base + low + 1) - start
        left = (u - start) / dr.select(width > 0, width, 1)
        return low, dr.select(left < 1, left, 0)


def alias(weights, places):
    """Return for each place of (R, places) the share of its own number, and the other number, of (R, N) weights.

    Light things (below the mean) and heavy ones are each taken in their order: a heavy one fills the places of light
    ones up until less than its own place is left of it, and the next heavy one fills that [Hubschle2022].
    With prefix sums of what light ones lack and heavy ones have too much, each finds its other by a binary search. In
    every row both sums are equal, so that one pass serves all rows; indices are held to their row against rounding.
    """
    rows = len(weights)
    weight = np.zeros((rows, places))
    weight[:, : weights.shape[1]] = weights * (places / weights.sum(axis=1, keepdims=True))
    light = weight < 1
    light[np.arange(rows), weight.argmax(axis=1)] = False
    light_end, heavy_end = light.sum(axis=1).cumsum(), (~light).sum(axis=1).cumsum()
    weight, light = weight.ravel(), light.ravel()
    lights, heavies = np.flatnonzero(light), np.flatnonzero(~light)
    before = np.concatenate([[0.0], np.cumsum(1 - weight[lights])])  # lacked by the lights before each
    excess = np.cumsum(weight[heavies] - 1)

    share, other = weight.copy(), np.arange(rows * places)
    filler = np.searchsorted(excess, before[:-1], side="right")
    heavy_start = np.concatenate([[0], heavy_end[:-1]])
    filler = np.clip(filler, heavy_start[lights // places], heavy_end[lights // places] - 1)
    other[lights] = heavies[filler]
    filled = np.searchsorted(before[:-1], excess, side="left")  # lights that a heavy one and those before it fill
    filled = np.minimum(filled, light_end[heavies // places])
    share[heavies] = 1 + excess - before[filled]
    other[heavies[:-1]] = heavies[1:]
    share[heavies[heavy_end - 1]] = 1.0  # of each row the last
    other[heavies[heavy_end - 1]] = heavies[heavy_end - 1]
    return np.clip(share, 0, 1).reshape(rows, places), other.reshape(rows, places) % places
