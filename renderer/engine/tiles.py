"""Which pixels a lane renders, one after the other.

A packet's 16 lanes begin as a block of 4 x 4 pixels, and move over a square tile of such blocks. Neighbours cost about
the same, and what they differ evens out over several pixels, so that the lanes of a packet end at about the same time.
"""

from __future__ import annotations

import drjit as dr

from renderer.core.backend import NAME, Float64, UInt32

BLOCK = 4  # pixels along its edge
PACKET = BLOCK * BLOCK  # lanes
SIDES = (8, 4, 2, 1)  # blocks along a tile's edge, the best first
PACKETS_A_THREAD = 16  # at least, so that threads end at about the same time
NO_PIXEL = 0xFFFFFFFF


class Tiles:
    """Tiles over the pixels from `first` on, `count` in scan order, of a picture that is `width` pixels wide.

    Numbers are inputs of the kernel, so that all parts and sizes of pictures run the same one.
    """

    def __init__(self, width, first, count):
        rows = range(first // width, -(-(first + count) // width))
        sides = SIDES if NAME == "llvm" else (1,)
        for side in sides:
            across, down = (-(-length // (BLOCK * side)) for length in (width, len(rows)))
            if across * down >= PACKETS_A_THREAD * dr.thread_count():
                break
        self.lanes = PACKET * across * down
        self.turns, self._mask, self._bits, self._width, self._first, self._count, columns, row = (
            dr.opaque(UInt32, value)
            for value in (side * side, side - 1, side.bit_length() - 1, width, first, count, across, rows.start)
        )
        lane = dr.arange(UInt32, self.lanes)
        tile, edge = lane >> 4, dr.opaque(UInt32, BLOCK * side)
        line = UInt32((Float64(tile) + 0.5) / Float64(columns))  # as in pixel_corner
        self._column = (tile - line * columns) * edge + (lane & (BLOCK - 1))
        self._row = row + line * edge + ((lane >> 2) & (BLOCK - 1))

    def pixel(self, turn):
        """Return the number of the pixel of each lane's turn, NO_PIXEL where there is none."""
        column = self._column + ((turn & self._mask) << 2)
        pixel = (self._row + ((turn >> self._bits) << 2)) * self._width + column
        return dr.select((column < self._width) & (self.place(pixel) < self._count), pixel, NO_PIXEL)

    def place(self, pixel):
        """Return the place of a pixel among those from the first on."""
        return pixel - self._first  # wraps around for pixels before it
