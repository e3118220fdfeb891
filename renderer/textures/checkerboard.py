"""Checkerboard texture: two colours in unit squares of the scaled texture coordinates."""

import drjit as dr

from renderer.core.backend import Int32
from renderer.core.rows import Rows

BOARD = 0  # column of the texture record


class Checkerboards:
    """The colours of several boards on the device."""

    def __init__(self, boards):
        self._colours = Rows([[*board.color1, *board.color2] for board in boards])

    def sample(self, row, uv, active):
        """Return color1 where floor(u) + floor(v) is even, else color2."""
        board = self._colours.row(row[BOARD], active)
        even = (Int32(dr.floor(uv.x)) + Int32(dr.floor(uv.y))) & 1 == 0
        return dr.select(even, board.vector(0), board.vector(3))
