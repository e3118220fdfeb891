"""Pictures of light: what is in the file arrives as linear floats, and what is no light is refused."""

import warnings

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from renderer.core.errors import SceneError
from renderer.io import image

HEADER = b"#?RADIANCE\n# made by a test\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"


def exr(path, channels, header=None):
    """Write an EXR of named (H, W) arrays."""
    OpenEXR.File(dict(header or {}), dict(channels)).write(str(path))
    return path


def hdr(path, size, body):
    """Write a Radiance picture of (width, height) with the given bytes of pixels."""
    path.write_bytes(HEADER % (size[1], size[0]) + body)
    return path


def mantissas(width, height):
    """Return (height, width, 4) uint8 with runs and without, some black."""
    rng = np.random.default_rng(3)
    pixels = rng.integers(100, 160, (height, width, 4), np.uint8)
    pixels[0, width // 3 :] = pixels[0, 0]
    pixels[-1, 1, 3] = 0
    return pixels


def radiances(pixels):
    """Return the values of RGBE pixels in double precision."""
    exponents = pixels[..., 3:].astype(float)
    return np.where(exponents > 0, pixels[..., :3] * 2.0 ** (exponents - 136), 0)


def packed(pixels):
    """Return rows of RGBE pixels, run-length encoded channel by channel."""
    out = bytearray()
    for row in pixels:
        out += bytes([2, 2, len(row) >> 8, len(row) & 255])
        for channel in row.T:
            place = 0
            while place < len(channel):
                end = place + 1
                while end < len(channel) and channel[end] == channel[place] and end - place < 127:
                    end += 1
                if end - place > 1:
                    out += bytes([128 + end - place, channel[place]])
                else:
                    out += bytes([1, channel[place]])
                place = end
    return bytes(out)


@pytest.mark.parametrize("kind", [np.float32, np.float16])
def test_exr_arrives_unchanged(tmp_path, kind):
    """Floats and halves, with channels beside the colours."""
    rng = np.random.default_rng(1)
    planes = {name: rng.exponential(5, (5, 9)).astype(kind) for name in ("R", "G", "B", "A", "Z")}
    found = image.read_environment(exr(tmp_path / "sky.exr", planes))
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, np.stack([planes[name] for name in "RGB"], 2).astype(np.float32))


def test_own_exr_is_an_environment(tmp_path):
    """What the renderer writes can light a scene."""
    planes = {name: np.full((2, 4), value, np.float32) for name, value in zip("RGB", (0.5, 1, 2))}
    image.write_exr(tmp_path / "own.exr", planes, {})
    assert image.read_environment(tmp_path / "own.exr")[1, 3].tolist() == [0.5, 1, 2]


def test_grey_exr_is_grey_light(tmp_path):
    """One channel Y stands for three."""
    grey = np.arange(6, dtype=np.float32).reshape(2, 3)
    found = image.read_environment(exr(tmp_path / "grey.exr", {"Y": grey}))
    np.testing.assert_array_equal(found, np.repeat(grey[..., None], 3, 2))


@pytest.mark.parametrize("size", [(9, 4), (300, 3), (5, 2), (1, 1)])
def test_plain_hdr_is_read(tmp_path, size):
    """Four bytes a pixel."""
    pixels = mantissas(*size) if size[0] > 1 else np.array([[[255, 1, 0, 140]]], np.uint8)
    found = image.read_environment(hdr(tmp_path / "sky.hdr", size, pixels.tobytes()))
    np.testing.assert_array_equal(found, radiances(pixels).astype(np.float32))
    assert found.dtype == np.float32


@pytest.mark.parametrize("size", [(9, 4), (300, 3)])
def test_packed_hdr_is_read(tmp_path, size):
    """Runs and single bytes, channel by channel."""
    pixels = mantissas(*size)
    found = image.read_environment(hdr(tmp_path / "sky.hdr", size, packed(pixels)))
    np.testing.assert_array_equal(found, radiances(pixels).astype(np.float32))


def test_hdr_of_old_runs_is_read(tmp_path):
    """(1, 1, 1, n) repeats the last pixel n times, a second one 256 n times."""
    body = bytes([10, 20, 30, 130, 1, 1, 1, 4, 1, 1, 1, 1]) + bytes([9, 8, 7, 131])
    found = image.read_environment(hdr(tmp_path / "old.hdr", (262, 1), body))
    expected = np.array([[[10, 20, 30, 130]] * 261 + [[9, 8, 7, 131]]], np.uint8)
    np.testing.assert_array_equal(found, radiances(expected).astype(np.float32))


def test_mitsuba_reads_the_same_hdr(tmp_path):
    """Another reader agrees about scale, order and runs."""
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("llvm_ad_rgb")
    path = hdr(tmp_path / "sky.hdr", (40, 3), packed(mantissas(40, 3)))
    expected = np.array(mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))
    np.testing.assert_allclose(image.read_environment(path), expected, rtol=1e-6)


def test_eight_bits_are_decoded(tmp_path):
    """By the curve of sRGB: the middle of the codes is about a fifth of white."""
    Image.fromarray(np.array([[[0, 255, 128]], [[10, 11, 188]]], np.uint8)).save(tmp_path / "sky.png")
    found = image.read_environment(tmp_path / "sky.png")
    expected = [[[0, 1, 0.2158605]], [[0.0030353, 0.0033465, 0.5028865]]]
    np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize("value", [np.nan, np.inf, -0.25, 1e30])
def test_what_is_no_radiance_is_refused(tmp_path, value):
    """With its place."""
    plane = np.ones((3, 4), np.float32)
    plane[1, 2] = value
    path = exr(tmp_path / "sky.exr", {"R": plane, "G": np.ones_like(plane), "B": np.ones_like(plane)})
    with pytest.raises(SceneError, match=r"1 pixels are no radiance .* at x = 2, y = 1"):
        image.read_environment(path)


def test_an_image_without_light_is_allowed(tmp_path):
    """Black is a radiance."""
    black = {name: np.zeros((2, 2), np.float32) for name in "RGB"}
    assert not image.read_environment(exr(tmp_path / "night.exr", black)).any()


@pytest.mark.parametrize(("name", "content", "message"), [
    ("gone.exr", None, "no such file"),
    ("text.exr", b"once upon a time", "not a PPM, PNG, JPEG, EXR or HDR picture"),
    ("empty.hdr", b"", "not a PPM, PNG, JPEG, EXR or HDR picture"),
    ("cut.exr", b"\x76\x2f\x31\x01\x02\x00", "damaged"),
    ("cut.hdr", HEADER % (2, 9) + bytes(30), "ends too early"),
    ("cut2.hdr", HEADER % (1, 9) + bytes([2, 2, 0, 9, 137]), "ends too early"),
    ("run.hdr", HEADER % (1, 9) + bytes([2, 2, 0, 9, 138, 1, 0, 0]), "damaged"),
    ("zero.hdr", HEADER % (1, 9) + bytes([2, 2, 0, 9, 0, 0, 0, 0, 0, 0]), "damaged"),
    ("old.hdr", HEADER % (1, 4) + bytes([1, 1, 1, 4]), "damaged"),
    ("size.hdr", b"#?RADIANCE\n\n+X 3 -Y 2\n", "-Y height"),
    ("none.hdr", b"#?RADIANCE\n\n-Y 0 +X 2\n", "no pixels"),
    ("xyz.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n0000", "FORMAT"),
    ("huge.hdr", HEADER % (100_000, 100_000), "too large"),
])
def test_an_unusable_environment_is_told(tmp_path, name, content, message):
    """With its path and the reason, on one line."""
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with warnings.catch_warnings(), pytest.raises(SceneError) as caught:
        warnings.simplefilter("error")
        image.read_environment(path)
    assert str(caught.value).startswith(f"{path}: ") and message.lower() in str(caught.value).lower()
    assert "\n" not in str(caught.value)


def test_a_cut_exr_is_told(tmp_path):
    """One that ends in its pixels."""
    rng = np.random.default_rng(2)
    path = exr(tmp_path / "sky.exr", {name: rng.random((64, 64), np.float32) for name in "RGB"})
    path.write_bytes(path.read_bytes()[:9000])
    with pytest.raises(SceneError, match="damaged"):
        image.read_environment(path)


def test_channels_of_other_names_are_told(tmp_path):
    """So that one knows what to rename."""
    path = exr(tmp_path / "sky.exr", {"View.R": np.ones((2, 2), np.float32)})
    with pytest.raises(SceneError, match=r"no channels R, G, B or Y, but View\.R"):
        image.read_environment(path)
