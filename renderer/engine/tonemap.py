"""From linear radiance to the 8 bits of a picture file, in lanes."""

import drjit as dr

from renderer.core.backend import Float, UInt8
from renderer.core.numeric import greater, lesser

NEUTRAL_EXPOSURE = 0.1  # the exposure at which linear tone mapping shows radiance 1 as white

BRIGHTEST = 1e6  # white on every curve; keeps squares of what is brighter from overflowing


def linear(x):
    """Return x: radiance 1 is white, and what is brighter is clipped."""
    return x


def reinhard(x):
    """Return x / (1 + x): nothing is clipped [Reinhard2002, eq. 3]."""
    return x / (1 + x)


def filmic(x):
    """Return a film-like curve with toe and shoulder: a rational fit of the ACES reference transform [Narkowicz2016]."""
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)


def srgb(x):
    """Return the encoding of IEC 61966-2-1 for x in [0, 1]."""
    curve = 1.055 * dr.power(greater(x, Float(0.0031308)), 1 / 2.4) - 0.055
    return dr.select(x <= 0.0031308, 12.92 * x, curve)


CURVES = {"linear": linear, "reinhard": reinhard, "filmic": filmic}
ENCODINGS = {"linear": lambda x: x, "srgb": srgb}


def to_bytes(channel, scale, tonemap, encoding):
    """Return a channel as UInt8: curve of channel * scale, clipped to [0, 1], encoded; NaN becomes 0."""
    value = channel * scale
    value = CURVES[tonemap](dr.select(value > BRIGHTEST, BRIGHTEST, value))
    value = lesser(greater(value, Float(0)), Float(1))
    return UInt8(ENCODINGS[encoding](value) * 255 + 0.5)
