"""Image textures: all images of a scene lie one after the other in one array of packed RGB texels.

Row 0 of an image is at v = 0; texel (i, j) covers [i/W, (i+1)/W] x [j/H, (j+1)/H]. In phong mode 8-bit values are
c / 255, without decoding, because its pictures are not encoded either. Path tracing decodes colours from sRGB before
they are combined: by a polynomial, which takes a third of the time of looking each channel up in a table.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float, UInt32, Vector2f, Vector3f
from renderer.core.numeric import greater, lesser

OFFSET, WIDTH, HEIGHT = range(3)

# The curve of sRGB above its linear part, for c from 11/255 to 1: with relative errors up to 4e-5, and 1 at c = 1. The
# least greatest relative error over the 245 bytes, by a linear programme over the coefficients of 1, c, c^2 ...
SRGB = (8.477e-4, 3.5566e-2, 0.482219, 0.8761082, -0.8766525, 0.8756267, -0.532582, 0.1388669)
SRGB_BYTES = tuple(coefficient / 255**power for power, coefficient in enumerate(SRGB))
LAST_LINEAR_BYTE, LINEAR_SLOPE = 10, 1 / (12.92 * 255)


def as_written(packed):
    """Return the colour of packed texels, c / 255."""
    return Vector3f(*(Float((packed >> shift) & 0xFF) for shift in (0, 8, 16))) * (1 / 255)


def decoded(packed):
    """Return the linear colour of packed texels that are encoded by sRGB."""
    encoded = Vector3f(*(Float((packed >> shift) & 0xFF) for shift in (0, 8, 16)))
    colour = Vector3f(SRGB_BYTES[-1])
    for coefficient in SRGB_BYTES[-2::-1]:
        colour = dr.fma(colour, encoded, coefficient)
    return dr.select(encoded <= LAST_LINEAR_BYTE, encoded * LINEAR_SLOPE, colour)


def number(packed):
    """Return the number that packed texels stand for: red, c / 255."""
    return Float(packed & 0xFF) * (1 / 255)


@dataclass(frozen=True)
class Image:
    """An 8-bit RGB picture on the host: `rgb` has 3 * width * height bytes, rows from the top."""

    width: int
    height: int
    rgb: bytes

    def texels(self):
        """Return the picture as (width * height,) uint32, 0xBBGGRR."""
        import numpy as np

        channels = np.frombuffer(self.rgb, np.uint8).reshape(-1, 3).astype(np.uint32)
        return channels[:, 0] | channels[:, 1] << 8 | channels[:, 2] << 16


class Atlas:
    """The texels of several images on the device; `offsets` are the places of their first texels."""

    def __init__(self, images):
        import numpy as np

        self.offsets, end = [], 0
        for image in images:
            self.offsets.append(end)
            end += image.width * image.height
        texels = np.concatenate([image.texels() for image in images])
        self._texels = dr.opaque(UInt32, 0, end)
        dr.scatter(self._texels, UInt32(texels), dr.arange(UInt32, end))  # an aligned copy
        dr.eval(self._texels)

    def sampler(self, texture_filter, wrap, form=as_written):
        """Return the lookup `(row, uv, active) -> value` with one filter and wrap; `form` is a function of texels."""
        sample = {"nearest": self._nearest, "bilinear": self._bilinear}[texture_filter]
        index = {"repeat": _repeat, "clamp": _clamp}[wrap]
        return lambda row, uv, active: sample(row, uv, index, form, active)

    def slope(self, wrap):
        """Return the lookup `(row, uv, active) -> Vector2f` of the derivatives by u and v of interpolated numbers."""
        index = {"repeat": _repeat, "clamp": _clamp}[wrap]

        def sample(row, uv, active):
            (a, b), (c, d), weight = self._four(row, uv, index, number, active)
            along_u, along_v = dr.lerp(b - a, d - c, weight.y), dr.lerp(c - a, d - b, weight.x)
            return Vector2f(along_u * Float(row[WIDTH]), along_v * Float(row[HEIGHT]))

        return sample

    def _texel(self, row, i, j, form, active):
        return form(dr.gather(UInt32, self._texels, row[OFFSET] + j * row[WIDTH] + i, active))

    def _nearest(self, row, uv, wrap, form, active):
        position = uv * Vector2f(Float(row[WIDTH]), Float(row[HEIGHT]))
        i = wrap(dr.floor(position.x), row[WIDTH])
        j = wrap(dr.floor(position.y), row[HEIGHT])
        return self._texel(row, i, j, form, active)

    def _bilinear(self, row, uv, wrap, form, active):
        above, below, weight = self._four(row, uv, wrap, form, active)
        return dr.lerp(dr.lerp(*above, weight.x), dr.lerp(*below, weight.x), weight.y)

    def _four(self, row, uv, wrap, form, active):
        """Return the two texels above and the two below a point, and its position between them from 0 to 1."""
        position = uv * Vector2f(Float(row[WIDTH]), Float(row[HEIGHT])) - 0.5
        corner = dr.floor(position)
        weight = position - corner
        columns = [wrap(corner.x + k, row[WIDTH]) for k in range(2)]
        rows = [wrap(corner.y + k, row[HEIGHT]) for k in range(2)]
        above, below = ([self._texel(row, i, j, form, active) for i in columns] for j in rows)
        return above, below, weight


def _repeat(index, size):
    """Return a whole number (Float) modulo size, as UInt32 in [0, size)."""
    period = Float(size)
    inside = index - period * dr.floor(index / period)
    return UInt32(lesser(greater(inside, Float(0)), period - 1))


def _clamp(index, size):
    """Return a whole number (Float) clamped to [0, size - 1], as UInt32."""
    return UInt32(lesser(greater(index, Float(0)), Float(size) - 1))
