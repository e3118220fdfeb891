"""A picture of where two pictures differ: the picture, the reference, and their difference beside them.

The difference of a pixel is that of its worst channel as it is seen, times a gain, in colours that grow lighter from
black (equal) over violet, red and orange to a light yellow. An EXR gets the linear difference itself, with its sign.
"""

from __future__ import annotations

import numpy as np

from renderer import compare
from renderer.pair import WHITE

GAINS = (1, 2, 5, 10, 20, 50, 100)
CLIPPED = 0.01  # share of pixels that may lie beyond the lightest colour, where the gain is chosen here
GAP = 4  # pixels between the pictures
GREY = 128
HEAT = ((0, 0, 0), (80, 25, 140), (205, 45, 90), (250, 150, 35), (255, 255, 190))  # at even distances


def fitting_gain(counts):
    """Return the largest of GAINS that clips few pixels; `counts` are pixels by their difference in levels."""
    total = counts.sum()
    fitting = [gain for gain in GAINS if counts[np.arange(counts.size) * gain > WHITE].sum() <= CLIPPED * total]
    return max(fitting, default=GAINS[0])


def coloured(difference):
    """Return (..., 3) uint8 colours of differences in [0, 1]; what is greater has the lightest."""
    steps = np.linspace(0, 1, len(HEAT))
    table = [np.interp(np.arange(WHITE + 1) / WHITE, steps, channel) for channel in zip(*HEAT)]
    table = (np.stack(table, axis=1) + 0.5).astype(np.uint8)
    return table[(np.minimum(difference, 1) * WHITE + 0.5).astype(np.uint8)]


class DifferencePicture:
    """What `renderer.io.outputs` writes: 8 bits or channels of an EXR."""

    def __init__(self, pair, gain):
        self._pair, self._gain = pair, gain
        self.width, self.height = 3 * pair.width + 2 * GAP, pair.height

    def rgb8(self, tonemap, exposure, encoding):
        """Return the three pictures beside one another as bytes; what a render is graded by is given to none."""
        width, page = self._pair.width, np.full((self.height, self.width, 3), GREY, np.uint8)
        places = range(0, self.width, width + GAP)
        picture, reference, difference = (page[:, place : place + width] for place in places)
        x, y = self._pair.seen()
        levels = self._pair.levels()
        for rows in compare.bands(self.height, width):
            picture[rows], reference[rows] = (side[rows] for side in levels)
            difference[rows] = coloured(np.abs(x[rows] - y[rows]).max(axis=2) * self._gain)
        return memoryview(page).cast("B")

    def channels(self, beside):
        """Return R, G and B of picture less reference, linear."""
        x, y = self._pair.linear()
        result = np.empty((3, self.height, self._pair.width), np.float32)
        for rows in compare.bands(self.height, self._pair.width):
            result[:, rows] = np.moveaxis(np.asarray(x[rows], np.float64) - y[rows], 2, 0)
        return dict(zip("RGB", result))
