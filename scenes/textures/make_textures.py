"""Makes the images of the feature scenes: small, and without any symmetry, so that a flipped axis is seen at once.

Run `python scenes/textures/make_textures.py`; it needs Pillow, and numpy and OpenEXR for the sky.
"""

import math

from pathlib import Path

from PIL import Image, ImageDraw

FOLDER = Path(__file__).parent
INK, PAPER = (28, 34, 48), (240, 236, 222)


def letter():
    """Return an F on four differently coloured quarters: red top left, green top right, blue bottom left, yellow."""
    image = Image.new("RGB", (64, 64))
    draw = ImageDraw.Draw(image)
    for corner, colour in (((0, 0), (214, 84, 72)), ((32, 0), (92, 168, 96)),
                           ((0, 32), (82, 120, 200)), ((32, 32), (232, 190, 84))):
        draw.rectangle((*corner, corner[0] + 31, corner[1] + 31), fill=colour)
    for box in ((20, 10, 27, 53), (20, 10, 47, 17), (20, 27, 39, 34)):
        draw.rectangle(box, fill=PAPER)
    draw.rectangle((0, 0, 63, 63), outline=INK, width=2)
    return image


def globe():
    """Return a longitude and latitude grid: hue turns with longitude, darker to the south, a dot at (1/8, 1/4)."""
    image = Image.new("RGB", (128, 64))
    for y in range(64):
        for x in range(128):
            shade = 1 - 0.55 * y / 63
            hue = (90 + 150 * x // 127, 200 - 110 * x // 127, 120 + 80 * (x // 32 % 2))
            line = x % 16 == 0 or y % 16 == 0
            image.putpixel((x, y), INK if line else tuple(int(shade * channel) for channel in hue))
    ImageDraw.Draw(image).ellipse((11, 11, 21, 21), fill=PAPER)
    return image


def bricks():
    """Return rows of bricks, every second row shifted, the shades falling to the right."""
    image = Image.new("RGB", (96, 64), (196, 188, 176))
    draw = ImageDraw.Draw(image)
    for row in range(4):
        for column in range(-1, 4):
            x, y = column * 32 + (row % 2) * 16, row * 16
            shade = 190 - 14 * column - 8 * row
            draw.rectangle((x + 1, y + 1, x + 30, y + 14), fill=(shade, shade * 5 // 9, shade * 4 // 9))
    return image


def pixels():
    """Return 4 x 3 pixels, all different, to look at single texels."""
    image = Image.new("RGB", (4, 3))
    for y in range(3):
        for x in range(4):
            image.putpixel((x, y), (40 + 70 * x, 60 + 90 * y, 230 - 25 * (x + 4 * y) if (x + y) % 2 else 60))
    return image


def rough():
    """Return stripes from nearly smooth to rough, broader to the right."""
    image = Image.new("L", (64, 16))
    for x in range(64):
        for y in range(16):
            image.putpixel((x, y), 30 if (x * x // 128) % 2 else 120 + 4 * y)
    return image.convert("RGB")


def dents():
    """Return the normals of a round dent in the middle, 0.5 + 0.5 n: x to the right, y down, z out of the surface."""
    image = Image.new("RGB", (64, 64))
    for y in range(64):
        for x in range(64):
            dx, dy = (x - 31.5) / 24, (y - 31.5) / 24
            slope = math.sin(math.pi * min(1.0, math.hypot(dx, dy)))
            n = (-0.5 * dx * slope, -0.5 * dy * slope, 1.0)
            size = math.hypot(*n)
            image.putpixel((x, y), tuple(round(255 * (0.5 + 0.5 * component / size)) for component in n))
    return image


def waves():
    """Return heights of rings around a point off the middle, lower outside."""
    image = Image.new("L", (64, 64))
    for y in range(64):
        for x in range(64):
            r = math.hypot(x - 26, y - 34) / 30
            image.putpixel((x, y), round(127.5 * max(0.0, 1 - r) * (1 + math.cos(5 * math.pi * r))))
    return image.convert("RGB")


def write_sky(path):
    """Write 128 x 64 pixels of a sky with a low sun above brown earth, as an EXR of half floats."""
    import numpy as np
    import OpenEXR

    v, u = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(128) + 0.5) / 128, indexing="ij")
    height = np.cos(np.pi * v)[..., None]
    sky = np.array([0.25, 0.45, 0.9]) + (1 - np.clip(height, 0, 1)) ** 3 * np.array([0.6, 0.35, 0.0])
    light = np.where(height > 0, sky, np.array([0.22, 0.18, 0.14]))
    phi, theta = 2 * np.pi * (u - 0.3), np.pi * v
    cosine = np.sin(theta) * np.cos(phi) * math.cos(0.5) + np.cos(theta) * math.sin(0.5)  # to a sun 0.5 rad high
    light += np.exp((cosine - 1)[..., None] * 900) * np.array([260.0, 220.0, 160.0])
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": light.astype(np.float16)}).write(str(path))


if __name__ == "__main__":
    letter().save(FOLDER / "letter.png", optimize=True)
    globe().save(FOLDER / "globe.png", optimize=True)
    bricks().save(FOLDER / "bricks.jpg", quality=88)
    pixels().save(FOLDER / "pixels.ppm")
    rough().save(FOLDER / "rough.png", optimize=True)
    dents().save(FOLDER / "dents.png", optimize=True)
    waves().save(FOLDER / "waves.png", optimize=True)
    write_sky(FOLDER / "sky.exr")
