"""From radiance to what a screen shows, the same for numbers in arrays and in lanes.

`select(condition, a, b)` is that of the library whose numbers come: numpy's `where` or Dr.Jit's `select`.
"""

from renderer.core import srgb

NEUTRAL_EXPOSURE = 0.1  # the exposure at which linear tone mapping shows radiance 1 as white
BRIGHTEST = 1e6  # white on every curve; keeps squares of what is brighter from overflowing


def linear(x):
    """Return x: radiance 1 is white, and what is brighter is clipped."""
    return x


def reinhard(x):
    """Return x / (1 + x): nothing is clipped [Reinhard2002, eq. 3]."""
    return x / (1 + x)


def filmic(x):
    """Return a film-like curve with toe and shoulder: a fit of the ACES reference transform [Narkowicz2016]."""
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)


CURVES = {"linear": linear, "reinhard": reinhard, "filmic": filmic}
ENCODINGS = {"linear": lambda x, select: x, "srgb": srgb.encoded}


def shown(x, tonemap, encoding, select):
    """Return the curve of x, clipped to [0, 1] and encoded; NaN becomes 0."""
    x = CURVES[tonemap](select(x > BRIGHTEST, BRIGHTEST, x))
    x = select(x > 0, x, 0)
    x = select(x < 1, x, 1)
    return ENCODINGS[encoding](x, select)
