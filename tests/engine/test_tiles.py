"""Which pixels lanes render in turn."""

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import UInt32
from renderer.engine import tiles
from renderer.engine.tiles import NO_PIXEL, PACKET, Tiles


def pixels_of(width, first, count):
    """Return (turns, lanes) of pixel numbers."""
    of = Tiles(width, first, count)
    return np.array([of.pixel(UInt32(turn) + dr.zeros(UInt32, of.lanes)).numpy() for turn in range(of.turns[0])])


@pytest.mark.parametrize("packets", [0, 1, 1000])
@pytest.mark.parametrize("width, first, count", [(20, 0, 200), (17, 33, 150), (1, 0, 5), (300, 250, 7), (64, 64, 2560)])
def test_every_pixel_has_one_turn(width, first, count, packets, monkeypatch):
    """Whatever the size of tiles, for rows that begin and end anywhere."""
    monkeypatch.setattr(tiles, "PACKETS_A_THREAD", packets)
    found = pixels_of(width, first, count)
    assert np.array_equal(np.sort(found[found != NO_PIXEL]), np.arange(first, first + count))


def test_packets_are_blocks_within_a_tile(monkeypatch):
    """16 neighbours at a time, and over all turns a square; smaller ones where threads need more packets."""
    for packets, edge in ((0, 32), (10**9, 4)):
        monkeypatch.setattr(tiles, "PACKETS_A_THREAD", packets)
        found = pixels_of(64, 0, 64 * 64).reshape(-1, 64 * 64 // edge**2, PACKET)
        rows, columns = found // 64, found % 64
        for place in (rows, columns):
            assert (np.ptp(place, axis=2) == 3).all() and (np.ptp(place, axis=(0, 2)) == edge - 1).all()
