"""Image textures: all images of a scene lie one after the other in one array of packed RGB texels.

Row 0 of an image is at v = 0; texel (i, j) covers [i/W, (i+1)/W] x [j/H, (j+1)/H]. 8-bit values are c / 255, without
decoding, because phong pictures are not encoded either.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float, UInt32, Vector2f, Vector3f
from renderer.core.numeric import greater, lesser

OFFSET, WIDTH, HEIGHT = range(3)


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

    def sampler(self, texture_filter, wrap):
        """Return the lookup `(row, uv, active) -> colour` with one filter and wrap."""
        sample = {"nearest": self._nearest, "bilinear": self._bilinear}[texture_filter]
        index = {"repeat": _repeat, "clamp": _clamp}[wrap]
        return lambda row, uv, active: sample(row, uv, index, active)

    def _texel(self, row, i, j, active):
        packed = dr.gather(UInt32, self._texels, row[OFFSET] + j * row[WIDTH] + i, active)
        return Vector3f(*(Float((packed >> shift) & 0xFF) for shift in (0, 8, 16))) * (1 / 255)

    def _nearest(self, row, uv, wrap, active):
        position = uv * Vector2f(Float(row[WIDTH]), Float(row[HEIGHT]))
        i = wrap(dr.floor(position.x), row[WIDTH])
        j = wrap(dr.floor(position.y), row[HEIGHT])
        return self._texel(row, i, j, active)

    def _bilinear(self, row, uv, wrap, active):
        position = uv * Vector2f(Float(row[WIDTH]), Float(row[HEIGHT])) - 0.5
        corner = dr.floor(position)
        weight = position - corner
        columns = [wrap(corner.x + k, row[WIDTH]) for k in range(2)]
        rows = [wrap(corner.y + k, row[HEIGHT]) for k in range(2)]
        above, below = (
            dr.lerp(self._texel(row, columns[0], j, active), self._texel(row, columns[1], j, active), weight.x)
            for j in rows
        )
        return dr.lerp(above, below, weight.y)


def _repeat(index, size):
    """Return a whole number (Float) modulo size, as UInt32 in [0, size)."""
    period = Float(size)
    inside = index - period * dr.floor(index / period)
    return UInt32(lesser(greater(inside, Float(0)), period - 1))


def _clamp(index, size):
    """Return a whole number (Float) clamped to [0, size - 1], as UInt32."""
    return UInt32(lesser(greater(index, Float(0)), Float(size) - 1))
