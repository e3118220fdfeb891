"""Tone mapping of any brightness.

Radiance from 1e-6 to the greatest float32 number and infinity becomes 8 bits by one curve and one encoding. Curves that
divide two squares turn what is bright into infinity over infinity. A byte is wrong where it is not what double
precision rounds to, unless that lies within 2e-4 of the middle between two bytes.
"""

import drjit as dr
import numpy as np

from renderer.core.backend import Float
from renderer.engine.tonemap import to_bytes
from tests.stability.case import Case, mitsuba

CURVES = {
    "linear": lambda x: x,
    "reinhard": lambda x: x / (1 + x),
    "filmic": lambda x: x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14),
}
NEAR = 2e-4  # of a byte


def radiances():
    """Return radiances (N,) float32."""
    exponents = np.random.default_rng(1).uniform(-6, 38, 200_000)
    ends = [0, 2.0**-149, 1, 1e6, 1e19, 3e38, float.fromhex("0x1.fffffep127"), np.inf]
    return np.concatenate([10.0**exponents, 10.0 ** (exponents / 12), ends]).astype(np.float32)


def encoded(x, srgb):
    """Return x in [0, 1] by the sRGB curve or as it is, in the precision of x."""
    curve = 1.055 * np.maximum(x, 0.0031308) ** x.dtype.type(1 / 2.4) - 0.055
    return np.where(x <= 0.0031308, 12.92 * x, curve) if srgb else x


def mapped(curve, x):
    """Return the textbook's value of a curve, clipped, in the precision of x."""
    with np.errstate(all="ignore"):
        return np.clip(CURVES[curve](x), 0, 1)


def exact(curve, srgb):
    """Return the bytes before rounding, in double precision; above 1e9 all curves are as at infinity."""
    return encoded(mapped(curve, np.minimum(radiances().astype(float), 1e9)), srgb) * 255


def wrong(found, curve, srgb):
    """Return which bytes are wrong, NaN among them."""
    return ~(abs(found - exact(curve, srgb)) <= 0.5 + NEAR)


def ours(curve, srgb):
    """Return the renderer's bytes."""
    found = to_bytes(Float(radiances()), dr.opaque(Float, 1), curve, "srgb" if srgb else "linear")
    return found.numpy().astype(float)


def naive(curve, srgb):
    """Return the textbook's bytes; NaN where the formula is."""
    return np.floor(encoded(mapped(curve, radiances()), srgb) * np.float32(255) + np.float32(0.5)).astype(float)


def mitsubas(curve, srgb):
    """Return the bytes of Mitsuba's pictures, which know one curve."""
    mi = mitsuba()
    pixels = radiances()[None, :, None].repeat(3, axis=2)
    made = mi.Bitmap(pixels).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=srgb)
    return np.array(made)[0, :, 0].astype(float)


def of_all(tone, curves=tuple(CURVES)):
    """Return a callable: which bytes of a function are wrong, of all curves and both encodings."""

    def measure():
        asked = [(curve, srgb) for curve in curves for srgb in (False, True)]
        return np.concatenate([wrong(tone(*how), *how) for how in asked])

    return measure


CASES = (
    Case("bytes of radiances up to infinity", "share", 0, "none is wrong", of_all(ours), of_all(naive),
         "the curves as they are written", of_all(mitsubas, ("linear",)),
         "knows the linear curve only, dithers, and shows what is far beyond 2e3 as black where it encodes"),
)  # fmt: skip
