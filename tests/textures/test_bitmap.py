"""Image lookups against a numpy twin, texel by texel."""

import numpy as np
import pytest

from renderer.core.backend import Bool, UInt32, Vector2f
from renderer.core.rows import Rows
from renderer.textures.bitmap import Atlas, Image
from renderer.textures.checkerboard import Checkerboards

rng = np.random.default_rng(5)
PICTURES = [rng.integers(0, 256, (height, width, 3), np.uint8) for height, width in ((3, 5), (1, 1), (8, 2))]


def wrapped(index, size, wrap):
    """Return whole numbers brought into range(size)."""
    return np.mod(index, size) if wrap == "repeat" else np.clip(index, 0, size - 1)


def expected(picture, uv, texture_filter, wrap):
    """Return colours in double precision."""
    height, width, _ = picture.shape
    x, y = uv[:, 0] * width, uv[:, 1] * height
    texel = lambda i, j: picture[wrapped(j, height, wrap), wrapped(i, width, wrap)] / 255.0  # noqa: E731
    if texture_filter == "nearest":
        return texel(np.floor(x).astype(int), np.floor(y).astype(int))
    x, y = x - 0.5, y - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = (x - i)[:, None], (y - j)[:, None]
    return ((texel(i, j) * (1 - a) + texel(i + 1, j) * a) * (1 - b)
            + (texel(i, j + 1) * (1 - a) + texel(i + 1, j + 1) * a) * b)  # fmt: skip


@pytest.mark.parametrize("number", range(len(PICTURES)))
@pytest.mark.parametrize("wrap", ["repeat", "clamp"])
@pytest.mark.parametrize("texture_filter", ["nearest", "bilinear"])
def test_lookup_agrees_with_its_definition(texture_filter, wrap, number):
    """Row 0 is at v = 0; several images share one array; coordinates far outside wrap or clamp."""
    atlas = Atlas([Image(p.shape[1], p.shape[0], p.tobytes()) for p in PICTURES])
    picture = PICTURES[number]
    row = Rows([[atlas.offsets[number], picture.shape[1], picture.shape[0]]], UInt32)[0]
    uv = rng.uniform(-2, 3, (5000, 2)).astype(np.float32)
    got = atlas.sampler(texture_filter, wrap)(row, Vector2f(uv[:, 0], uv[:, 1]), Bool(True)).numpy().T
    want = expected(picture, uv.astype(float), texture_filter, wrap)
    # float32 may round a coordinate across a texel's edge: 5 or 8 texels, 5 units, 24 bits
    off = np.abs(got - want).max(1) > 2e-5
    assert off.sum() <= (5 if texture_filter == "nearest" else 0)


def test_checkerboard_starts_with_its_first_colour():
    """Unit squares alternate, also across zero."""
    boards = Checkerboards([_Board((1.0, 0.5, 0.25), (0.0, 0.1, 0.2))])
    row = Rows([[0, 0, 0]], UInt32)[0]
    u = np.array([0.5, 1.5, -0.5, -0.5, 0.5], np.float32)
    v = np.array([0.5, 0.5, 0.5, -0.5, 7.5], np.float32)
    got = boards.sample(row, Vector2f(u, v), Bool(True)).numpy()[0]
    assert np.allclose(got, [1, 0, 0, 1, 0])


class _Board:
    def __init__(self, color1, color2):
        self.color1, self.color2 = color1, color2
