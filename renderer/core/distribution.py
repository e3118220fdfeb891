"""Choosing among many things with given weights, in lanes: alias tables [Walker1977], one look-up a choice.

A table has 2^k places with equal probability; each is shared by two things. Weights are numpy arrays on the host.
"""

import dataclasses

import drjit as dr
import numpy as np

from renderer.core.backend import ArrayXu, Float, UInt32, from_host

WORDS = 2  # of a place: share of its first thing (Float), its second thing; the first is the place's own number
RANDOM_BITS = 24  # of numbers in [0, 1)


@dataclasses.dataclass(frozen=True)
class AliasTable:
    """One table, or several of the same size one after the other."""

    _words: UInt32
    _bits: int

    @classmethod
    def of(cls, weights):
        """Return the table of (N,) weights, or the tables of (R, N); none negative, no row all zero."""
        rows = np.atleast_2d(np.asarray(weights, np.float64))
        bits = max(rows.shape[1] - 1, 0).bit_length()
        words = np.empty((len(rows), 2**bits, WORDS), np.uint32)
        for row, own in zip(rows, words):
            share, other = alias(row, 2**bits)
            own[:, 0], own[:, 1] = share.astype(np.float32).view(np.uint32), other
        return cls(from_host(UInt32, words.ravel()), bits)

    def choose(self, u, v, row=None):
        """Return the thing that u and v in [0, 1) choose, and what is left of v, again even in [0, 1).

        `row` tells which table (UInt32 in lanes), None for the only one.
        """
        # whole numbers, so that all places are equally likely; more places than u tells apart take bits of v
        place = UInt32(u * 2.0**RANDOM_BITS)
        more = self._bits - RANDOM_BITS
        if more > 0:
            v = v * 2.0**more
            low = dr.floor(v)
            place, v = (place << more) + UInt32(low), v - low
        else:
            place = place >> -more
        index = place if row is None else (row << self._bits) + place
        words = dr.gather(ArrayXu, self._words, index, shape=(WORDS, dr.width(index)))
        share = dr.reinterpret_array(Float, words[0])
        first = v < share
        v = dr.select(first, v, v - share) / dr.select(first, share, 1 - share)
        return dr.select(first, place, words[1]), dr.select(v < 1, v, 0)


def alias(weights, places):
    """Return for each place the share of its own number, and the other number, as (places,) arrays.

    Light things (below the mean) and heavy ones are each taken in their order: a heavy one fills the places of light
    ones up until less than its own place is left of it, and the next heavy one fills that [Hubschle2022, sec. 4.3].
    With prefix sums of what light ones lack and heavy ones have too much, each finds its other by a binary search.
    """
    weight = np.zeros(places)
    weight[: len(weights)] = weights
    weight *= places / weight.sum()
    light = weight < 1
    light[np.argmax(weight)] = False
    lights, heavies = np.flatnonzero(light), np.flatnonzero(~light)
    lack, excess = np.cumsum(1 - weight[lights]), np.cumsum(weight[heavies] - 1)
    before = np.concatenate([[0.0], lack])

    share, other = weight.copy(), np.arange(places)
    filler = np.minimum(np.searchsorted(excess, before[:-1], side="right"), len(heavies) - 1)
    other[lights] = heavies[filler]
    spent = np.searchsorted(before, excess, side="right")  # lights that were filled when a heavy one fell below 1
    left = 1 + excess - before[np.minimum(spent, len(lack))]
    share[heavies] = np.where(spent > len(lack), 1.0, left)
    share[heavies[-1]] = 1.0
    other[heavies[:-1]] = heavies[1:]
    return np.clip(share, 0, 1), other
