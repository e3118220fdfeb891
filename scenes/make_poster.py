"""Makes the scene of a poster in mode `phong`: its description and its two images.

Run `python -m scenes.make_poster`; it needs numpy and Pillow, and the result is the same each time. Mode `phong` writes
its colours without gamma, so those below are what is seen.
"""

import math
from pathlib import Path

import numpy as np
from PIL import Image

from scenes.making import text

FOLDER = Path(__file__).parent
PAPER, NAVY, RED = (0.95, 0.90, 0.79), (0.07, 0.10, 0.22), (0.87, 0.22, 0.13)
GOLD, PLUM = (0.93, 0.64, 0.20), (0.42, 0.13, 0.22)
STAGE = 5.2  # radius
ARMS = 28  # diamonds on a circle of the stage
AMBIENT = 0.36  # light from everywhere
FINE = 2  # samples along the sides of a texel
LIFT = 0.002  # of what would share a plane with the stage
BANDS = ((9, PAPER), (20, GOLD), (34, RED), (52, PLUM), (91, NAVY))  # degrees above the horizon, up to which


def stage():
    """Return the pattern of the stage, angle by radius: diamonds between two sets of logarithmic spirals."""
    width, height = 3072, 1024
    turn = ARMS * (np.arange(width * FINE) + 0.5)[None] / (width * FINE)
    radius = ((np.arange(height * FINE) + 0.5) / (height * FINE))[:, None]
    rise = ARMS / (2 * math.pi) * np.log(radius)
    even = (np.floor(turn + rise) + np.floor(turn - rise)) % 2
    even = np.where((radius > 0.965) & (radius < 0.985), 1, even)
    even = np.where(radius > 0.985, 0, even)
    share = even.reshape(height, FINE, width, FINE).mean((1, 3))[..., None]
    return picture(share * np.array(NAVY) + (1 - share) * np.array(PAPER))


def sky():
    """Return the surroundings: bands of colour above the horizon, paper below; in sRGB, unlike textures."""
    elevation = 90 - 180 * (np.arange(256) + 0.5) / 256
    rows = [next(colour for top, colour in BANDS if angle < top) for angle in elevation]
    linear = np.repeat(np.array(rows)[:, None], 8, axis=1)
    return picture(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))


def picture(colours):
    """Return colours from 0 to 1 as an image."""
    return Image.fromarray(np.uint8(np.rint(255 * np.clip(colours, 0, 1))))


def crystal(x, z, radius, height, point, turn):
    """Return the corners of a six-sided column with a point."""
    corners = []
    for k in range(6):
        a = math.radians(60 * k + turn)
        corners += [[x + radius * math.cos(a), y, z + radius * math.sin(a)] for y in (LIFT, height)]
    return [[round(c, 4) for c in corner] for corner in [*corners, [x, height + point, z]]]


def matt(colour, **keys):
    """Return a material of the coursework's kind."""
    return {"diffusecolor": list(colour), "kd": 0.8, "ks": 0.15, "specularexponent": 60, **keys}


def sphere(x, z, radius, material):
    """Return a sphere on the stage."""
    return {"type": "sphere", "center": [x, radius, z], "radius": radius, "material": material}


def column(x, z, radius, height, material):
    """Return an upright cylinder on the stage, or below it where the height is negative."""
    middle = round(height / 2 + math.copysign(LIFT, height), 4)
    return {"type": "cylinder", "center": [round(x, 4), middle, round(z, 4)], "axis": [0, 1, 0], "radius": radius,
            "height": round(abs(height) / 2, 4), "material": material}


def scene():
    """Return the scene as the text of a file."""
    glass = {"isrefractive": True, "refractiveindex": 1.5, "ks": 0.3, "specularexponent": 400}
    mirror = {"isreflective": True, "reflectivity": 0.94, "diffusecolor": [0.1, 0.1, 0.1], "kd": 0.3, "ks": 0.5,
              "specularexponent": 500}
    flat = {"kd": 0, "ks": 0}
    striped = matt(PAPER, texture={"type": "checkerboard", "color1": list(PAPER), "color2": list(GOLD), "scale": 12},
                   scaleU=0.01)
    disc = {**flat, "diffusecolor": [round(c / AMBIENT, 4) for c in RED]}
    shapes = [
        column(0, 0, STAGE, -0.3, matt(NAVY)),
        {"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": STAGE,
         "material": matt((1, 1, 1), texture="textures/spirals.png", ks=0)},
        {"type": "disk", "center": [-0.7, 1.0, 30], "normal": [0, 0, -1], "radius": 7.0, "material": disc},
        sphere(0, 0, 1.35, mirror),
        sphere(1.75, -1.6, 0.72, glass),
        sphere(0.35, -2.7, 0.3, matt(RED, ks=0.5)),
        {"type": "convex", "vertices": crystal(-1.95, -1.5, 0.5, 1.5, 0.5, 12), "material": glass},
        *(column(1.4 + 0.58 * k, 1.3 + 0.4 * k, 0.22, 1.9 + 0.75 * k, material)
          for k, material in enumerate((matt(GOLD), striped, matt(NAVY), matt(RED)))),
    ]
    camera = {"type": "thinlens", "width": 640, "height": 900, "fov": 37, "position": [0, 4.3, -13.5],
              "lookAt": [0.1, 1.52, 0], "apertureRadius": 0.035, "focusDistance": 13, "exposure": 0.1}
    return text({"rendermode": "phong", "samples": 256, "nbounces": 10, "filter": "gaussian", "camera": camera,
                 "scene": {"ambientlight": [AMBIENT] * 3, "lightsources": lights(), "shapes": shapes}})


def lights():
    """Return what shines: the surroundings, a warm lamp from the left, a cool one from the right."""
    return [
        {"type": "environment", "filename": "textures/bands.png"},
        {"type": "arealight", "position": [-9, 7.5, -5.5], "u": [1.1, 0, -1.6], "v": [0.8, 1.2, 0.6],
         "intensity": [0.98, 0.90, 0.76]},
        {"type": "spot", "position": [9, 7, -7], "direction": [-9, -6.6, 7.4], "cutoff": 26,
         "intensity": [0.12, 0.15, 0.26]},
    ]


def textures():
    """Return the images, by name."""
    return {"spirals.png": stage(), "bands.png": sky()}


def main():
    """Write everything."""
    for name, image in textures().items():
        image.save(FOLDER / "textures" / name, optimize=True)
    (FOLDER / "poster.json").write_text(scene())


if __name__ == "__main__":
    main()
