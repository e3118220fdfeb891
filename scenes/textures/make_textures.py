"""Makes the images of the feature scenes: small, and without any symmetry, so that a flipped axis is seen at once.

Run `python scenes/textures/make_textures.py`; Pillow is all it needs.
"""

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


if __name__ == "__main__":
    letter().save(FOLDER / "letter.png", optimize=True)
    globe().save(FOLDER / "globe.png", optimize=True)
    bricks().save(FOLDER / "bricks.jpg", quality=88)
    pixels().save(FOLDER / "pixels.ppm")
