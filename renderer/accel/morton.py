"""The order of boxes along a Morton (Z-order) curve, in which neighbours in the list are close in space.

All axes share one scale: cells are cubes, so that a flat scene is not stretched.
"""

import drjit as dr

from renderer.core.backend import Float, UInt32
from renderer.core.numeric import lesser

WORD_BITS = 10  # bits of one axis in one word of a code; two words together divide the scene into 2^20 cells an axis
CELLS = 2 ** (2 * WORD_BITS)


def _spread(x):
    """Return the lowest ten bits, with two zeros after each."""
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        x = (x | (x << shift)) & mask
    return x


def _interleave(cell, shift):
    """Return one word of the code: ten bits of each axis from bit `shift` on."""
    x, y, z = (_spread((axis >> shift) & (2**WORD_BITS - 1)) for axis in cell)
    return (x << 2) | (y << 1) | z


def morton_order(lo, hi, lowest, scale):
    """Return the indices of boxes (UInt32) along the curve through their centres; equal ones stay in their order.

    `lowest` and `scale` are the scene's lowest corner and 1 over its largest extent.
    """
    # halves first: the sum of two corners may overflow
    centre = ((lo - lowest) * 0.5 + (hi - lowest) * 0.5) * (scale * CELLS)
    cell = [UInt32(lesser(axis, Float(CELLS - 1))) for axis in centre]
    high, low = _interleave(cell, WORD_BITS), _interleave(cell, 0)
    dr.eval(high, low)
    order = dr.argsort(low)  # stable, so that sorting by the low words first and the high ones next sorts by both
    return dr.gather(UInt32, order, dr.argsort(dr.gather(UInt32, high, order)))
