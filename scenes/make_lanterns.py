"""Makes the scene of lanterns on a lake at dusk: lanterns.json, its meshes and its images.

Run `python -m scenes.make_lanterns`; the result is the same each time. It needs numpy, Pillow and OpenEXR.
x is to the right, y up, and the camera looks along +z over water at y = 0; a scene unit is a metre.
"""

import math
import random
from pathlib import Path

import numpy as np
from PIL import Image

from scenes.making import grid, joined, ply, text

FOLDER = Path(__file__).parent
SEED = 11
WATER, TILE = 400.0, 20.0  # metres: side of the lake, and of one copy of its waves
AMBER, EMBER = (1.0, 0.43, 0.10), (0.85, 0.17, 0.022)  # of paper beside the flame, and far from it
GLOW = 1.5  # radiance of paper beside the flame
BANDS = (9, 4, 1)  # bands of paper of a lantern that is near, farther, far
NEAR, FAR = 26.0, 62.0  # metres: from where lanterns have fewer bands
EYE, LOOK_AT = (0.0, 3.1, 0.0), (0.0, 4.9, 30.0)
WOOD = {"bsdf": {"type": "diffuse", "reflectance": [0.12, 0.06, 0.035]}}


def paper(radius, low, high, power, around=28, along=3):
    """Return a band of a lantern between two heights in [0, 1]: a rounded square or, with power 2, a circle.

    `radius` is a function of the height. Triangles face outwards.
    """
    heights = np.linspace(low, high, along + 1)
    angle = np.linspace(0, 2 * np.pi, around + 1)
    c, s = np.cos(angle), np.sin(angle)
    shape = (np.abs(c) ** power + np.abs(s) ** power) ** (-1 / power)
    r = np.array([radius(h) for h in heights])[:, None] * shape
    points = np.stack([r * c, np.broadcast_to(heights[:, None], r.shape), -r * s], -1)
    return grid(points, np.stack(np.meshgrid(angle / (2 * np.pi), heights), -1))


def floating(h):
    """Return the radius of a floating lantern's paper at a height in [0, 1] of its own."""
    return 0.36 + 0.05 * h


def rising(h):
    """Return the radius of a rising lantern's paper at a height in [0, 1] of its own."""
    return 0.27 + 0.17 * math.sin(math.pi / 2 * min(1.0, h / 0.62)) if h < 0.62 else 0.44 * math.sqrt(
        max(0.0, 1 - ((h - 0.62) / 0.38) ** 2.6))


def bands():
    """Return {name: mesh} of the bands of both kinds of lanterns, for each number of bands, and their lids."""
    meshes = {}
    for kind, radius, power in (("float", floating, 7.0), ("rise", rising, 2.0)):
        for count in BANDS:
            for k in range(count):
                along = 9 // count + (kind == "rise") * 2 if count > 1 else 6
                around = 28 if count > 1 else 12
                meshes[f"{kind}_{count}_{k}"] = paper(radius, k / count, (k + 1) / count, power, around, along)
    rim = paper(lambda h: floating(1) * (1 - h), 0.0, 1.0, 7.0, 28, 1)
    meshes["float_lid"] = (rim[0] * [0.94, 0, 0.94] + [0, 0.93, 0], rim[1], rim[2])
    return meshes


def boat():
    """Return a rowing boat of length 2 along x around the origin, its keel at y = 0: hull, inside, rim and thwarts."""
    s, t = np.linspace(-1, 1, 41)[:, None], np.linspace(-1, 1, 25)[None, :]
    beam, sheer = 0.30 * (1 - np.abs(s) ** 2.6) ** 0.75 * (1 - 0.1 * s), 0.20 + 0.11 * s**2 + 0.03 * s**3
    keel = 0.02 + 0.16 * np.abs(s) ** 5

    def side(inset):
        """Return the surface that lies by `inset` inside of the hull."""
        b, k = np.maximum(beam - inset, 0.0), keel + inset
        shape = np.abs(t) ** 2.2
        y = k + (sheer - k) * shape
        return np.stack([s * (1 - inset) + 0.4 * s**5 * y, y, b * np.sign(t) * np.abs(t) ** 0.75], -1)

    uv = np.stack([1.5 * s + 0 * t, 2.5 * t + 0 * s], -1)
    outer, inner = side(0.0), side(0.018)
    parts = [grid(outer, uv), grid(inner, uv)]
    for edge in (0, -1):
        parts.append(grid(np.stack([outer[:, edge], inner[:, edge]], 1), uv[:, :2] * 0.3))
    for x in (-0.45, 0.05, 0.5):
        w = 0.27 * (1 - abs(x) ** 2.6) ** 0.75
        for y in (0.17, 0.15):
            corners = np.array([[[x - 0.05, y, -w], [x - 0.05, y, w]], [[x + 0.05, y, -w], [x + 0.05, y, w]]])
            parts.append(grid(corners, np.array([[[0, 0], [1.5, 0]], [[0, 0.3], [1.5, 0.3]]])))
        for dx in (-0.05, 0.05):
            corners = np.array([[[x + dx, 0.15, -w], [x + dx, 0.15, w]], [[x + dx, 0.17, -w], [x + dx, 0.17, w]]])
            parts.append(grid(corners))
    return joined(parts)


def reeds():
    """Return blades of reed around the origin, up to some 2 m high, as strips that bend."""
    numbers, parts = random.Random(SEED + 1), []
    for _ in range(70):
        x, z, turn = numbers.gauss(0, 0.5), numbers.gauss(0, 0.5), numbers.uniform(0, 2 * math.pi)
        height, lean, width = numbers.uniform(0.7, 2.0), numbers.gauss(0.0, 0.35), numbers.uniform(0.008, 0.017)
        k = np.linspace(0, 1, 9)
        middle = np.stack([x + lean * k**2.2 * height, height * k * (1 - 0.12 * abs(lean) * k), z + 0.1 * k], -1)
        across = np.outer(width * (1 - k**1.6), [math.cos(turn), 0, 0.6 * math.sin(turn)])
        parts.append(grid(np.stack([middle - across, middle + across], 1)))
    return joined(parts)


HILLS = ((214.0, 8.4, 0.0), (240.0, 18.9, 2.0), (275.0, 26.9, 4.6), (320.0, 43.3, 1.1))  # distance, height, phase
# Colour of each ridge, and share of mist at its foot
MIST = (((0.02, 0.025, 0.03), 0.75), ((0.10, 0.11, 0.115), 1.0), ((0.24, 0.24, 0.245), 1.0), ((0.44, 0.41, 0.40), 1.0))


def hill(number):
    """Return one row of hills: a wall whose upper edge is their ridge; v runs from the ridge down."""
    distance, height, phase = HILLS[number]
    x = np.linspace(-1.1, 1.1, 161)
    ridge = 0.5 + sum(0.30 / n**1.1 * np.sin(n * 2.1 * x + phase * n * 1.7 + n * n) for n in range(1, 24))
    top = np.maximum(height * (0.30 + 0.6 * np.clip(ridge, 0.02, None)), 1.2)
    points = np.stack([np.stack([0.56 * x * distance, y, np.full_like(x, distance)], -1) for y in (top, 0 * top)])
    v = np.broadcast_to(np.array([[0.0], [1.0]]), (2, 161))
    return grid(points, np.stack([np.full_like(v, (number + 0.5) / len(HILLS)), v], -1))


def moon():
    """Return a thin crescent of radius 1 in the plane z = 0."""
    k = np.linspace(-np.pi / 2, np.pi / 2, 41)
    outer, inner = np.stack([np.cos(k), np.sin(k), 0 * k], -1), np.stack([0.74 * np.cos(k), np.sin(k), 0 * k], -1)
    return grid(np.stack([inner, outer]))


def waves():
    """Return the heights of a tile of water as an image: waves of many directions that repeat after the tile."""
    numbers, size = random.Random(SEED), 512
    y, x = np.meshgrid(np.arange(size) / size, np.arange(size) / size, indexing="ij")
    height = np.zeros((size, size))
    for _ in range(90):
        length = numbers.uniform(math.log(2), math.log(44))
        angle = numbers.gauss(math.pi / 2, 0.75)  # crests lie mostly across the line of sight
        kx, ky = round(math.exp(length) * math.cos(angle)), round(math.exp(length) * math.sin(angle))
        k = math.hypot(kx, ky)
        height += numbers.gauss(0, 1) / max(k, 1) ** 1.15 * np.sin(2 * np.pi * (kx * x + ky * y + numbers.random()))
    height = (height - height.min()) / (height.max() - height.min())
    return Image.fromarray(np.uint8(np.round(255 * height)))


def mist():
    """Return the colours of the hills, a column each, from the ridge down to the mist at their foot."""
    image = np.zeros((64, len(HILLS), 3))
    fog = np.array([0.98, 0.86, 0.80])
    for column, (ridge, thick) in enumerate(MIST):
        v = (np.linspace(0, 1, 64) ** 0.8 * thick)[:, None]
        image[:, column] = np.array(ridge) * (1 - v) + fog * v
    encoded = np.where(image < 0.0031308, 12.92 * image, 1.055 * image ** (1 / 2.4) - 0.055)
    return Image.fromarray(np.uint8(np.round(255 * encoded)))


def dusk():
    """Return the sky as (H, W, 3) float16: blue above, mist at the horizon, last light in one direction."""
    height, width = 192, 256
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    up = np.degrees(np.pi / 2 - np.pi * v)[..., None]  # degrees above the horizon
    aside = (360 * (u - 0.5))[..., None] + 12  # degrees from the last light, which is a little to the right
    high = np.clip(up / 90, 0, 1)
    sky = np.array([0.018, 0.042, 0.085]) + np.exp(-high / 0.25) * np.array([0.085, 0.125, 0.16])
    sky = sky + np.exp(-((up - 1) / 7) ** 2 - (aside / 48) ** 2) * np.array([0.36, 0.17, 0.075])
    behind = 1 + 3.0 * (np.abs(aside - 12) > 90) * np.clip((np.abs(aside - 12) - 90) / 40, 0, 1)
    below = np.where(up < 0, 0.35, 1.0)
    return (sky * behind * below).astype(np.float16)


def lantern(kind, place, size, turn, strength):
    """Return the shapes of a lantern whose paper stands at `place`."""
    distance = math.dist(place, EYE) / max(0.5, size / 0.5)
    count = BANDS[0] if distance < NEAR else BANDS[1] if distance < FAR else BANDS[2]
    tall = 1.25 * size
    steps = [{"scale": [round(size, 3), round(tall, 3), round(size, 3)]},
             {"rotate": {"axis": [0, 1, 0], "angle": round(turn)}}, {"translate": [round(c, 2) for c in place]}]

    def shining(name, radiance):
        return {"type": "mesh", "filename": f"meshes/lanterns/{name}.ply", "normals": "flat", "transform": steps,
                "material": {"bsdf": {"type": "diffuse", "reflectance": [0.5, 0.35, 0.2]}}, "emission": radiance}

    shapes = [shining(f"{kind}_{count}_{k}", radiance((k + 0.5) / count, strength, kind)) for k in range(count)]
    if kind == "float" and count > 1:
        shapes.append(shining("float_lid", radiance(0.25, strength, kind)))
        x, _, z = place
        shapes.append({"type": "cylinder", "center": [round(x, 2), 0.02, round(z, 2)], "axis": [0, 1, 0],
                       "radius": round(0.50 * size, 3), "height": 0.03, "material": WOOD})
    return shapes


def radiance(h, strength, kind):
    """Return what paper at a height in [0, 1] shines with: most beside the flame, redder and less far from it."""
    flame, reach = (0.30, 0.5) if kind == "float" else (0.0, 0.62)
    near = math.exp(-(((h - flame) / reach) ** 2))
    colour = [near * a + (1 - near) * e for a, e in zip(AMBER, EMBER)]
    return [round(GLOW * strength * (0.10 + 0.9 * near) * c, 3) for c in colour]


def stream(s):
    """Return (x, z) of the middle of the current, for s from 0 near the camera to 1 at the far shore."""
    z = 9.5 * (210 / 9.5) ** s
    return z * (0.06 + 0.10 * s + 0.30 * (1 - 0.45 * s) * math.cos(2 * math.pi * (0.96 * s - 0.03))), z


def lanterns():
    """Return the shapes of all lanterns: a stream on the water, and those that rise from its end."""
    numbers, shapes, taken = random.Random(SEED), [], []
    while len(taken) < 300:
        s = numbers.random() ** 0.75
        x, z = stream(s)
        x += numbers.gauss(0, 0.036 + 0.05 * (numbers.random() < 0.15)) * z
        z *= math.exp(numbers.gauss(0, 0.05))
        size = numbers.uniform(0.5, 0.68)
        clear = all(math.hypot(x - a, z - b) > 0.75 + 0.02 * z for a, b in taken)
        if z < 9 or not clear or (abs(x + 3.5) < 3.4 and abs(z - 13.6) < 2.6):
            continue
        taken.append((x, z))
        shapes += lantern("float", (x, 0.05, z), size, numbers.uniform(0, 90),
                          numbers.uniform(0.55, 1.15) * (0.35 + 0.65 * math.exp(-z / 90)))
    for _ in range(165):
        s = 0.94 * numbers.random() ** 0.9
        z = 150 - 108 * s + numbers.gauss(0, 7)
        x = z * (0.10 + 0.33 * s - 0.62 * s**2.2 + numbers.gauss(0, 0.035 + 0.03 * s))
        y = 3 + z * (0.02 + 0.36 * s**1.35 + abs(numbers.gauss(0, 0.03)))
        shapes += lantern("rise", (x, y, z), numbers.uniform(0.8, 1.1), numbers.uniform(0, 360),
                          numbers.uniform(0.5, 1.1))
    return shapes


def mesh(name, material, *steps, **keys):
    """Return a mesh of this scene."""
    return {"type": "mesh", "filename": f"meshes/lanterns/{name}.ply", "transform": list(steps), **keys,
            "material": material}


def scene():
    """Return the scene as a document."""
    water = {"bsdf": {"type": "plastic", "ior": 1.33, "reflectance": [0.006, 0.016, 0.024]},
             "bumpmap": "textures/ripples.png", "bumpscale": 0.16, "scaleU": WATER / TILE, "scaleV": WATER / TILE}
    hills = {"bsdf": {"type": "diffuse", "reflectance": "textures/mist.png"}, "texturewrap": "clamp"}
    planks = {"bsdf": {"type": "principled", "basecolor": [0.42, 0.22, 0.12], "roughness": 0.45}}
    shapes = [
        {"type": "rectangle", "center": [0, 0, WATER / 2 - 20], "u": [WATER, 0, 0], "v": [0, 0, WATER],
         "material": water},
        *(mesh(f"hill_{k}", hills, normals="flat") for k in range(len(HILLS))),
        mesh("boat", planks, {"scale": 2.5}, {"rotate": {"axis": [0, 1, 0], "angle": 24}},
             {"translate": [-3.5, -0.11, 13.6]}, normals="smooth"),
        mesh("reeds", {"bsdf": {"type": "diffuse", "reflectance": [0.05, 0.06, 0.03]}}, {"scale": 1.35},
             {"translate": [-4.7, -0.1, 9.6]}, normals="flat"),
        mesh("moon", {"bsdf": {"type": "diffuse"}}, {"scale": 4.7}, {"rotate": {"axis": [0, 0, 1], "angle": -34}},
             {"translate": [-107.8, 107, 330]}, normals="flat", emission=[1.6, 1.5, 1.25]),
        *(shape for x, z, turn in ((-4.53, 14.06, 20), (-3.39, 13.55, 65))  # on thwarts of the boat
          for shape in lantern("float", (x, 0.325, z), 0.46, turn, 1.15)[:-1]),
        *lanterns(),
    ]
    return {"camera": {"type": "thinlens", "width": 900, "height": 600, "fov": 36, "position": EYE, "lookAt": LOOK_AT,
                       "apertureRadius": 0.03, "focusDistance": 17, "exposure": 0.1},
            "scene": {"lightsources": [{"type": "environment", "filename": "textures/dusk.exr"}], "shapes": shapes},
            "rendermode": "pathtracer", "samples": 192, "nbounces": 6, "filter": "gaussian", "tonemap": "filmic"}


def meshes():
    """Return {name: mesh} of all meshes of the scene."""
    hills = {f"hill_{k}": hill(k) for k in range(len(HILLS))}
    return {**bands(), "boat": boat(), "reeds": reeds(), "moon": moon(), **hills}


def write_sky(path):
    """Write the sky as an EXR of half floats."""
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": dusk()}).write(str(path))


if __name__ == "__main__":
    (FOLDER / "meshes" / "lanterns").mkdir(exist_ok=True)
    for name, (vertices, uv, triangles) in meshes().items():
        (FOLDER / "meshes" / "lanterns" / f"{name}.ply").write_bytes(ply(vertices, triangles, uv=uv))
    waves().save(FOLDER / "textures" / "ripples.png", optimize=True)
    mist().save(FOLDER / "textures" / "mist.png", optimize=True)
    write_sky(FOLDER / "textures" / "dusk.exr")
    (FOLDER / "lanterns.json").write_text(text(scene()))
