"""From linear radiance to the 8 bits of a picture file, in lanes."""

import drjit as dr

from renderer.core import tones
from renderer.core.backend import UInt8


def to_bytes(channel, scale, tonemap, encoding):
    """Return a channel as UInt8: curve of channel * scale, clipped to [0, 1], encoded; NaN becomes 0."""
    return UInt8(tones.shown(channel * scale, tonemap, encoding, dr.select) * 255 + 0.5)
