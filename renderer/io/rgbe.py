"""Radiance pictures (.hdr): three 8-bit mantissas with one exponent, plain or run-length encoded [Ward1991].

A value is mantissa * 2^(exponent - 136), 0 where the exponent is 0. No library of ours reads them. An EXPOSURE in the
header is not undone, and primaries are taken for those of sRGB, as other renderers do.
"""

import re

MAGIC = (b"#?RADIANCE", b"#?RGBE")
FORMAT = b"32-bit_rle_rgbe"
BIAS = 136  # 128, and 8 for the bits of the mantissa
PACKED_WIDTHS = range(8, 0x8000)  # scan lines of other widths are never packed channel by channel
RUN = 128  # counts above it are runs
SIZE = re.compile(rb"-Y (\d{1,9}) \+X (\d{1,9})\s*$")
MAX_HEADER = 100  # lines


class BadPicture(Exception):
    """A file that is damaged, or of a variety that is not read."""


def read_size(file):
    """Return (width, height) of a binary file at its beginning, which is then at its first pixel."""
    if not file.readline(80).startswith(MAGIC):
        raise BadPicture("it does not begin with #?RADIANCE")
    for _ in range(MAX_HEADER):
        line = file.readline(4096)
        if line.startswith(b"FORMAT=") and line[7:].strip() != FORMAT:
            raise BadPicture(f"its FORMAT is not {FORMAT.decode()}")
        if not line.strip():
            break
    size = SIZE.match(file.readline(80))
    if not size:
        raise BadPicture("its size is not given as -Y height +X width")
    height, width = map(int, size.groups())
    if not width * height:
        raise BadPicture("it has no pixels")
    return width, height


def read_pixels(data, width, height):
    """Return (height, width, 3) float32 of the bytes after the header. Raises: BadPicture."""
    import numpy as np

    rows, place = np.empty((height, width, 4), np.uint8), 0
    for row in rows:
        packed = width in PACKED_WIDTHS and data[place : place + 3] == bytes((2, 2, width >> 8))
        if packed and data[place + 3 : place + 4] == bytes((width & 0xFF,)):
            for channel in range(4):
                line, place = _channel(data, place + 4 * (channel == 0), width)
                row[:, channel] = np.frombuffer(line, np.uint8)
        else:
            line, place = _plain(data, place, width)
            row[:] = np.frombuffer(line, np.uint8).reshape(-1, 4)
    scale = np.ldexp(np.float32(1), rows[..., 3:].astype(np.int32) - BIAS)
    return rows[..., :3] * np.where(rows[..., 3:] > 0, scale, np.float32(0))


def _channel(data, place, width):
    """Return one packed channel of a scan line, and the place behind it."""
    line = bytearray()
    while len(line) < width:
        if place + 1 >= len(data):
            raise BadPicture("it ends too early")
        count = data[place]
        if count > RUN:
            line += data[place + 1 : place + 2] * (count - RUN)
            place += 2
        else:
            line += data[place + 1 : place + 1 + count]
            place += 1 + count
        if not count or len(line) > width or place > len(data):
            raise BadPicture("a run of its pixels is damaged")
    return line, place


def _plain(data, place, width):
    """Return the pixels of a scan line of 4 bytes each, and the place behind it; (1, 1, 1, n) repeats the last one."""
    line, shift = bytearray(), 0
    while len(line) < 4 * width:
        pixel = data[place : place + 4]
        if len(pixel) < 4:
            raise BadPicture("it ends too early")
        place += 4
        if pixel[:3] == b"\1\1\1":
            line += line[-4:] * (pixel[3] << shift)
            shift += 8
        else:
            line += pixel
            shift = 0
        if shift > 16 or not line or len(line) > 4 * width:
            raise BadPicture("a run of its pixels is damaged")
    return line, place
