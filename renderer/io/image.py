"""Pictures as files: PPM, PNG and EXR are written, textures are read from PPM, PNG and JPEG, environments and pictures
to compare also from EXR and HDR.

Rows run from the top. Every write is atomic (see `files.py`). The libraries are imported by the function that needs
them: a PPM needs none, which keeps the common run quick to start.
"""

import os
import warnings
from contextlib import closing

from renderer.core import srgb
from renderer.core.errors import Problem, RenderError, SceneError
from renderer.io import rgbe
from renderer.io.files import reason, replacing

# Level 1 of 9: 0.018 s against 0.037 s at the default level for mirror_image in phong mode at 1200 x 800 (105 against
# 61 kB). A whole warm render takes 0.3 s; who stores many pictures can pack them better afterwards.
PNG_COMPRESSION = 1
MAX_PICTURE_PIXELS = 2**26  # 8192 x 8192: 192 MiB as 8-bit RGB; more is a mistake or a decompression bomb
TEXTURE_FORMATS = ("PPM", "PNG", "JPEG")
OTHER_FORMATS = "not a PPM, PNG, JPEG, EXR or HDR picture"
EXR_MAGIC = b"\x76\x2f\x31\x01"
LARGEST_RADIANCE = 1e18  # as for every number of a scene: squares must fit a 32-bit float


def ppm_header(width, height):
    """Return the bytes before the pixels of an 8-bit binary PPM (P6)."""
    return b"P6\n%d %d\n255\n" % (width, height)


def write_ppm(path, rgb8, width, height):
    """Write `width * height * 3` bytes of RGB as a binary PPM (P6).

    Raises: RenderError if the file cannot be written.
    """
    assert len(rgb8) == width * height * 3, "one byte for each of R, G, B"
    with replacing(path) as file:
        file.write(ppm_header(width, height))
        file.write(rgb8)


def write_png(path, rgb8, width, height):
    """Write `width * height * 3` bytes of RGB as an 8-bit PNG.

    Raises: RenderError if the file cannot be written.
    """
    from PIL import Image

    assert len(rgb8) == width * height * 3, "one byte for each of R, G, B"
    picture = Image.frombytes("RGB", (width, height), bytes(rgb8))
    with replacing(path) as file:
        picture.save(file, format="PNG", compress_level=PNG_COMPRESSION)


def write_exr(path, channels, header):
    """Write named `(H, W)` arrays, float32 or uint32, as a one-part EXR: scanlines, ZIP, nothing lost.

    `channels` uses the names that other tools know (`R`, `Z`, `N.X`, `Albedo.R`); `header` adds attributes of text.

    Raises: RenderError if the file cannot be written.
    """
    import OpenEXR

    # The library completes the dictionaries it is given: hand it copies.
    attributes = dict(header, compression=OpenEXR.ZIP_COMPRESSION, type=OpenEXR.scanlineimage)
    with replacing(path) as file:
        try:
            OpenEXR.File(attributes, dict(channels)).write(file)
        except RuntimeError as error:
            raise RenderError(f"{path}: cannot be written: {error}") from error


def read_texture(path, otherwise="not a PPM, PNG or JPEG image"):
    """Return `(width, height, rgb)` of an image file: 8-bit RGB rows from the top, as `bytes`.

    16-bit values are rounded to 8 bits, grey and palettes become RGB, alpha is dropped, and the orientation noted by
    a camera is not applied: the texels are those of the file. `otherwise` is said of files of other formats.

    Raises: SceneError naming the path tried and the reason (missing, not an image, damaged, enormous).
    """
    if not os.path.exists(path):
        raise _unreadable(path, "there is no such file")
    if not os.path.isfile(path):
        raise _unreadable(path, "this is not a file")
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the library's remarks on size and palettes; both are dealt with here
            with Image.open(path, formats=TEXTURE_FORMATS) as image:
                if image.width * image.height > MAX_PICTURE_PIXELS:
                    raise _too_large(path, f"{image.width} x {image.height} pixels")
                rgb = _to_rgb(path, image)
                return rgb.width, rgb.height, rgb.tobytes()
    except SceneError:
        raise
    except Image.DecompressionBombError:
        raise _too_large(path, "its size") from None
    except UnidentifiedImageError:
        raise _unreadable(path, otherwise) from None
    except OSError as error:
        raise _unreadable(path, f"cannot be read: {reason(error)}") from None
    except Exception as error:  # a damaged file can raise nearly anything out of the decoders
        raise _unreadable(path, f"the image is damaged: {error}") from None


def read_picture(path):
    """Return (pixels, header) of an EXR, HDR, PNG, JPEG or PPM, whatever its name.

    Pixels are (height, width, 3), rows from the top: float32 of an EXR or HDR, which hold radiance, uint8 of others. Of
    an EXR the channels R, G, B, or Y, of the first part count, and `header` is the text in it; else it is empty.

    Raises: SceneError with the path and the reason: missing, of another format, damaged, enormous.
    """
    import numpy as np

    try:
        with open(path, "rb") as file:
            head = file.read(len(EXR_MAGIC))
            if head == EXR_MAGIC:
                return _read_exr(path)
            if head[:2] == rgbe.MAGIC[0][:2]:
                file.seek(0)
                return _read_hdr(path, file), {}
        width, height, rgb = read_texture(path, OTHER_FORMATS)
        return np.frombuffer(rgb, np.uint8).reshape(height, width, 3), {}
    except OSError as error:
        raise _unreadable(path, f"cannot be read: {reason(error)}") from None


def read_environment(path):
    """Return (height, width, 3) float32 of linear radiance, as `read_picture`; 8-bit values are decoded from sRGB.

    Raises: SceneError with the path and the reason, also for pixels that are no radiance.
    """
    import numpy as np

    pixels, _ = read_picture(path)
    if pixels.dtype == np.uint8:
        pixels = np.array(srgb.BYTES, np.float32)[pixels]
    wrong = ~((pixels >= 0) & (pixels <= LARGEST_RADIANCE)).all(axis=2)
    if wrong.any():
        y, x = np.argwhere(wrong)[0]
        raise _unreadable(path, f"{np.count_nonzero(wrong)} pixels are no radiance (negative, beyond "
                                f"{LARGEST_RADIANCE:g} or no number), "
                                f"first {pixels[y, x].tolist()} at x = {x}, y = {y}")
    return pixels


def _read_hdr(path, file):
    """Return the pixels of a Radiance picture, a file at its beginning."""
    try:
        width, height = rgbe.read_size(file)
        if width * height > MAX_PICTURE_PIXELS:
            raise _too_large(path, f"{width} x {height} pixels")
        return rgbe.read_pixels(file.read(), width, height)
    except rgbe.BadPicture as error:
        raise _unreadable(path, f"not a Radiance picture that can be read: {error}") from None


def _read_exr(path):
    """Return (pixels, text in the header) of an EXR."""
    import Imath
    import numpy as np
    import OpenEXR

    floats = Imath.PixelType(Imath.PixelType.FLOAT)
    try:
        header = OpenEXR.File(os.fspath(path), header_only=True).header()
        (left, top), (right, bottom) = header["dataWindow"]
        width, height = int(right) - int(left) + 1, int(bottom) - int(top) + 1
        if width * height > MAX_PICTURE_PIXELS:
            raise _too_large(path, f"{width} x {height} pixels")
        # Not OpenEXR.File: that keeps every channel, 59 bytes a pixel of our own files instead of 24.
        with closing(OpenEXR.InputFile(os.fspath(path))) as file:
            channels = file.header()["channels"]
            names = next((names for names in ("RGB", "Y") if set(names) <= set(channels)), None)
            if names is None or "RY" in channels:
                raise _unreadable(path, f"has no channels R, G, B or Y, but {', '.join(sorted(channels))}")
            planes = [np.frombuffer(plane, np.float32) for plane in file.channels(names, floats)]
        planes = planes * (3 // len(names))
        if any(plane.size != width * height for plane in planes):
            raise _unreadable(path, "its channels have fewer pixels than the picture")
        pixels = np.stack(planes, axis=1).reshape(height, width, 3)
    except SceneError:
        raise
    except Exception as error:  # the library raises a RuntimeError for most files, and others for damaged ones
        raise _unreadable(path, f"the EXR is damaged: {' '.join(str(error).split())}") from None
    return pixels, {name: value for name, value in header.items() if isinstance(value, str)}


def _to_rgb(path, image):
    """Return the decoded picture in mode RGB; integers wider than 8 bits are scaled, which `convert` would clip."""
    if image.mode == "F":
        raise _unreadable(path, "floating-point images of this format are not read; use 8 or 16 bits")
    if image.mode == "I" or image.mode.startswith("I;16"):
        # All readers of these formats scale their values to 0 ... 65535. +0.5 rounds; point() truncates.
        return image.convert("I").point(lambda value: value * (255 / 65535) + 0.5).convert("L").convert("RGB")
    if image.mode == "P" and "transparency" in image.info:
        image = image.convert("RGBA")
    return image.convert("RGB")


def _too_large(path, what):
    side = int(MAX_PICTURE_PIXELS**0.5)
    return _unreadable(path, f"too large: {what} (at most as many as {side} x {side})")


def _unreadable(path, message):
    return SceneError(Problem(os.fspath(path), message))
