"""Pictures survive the way to a file and back, and a texture that cannot be used is told in plain words."""

import struct
import zlib

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from renderer.core.errors import RenderError, SceneError
from renderer.io import image

SIZES = [(1, 1), (3, 2), (2, 3), (257, 5)]  # width, height
WRITERS = {".ppm": image.write_ppm, ".png": image.write_png}
NO_HIT = 0xFFFFFFFF


def noise(width, height):
    """Return `(height, width, 3) uint8` in which no two rows or columns are alike."""
    return np.random.default_rng(7).integers(0, 256, (height, width, 3), dtype=np.uint8)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("extension", WRITERS)
def test_eight_bit_picture_reads_back_equal(tmp_path, extension, size):
    """Another program reads the very bytes that were written, in the same rows."""
    pixels = noise(*size)
    path = tmp_path / f"picture{extension}"
    WRITERS[extension](path, pixels.tobytes(), *size)
    with Image.open(path) as read:
        assert read.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(read), pixels)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("extension", WRITERS)
def test_own_picture_is_read_as_texture(tmp_path, extension, size):
    """What we write we can use as a texture, unchanged."""
    pixels = noise(*size)
    path = tmp_path / f"picture{extension}"
    WRITERS[extension](path, pixels.tobytes(), *size)
    assert image.read_texture(path) == (*size, pixels.tobytes())


def test_ppm_is_the_plainest_form(tmp_path):
    """The header is the one that the simplest of readers expects: no comments, maximum 255."""
    path = tmp_path / "picture.ppm"
    image.write_ppm(path, bytes(range(18)), 3, 2)
    assert path.read_bytes() == b"P6\n3 2\n255\n" + bytes(range(18))


@pytest.mark.parametrize("size", SIZES)
def test_exr_keeps_every_value(tmp_path, size):
    """Floats keep all bits, NaN and infinity included, and shape numbers stay integers."""
    width, height = size
    radiance = np.random.default_rng(1).normal(0, 1e6, (height, width)).astype(np.float32)
    radiance.flat[0] = np.nan
    radiance.flat[-1] = np.inf
    shape = np.full((height, width), NO_HIT, np.uint32)
    image.write_exr(tmp_path / "x.exr", {"R": radiance, "Albedo.G": radiance + 1, "Shape": shape}, {})
    channels = OpenEXR.File(str(tmp_path / "x.exr"), separate_channels=True).channels()
    assert set(channels) == {"R", "Albedo.G", "Shape"}
    np.testing.assert_array_equal(channels["R"].pixels.view(np.uint32), radiance.view(np.uint32))
    np.testing.assert_array_equal(channels["Shape"].pixels, shape)
    assert channels["Shape"].pixels.dtype == np.uint32


def test_exr_carries_its_header(tmp_path):
    """Settings are found in the file, whatever letters they are written in."""
    settings = {"renderer.scene": "Räume/scene 1.json", "renderer.samples": "64"}
    image.write_exr(tmp_path / "x.exr", {"R": np.zeros((1, 1), np.float32)}, settings)
    header = OpenEXR.File(str(tmp_path / "x.exr")).header()
    assert settings.items() <= header.items()
    assert header["compression"] == OpenEXR.ZIP_COMPRESSION
    assert header["type"] == OpenEXR.scanlineimage


def test_exr_leaves_the_callers_dictionaries_alone(tmp_path):
    """The same header and channels serve for several files."""
    channels, header = {"R": np.zeros((1, 1), np.float32)}, {"renderer.mode": "phong"}
    image.write_exr(tmp_path / "x.exr", channels, header)
    assert list(channels) == ["R"] and isinstance(channels["R"], np.ndarray)
    assert header == {"renderer.mode": "phong"}


@pytest.mark.parametrize("write", [
    lambda path: image.write_ppm(path, bytes(3), 1, 1),
    lambda path: image.write_png(path, bytes(3), 1, 1),
    lambda path: image.write_exr(path, {"R": np.zeros((1, 1), np.float32)}, {}),
], ids=["ppm", "png", "exr"])
def test_full_disk_is_an_error_with_the_path(write):
    """A device without space makes the write fail with the system's reason, for every format."""
    with pytest.raises(RenderError, match=r"/dev/full: cannot be written: .*No space left on device"):
        write("/dev/full")


def test_grey_texture_becomes_rgb(tmp_path):
    """A grey value stands for three equal ones."""
    Image.fromarray(np.array([[7, 200]], np.uint8)).save(tmp_path / "grey.png")
    assert image.read_texture(tmp_path / "grey.png") == (2, 1, bytes([7, 7, 7, 200, 200, 200]))


def test_sixteen_bits_are_rounded_not_clipped(tmp_path):
    """The middle of the 16-bit range is the middle of the 8-bit range."""
    values = np.array([[0, 128, 129, 257, 32768, 65535]], np.uint16)
    Image.fromarray(values).save(tmp_path / "grey16.png")
    _, _, rgb = image.read_texture(tmp_path / "grey16.png")
    assert list(rgb[::3]) == [0, 0, 1, 1, 128, 255]  # round(value / 257)


def test_palette_with_transparency_becomes_rgb(tmp_path):
    """Indices are looked up and transparency is dropped."""
    picture = Image.new("P", (2, 1))
    picture.putpalette([10, 20, 30, 40, 50, 60])
    picture.putdata([1, 0])
    picture.save(tmp_path / "palette.png", transparency=bytes([0, 128]))
    assert image.read_texture(tmp_path / "palette.png") == (2, 1, bytes([40, 50, 60, 10, 20, 30]))


def test_alpha_is_dropped(tmp_path):
    """A transparent texel keeps its colour; it is not blended with anything."""
    Image.fromarray(np.array([[[9, 8, 7, 0], [6, 5, 4, 255]]], np.uint8)).save(tmp_path / "alpha.png")
    assert image.read_texture(tmp_path / "alpha.png") == (2, 1, bytes([9, 8, 7, 6, 5, 4]))


def test_orientation_of_the_camera_is_ignored(tmp_path):
    """The texels are those of the file, however the camera was held."""
    exif = Image.Exif()
    exif[0x0112] = 6  # "turn by 90 degrees to show"
    Image.fromarray(noise(3, 2)).save(tmp_path / "turned.jpg", exif=exif)
    assert image.read_texture(tmp_path / "turned.jpg")[:2] == (3, 2)


@pytest.mark.parametrize("text, rgb", [
    (b"P3\n# a comment\n2 1\n255\n1 2 3\n255 0 7\n", [1, 2, 3, 255, 0, 7]),
    (b"P3\n1 1\n15\n0 1 15\n", [0, 17, 255]),
    (b"P6 1 1 255\n\x01\x02\x03", [1, 2, 3]),
    (b"P6\n1 1\n65535\n\xff\xff\x80\x00\x00\x00", [255, 128, 0]),
], ids=["comment", "few levels", "header on one line", "16 bits"])
def test_ppm_of_other_programs_is_read(tmp_path, text, rgb):
    """The freedoms that the PPM format leaves are understood."""
    path = tmp_path / "texture.ppm"
    path.write_bytes(text)
    assert list(image.read_texture(path)[2]) == rgb


def enormous_png():
    """Return a PNG of a few bytes that claims 100,000 x 100,000 pixels."""
    header = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(bytes(10))), (b"IEND", b"")]
    packed = [struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
              for kind, data in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


@pytest.mark.parametrize("name, content, message", [
    ("empty.png", b"", "not a PPM, PNG or JPEG image"),
    ("text.jpg", b"once upon a time", "not a PPM, PNG or JPEG image"),
    ("short.ppm", b"P6\n20 20\n255\nabc", "truncated"),
    ("header.ppm", b"P6\n", "damaged"),
    ("bomb.png", enormous_png(), "too large"),
    ("large.ppm", b"P6\n10000 8000\n255\n", "10000 x 8000 pixels"),
    ("float.pfm", b"Pf\n1 1\n-1.0\n\0\0\0\0", "floating-point"),
], ids=lambda value: value if isinstance(value, str) and "." in value else "")
def test_unusable_texture_is_told(tmp_path, name, content, message):
    """The error names the path tried and the reason, in one line."""
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(SceneError) as caught:
        image.read_texture(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_damaged_png_is_told(tmp_path):
    """A PNG cut in the middle of its pixels is not silently completed."""
    path = tmp_path / "cut.png"
    image.write_png(path, noise(40, 40).tobytes(), 40, 40)
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(SceneError, match="truncated"):
        image.read_texture(path)


def test_missing_texture_is_told(tmp_path):
    """A file that is not there is named with its path."""
    with pytest.raises(SceneError, match=r"nowhere\.png: there is no such file"):
        image.read_texture(tmp_path / "nowhere.png")


def test_folder_as_texture_is_told(tmp_path):
    """A folder is not mistaken for a damaged picture."""
    with pytest.raises(SceneError, match="this is not a file"):
        image.read_texture(tmp_path)
