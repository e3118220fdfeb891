"""An image of what is infinitely far away, by longitude and latitude, +y up.

A direction d is seen at u = atan2(-d_x, -d_z) / 2 pi (minus the rotation), v = acos(d_y) / pi: u grows to the right in
pictures of this renderer's camera, so that the image is not mirrored. Columns are periodic, with
texel i at u = (i + 1/2) / W; the first row of texels lies at v = 0 and the last at v = 1. Between texels colours are
interpolated, and so is what directions are chosen by: luminance times sin(theta). It is bilinear between texels as the
colours are, so that density and colour differ only by how the sine bends within a row [Pharr2023, sec. 12.5].
"""

from __future__ import annotations

import math

import drjit as dr

from renderer.core.backend import ArrayXf, Bool, Float, UInt32, Vector3f, from_host
from renderer.core.colour import LUMINANCE
from renderer.core.elementary import atan2, polar
from renderer.core.numeric import FAR, TINY, greater, lesser, safe_sqrt
from renderer.lights.base import DirectSample

WORDS = 4  # of a texel: colour, and density per steradian times sin(theta)
POLE = 0.25  # rows: at the poles the sine of this latitude, where otherwise their colours would never be chosen


class Environment:
    """The image on the device, and directions chosen by its brightness."""

    def __init__(self, pixels, intensity, rotation_deg, sampled=True):
        """Hold (H, W, 3) float32 `pixels`, rows from the top, times `intensity`, turned around +y.

        `sampled` tells whether `sample` will be called.
        """
        import numpy as np

        from renderer.core.distribution import InverseTables

        pixels = pixels * np.asarray(intensity, np.float32)
        if len(pixels) == 1:
            pixels = np.repeat(pixels, 2, axis=0)
        height, width = pixels.shape[:2]
        theta = math.pi / (height - 1) * np.clip(np.arange(height), POLE, height - 1 - POLE)
        weight = (pixels @ np.asarray(LUMINANCE, np.float32)) * np.sin(theta).astype(np.float32)[:, None]
        weight = np.concatenate([weight, weight[:, :1]], axis=1)  # the first column again, to the right of the last
        patches = 0.25 * (weight[:-1, :-1] + weight[1:, :-1] + weight[:-1, 1:] + weight[1:, 1:])
        total = float(patches.sum(dtype=np.float64))
        self.mean = total * math.pi / (2 * (height - 1) * width)  # luminance over all directions
        self.shines = total > 0
        texels = np.empty((height, width + 1, WORDS), np.float32)
        texels[..., :3] = np.concatenate([pixels, pixels[:, :1]], axis=1)
        texels[..., 3] = weight * (width * (height - 1) / (total * math.tau * math.pi) if self.shines else 0)
        self._texels = from_host(Float, texels.ravel())
        if self.shines and sampled:
            self._rows = InverseTables.of(patches.sum(axis=1, dtype=np.float64)[None])
            self._columns = InverseTables.of(patches)
        self._size = [dr.opaque(UInt32, value) for value in (width, height)]
        self._turns = dr.opaque(Float, rotation_deg / 360)

    def radiance(self, d):
        """Return the colour seen in a direction, and the density of `sample` for it."""
        width, height = map(Float, self._size)
        sin = dr.sqrt(dr.fma(d.x, d.x, d.z * d.z))
        x = (atan2(-d.x, -d.z) * (1 / math.tau) - self._turns) * width - 0.5
        x -= width * dr.floor(x / width)
        y = polar(d.y, sin) * (1 / math.pi) * (height - 1)
        column = lesser(dr.floor(x), width - 1)
        row = lesser(dr.floor(y), height - 2)
        corners = self._corners(UInt32(column), UInt32(row))
        colour = _bilinear(corners, x - column, y - row)
        return Vector3f(*colour[:3]), colour[3] / greater(sin, Float(TINY))

    def sample(self, u2):
        """Return a direction as a DirectSample: a patch between four texels, first its row, and a place in it."""
        width, height = self._size
        row, vy = self._rows.choose(u2.y, UInt32(0))
        column, vx = self._columns.choose(u2.x, row)
        corners = self._corners(column, row)
        a, b, c, d = (corner[3] for corner in corners)
        fy = _linear(vy, a + b, c + d)
        fx = _linear(vx, dr.lerp(a, c, fy), dr.lerp(b, d, fy))
        colour = _bilinear(corners, fx, fy)
        sin_phi, cos_phi = dr.sincos(((Float(column) + fx + 0.5) / Float(width) + self._turns) * math.tau)
        sin, cos = dr.sincos((Float(row) + fy) * math.pi / (Float(height) - 1))
        sin = greater(sin, Float(TINY))
        wo = Vector3f(-sin * sin_phi, cos, -sin * cos_phi)
        pdf_sa = greater(colour[3] / sin, Float(TINY))  # 0 on the rim of a patch, where it is black
        return DirectSample(wo, Float(FAR), Vector3f(*colour[:3]), pdf_sa, Bool(False))

    def _corners(self, column, row):
        """Return the texels around the patches to the right of and below texels."""
        stride = self._size[0] + 1
        place = row * stride + column
        return [
            dr.gather(ArrayXf, self._texels, place + offset, shape=(WORDS, dr.width(place)))
            for offset in (0, 1, stride, stride + 1)
        ]


def _bilinear(corners, x, y):
    """Return the four words between four texels."""
    a, b, c, d = corners
    return [dr.lerp(dr.lerp(a[k], b[k], x), dr.lerp(c[k], d[k], x), y) for k in range(WORDS)]


def _linear(u, a, b):
    """Return x in [0, 1] with a density that goes from a at 0 linearly to b at 1 [Pharr2023, sec. A.4.1]."""
    root = safe_sqrt(dr.lerp(dr.square(a), dr.square(b), u))
    return lesser(u * (a + b) / greater(a + root, Float(TINY)), Float(1))
