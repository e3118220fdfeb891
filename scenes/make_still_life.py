"""Makes the scene of a still life in the morning sun: its description, its turned meshes and its textures.

Run `python -m scenes.make_still_life`; it needs numpy and Pillow, and the result is the same each time. Lengths are in
decimetres, +x to the right, +z into the picture.

A mesh surrounds nothing, so the water in the carafe is told by its surfaces: glass against air (index 1.5), glass
against water (1.5 / 1.33, the glass inside), water against air (1.33). The first two share a ring at the water's level
and close the glass; the last is a disk, which reaches the glass.
"""

import math
from pathlib import Path

import numpy as np
from PIL import Image

from scenes.making import ply, text
from scenes.turning import curve, thick, turned

FOLDER = Path(__file__).parent
GLASS, WATER = 1.5, 1.333
SUN = {"towards": (-0.80, 0.40, -0.50), "distance": 90.0, "half_angle_deg": 2.0, "radiance": (1150.0, 860.0, 540.0)}
QUALITY = 88  # of JPEG files
LEVEL = 1.32  # of the water above the carafe's foot
LIFT = 0.001  # of things above the table, so that no two surfaces are in one plane
BRASS = {"eta": [0.444, 0.527, 1.094], "k": [3.695, 2.765, 1.829], "reflectance": [1.0, 0.86, 0.62]}


def carafe():
    """Return the profiles of a carafe's glass against air, and of its glass against water."""
    outer = curve([(0.50, 0.0), (0.60, 0.06), (0.69, 0.42), (0.68, 0.85), (0.52, 1.32), (0.31, 1.76), (0.25, 2.12),
                   (0.29, 2.45), (0.36, 2.62)])
    whole = thick(outer, 0.055, 0.13)
    top = int(whole[:, 1].argmax())
    below = next(k for k in range(top, len(whole)) if whole[k, 1] < LEVEL)
    share = (LEVEL - whole[below, 1]) / (whole[below - 1, 1] - whole[below, 1])
    ring = whole[below] + share * (whole[below - 1] - whole[below])
    return np.vstack([whole[:below], ring]), np.vstack([ring, whole[below:]])


def bowl():
    """Return the profile of a bowl on a foot."""
    return thick(curve([(0.42, 0.0), (0.44, 0.07), (0.40, 0.13), (0.66, 0.23), (0.93, 0.43), (1.08, 0.72)]), 0.06, 0.22)


def jug():
    """Return the profile of a brass vase."""
    return thick(curve([(0.40, 0.0), (0.43, 0.05), (0.34, 0.14), (0.52, 0.45), (0.60, 0.80), (0.47, 1.22), (0.24, 1.58),
                        (0.21, 1.84), (0.34, 2.1)]), 0.03, 0.16)


def lemon():
    """Return the profile of a lemon along +y, its middle in the origin."""
    return np.vstack([[0, -0.52], curve([(0.055, -0.5), (0.10, -0.43), (0.26, -0.30), (0.355, -0.02), (0.27, 0.27),
                                         (0.11, 0.41), (0.075, 0.47)]), [0, 0.5]])


def meshes():
    """Return the files of all meshes, by name."""
    dry, wet = carafe()
    plain = {"carafe.ply": turned(dry), "carafe_wet.ply": turned(wet), "vase.ply": turned(jug(), 72)}
    mapped = {"bowl.ply": turned(bowl(), 72), "lemon.ply": turned(lemon(), 48)}
    return {name: ply(points, triangles, normals, uv if name in mapped else None)
            for name, (points, normals, uv, triangles) in (plain | mapped).items()}


# Textures

def noise(seed, height, width, roughness, stretch=1.0):
    """Return (height, width) numbers of mean 0 and deviation 1 that tile, of a spectrum falling with `roughness`.

    `stretch` > 1 draws them out along the columns.
    """
    white = np.random.RandomState(seed).standard_normal((height, width))  # a stream that numpy keeps for good
    fy, fx = np.fft.fftfreq(height)[:, None] * stretch * height, np.fft.fftfreq(width)[None] * width
    frequency = np.hypot(fy, fx)
    frequency[0, 0] = math.inf
    smooth = np.fft.ifft2(np.fft.fft2(white) * frequency**-roughness).real
    return smooth / smooth.std()


def mixed(stops, t):
    """Return colours between `stops`, a list of (r, g, b) in sRGB from 0 to 255, at t from 0 to 1."""
    stops = np.asarray(stops, float)
    place = np.clip(t, 0, 1) * (len(stops) - 1)
    return np.stack([np.interp(place, np.arange(len(stops)), stops[:, c]) for c in range(3)], axis=-1)


def image(values):
    """Return numbers or colours from 0 to 255 as an image."""
    return Image.fromarray(np.uint8(np.rint(np.clip(values, 0, 255))))


def wood():
    """Return colours and heights (0 to 1) of five planks that run down the image."""
    height = width = 768
    x = np.arange(width)[None] / width * np.ones((height, 1))
    plank = np.floor(5 * x).astype(int)
    within = np.abs((5 * x) % 1 - 0.5)
    shift = np.array([0, 190, 420, 330, 610])[plank]
    rows = (np.arange(height)[:, None] + shift) % height
    columns = np.broadcast_to(np.arange(width)[None], rows.shape)
    figure = 2.3 * noise(1, height, width, 2.4, 9.0)[rows, columns] + 1.7 * 5 * x
    rings = (figure % 1) ** 2 * (1 - np.clip((figure % 1 - 0.86) / 0.14, 0, 1))  # slowly darker, then at once light
    fibre = noise(2, height, width, 0.8, 24.0)[rows, columns]
    tone = np.array([0.50, 0.66, 0.44, 0.60, 0.55])[plank]
    shade = tone - 0.30 * rings + 0.075 * fibre + 0.06 * noise(3, height, width, 1.5)
    seam = np.clip((within - 0.487) / 0.010, 0, 1)
    colours = mixed([(62, 36, 21), (116, 74, 44), (170, 118, 74), (208, 160, 110)], shade) * (1 - 0.8 * seam[..., None])
    heights = np.clip(0.66 - 0.10 * rings + 0.07 * fibre - 0.6 * seam, 0, 1)
    return colours, heights


def normals(heights, depth):
    """Return the map of normals 0.5 + 0.5 n of heights that tile; `depth` is the height of 1 in texels."""
    dx = (np.roll(heights, -1, 1) - np.roll(heights, 1, 1)) * depth / 2
    dy = (np.roll(heights, -1, 0) - np.roll(heights, 1, 0)) * depth / 2
    n = np.stack([-dx, -dy, np.ones_like(dx)], axis=-1)
    return 255 * (0.5 + 0.5 * n / np.linalg.norm(n, axis=-1, keepdims=True))


def plaster():
    """Return heights from 0 to 1 of a plaster wall: trowel strokes and grain."""
    waves, grain = noise(7, 512, 512, 1.9), noise(8, 512, 512, 1.1)
    return np.clip(0.5 + 0.13 * waves + 0.045 * grain, 0, 1)


def orange():
    """Return colours and heights (0 to 1) of an orange's peel by longitude and latitude, a stalk on top."""
    v, u = np.meshgrid((np.arange(256) + 0.5) / 256, (np.arange(512) + 0.5) / 512, indexing="ij")
    up, ring = np.cos(math.pi * v), np.sin(math.pi * v)
    directions = np.stack([ring * np.cos(2 * math.pi * u), up, ring * np.sin(2 * math.pi * u)], -1).reshape(-1, 3)
    pores = np.random.RandomState(5).standard_normal((1800, 3))
    pores /= np.linalg.norm(pores, axis=1, keepdims=True)
    nearest = np.concatenate([(part @ pores.T).max(1) for part in np.array_split(directions, 16)]).reshape(v.shape)
    dimple = np.exp(-((np.arccos(np.clip(nearest, -1, 1)) / 0.022) ** 2))
    stalk = np.exp(-((math.pi * v / 0.10) ** 2))
    blush = 0.5 + 0.12 * noise(6, *v.shape, 1.6) + 0.25 * up
    colours = mixed([(218, 92, 14), (238, 124, 20), (246, 152, 36)], blush) * (1 - 0.07 * dimple[..., None])
    colours += (np.array([92, 84, 40]) - colours) * np.clip(1.4 * stalk, 0, 1)[..., None]
    return colours, np.clip(0.8 - 0.5 * dimple - 0.5 * stalk, 0, 1)


def glaze():
    """Return the colours of the bowl: u around it, v from its foot over the rim (near 0.53) to its inside."""
    v = (np.arange(256)[:, None] + 0.5) / 256 * np.ones((1, 512))
    drip = 0.016 * noise(9, 256, 512, 1.3, 6.0)
    clay = np.clip((0.245 + 2.2 * drip - v) / 0.012, 0, 1)
    rim = np.exp(-(((v - 0.535 + drip) / 0.022) ** 2))
    depth = 0.5 + 0.12 * noise(10, 256, 512, 1.2) + 0.5 * np.clip((v - 0.6) / 0.4, -1, 1)
    colours = mixed([(34, 84, 92), (24, 98, 106), (62, 142, 140)], depth)
    colours += (np.array([132, 84, 48]) - colours) * np.clip(rim, 0, 1)[..., None]
    return colours + (np.array([150, 104, 72]) - colours) * clay[..., None]


def textures():
    """Return the images of all textures, by name."""
    board, relief = wood()
    peel, pores = orange()
    return {"planks.jpg": image(board), "planks_normals.jpg": image(normals(relief, 3.0)),
            "plaster.png": image(255 * plaster()), "orange.jpg": image(peel), "orange_peel.png": image(255 * pores),
            "glaze.jpg": image(glaze())}


# The scene

def box(low, high, material):
    """Return a box."""
    return {"type": "box", "min": low, "max": high, "material": material}


def mesh(name, place, material, *turns):
    """Return a mesh, turned and brought to its place."""
    return {"type": "mesh", "filename": f"meshes/morning/{name}.ply", "transform": [*turns, {"translate": place}],
            "material": material}


def window():
    """Return the bars of a window at the left, and the wall around it, which keeps the rest of the sun out."""
    paint = {"bsdf": {"type": "diffuse", "reflectance": [0.6, 0.58, 0.54]}}
    x0, x1, bottom, top, near, far = -4.4, -4.2, 1.15, 5.8, -4.5, 1.3
    wall = [box([x0, -3, -14], [x1, bottom, 4], paint), box([x0, top, -14], [x1, 10, 4], paint),
            box([x0, bottom, -14], [x1, top, near], paint), box([x0, bottom, far], [x1, top, 4], paint)]
    bars = [box([x0, bottom, z - 0.17], [x1, top, z + 0.17], paint) for z in (-0.45, -2.45)]
    bars += [box([x0, y - 0.15, near], [x1, y + 0.15, far], paint) for y in (2.75, 4.3)]
    return wall + bars


def sun():
    """Return the sun as a shining sphere."""
    towards = np.array(SUN["towards"]) / np.linalg.norm(SUN["towards"])
    return {"type": "sphere", "center": [round(c, 3) for c in (SUN["distance"] * towards).tolist()],
            "radius": round(SUN["distance"] * math.sin(math.radians(SUN["half_angle_deg"])), 3),
            "emission": list(SUN["radiance"]), "material": {"bsdf": {"type": "diffuse", "reflectance": [0, 0, 0]}}}


def fruit(x, y, z, radius):
    """Return an orange."""
    return {"type": "sphere", "center": [x, y, z], "radius": radius, "material": {
        "bsdf": {"type": "principled", "basecolor": "textures/orange.jpg", "roughness": 0.42, "specular": 0.45},
        "bumpmap": "textures/orange_peel.png", "bumpscale": 0.008}}


def glass(ior):
    """Return a material of smooth glass or water."""
    return {"bsdf": {"type": "dielectric", "ior": round(ior, 6)}}


def room():
    """Return the table and the wall behind it."""
    planks = {"bsdf": {"type": "principled", "basecolor": "textures/planks.jpg", "roughness": 0.45, "specular": 0.4},
              "normalmap": "textures/planks_normals.jpg", "scaleU": 2}
    plastered = {"bsdf": {"type": "diffuse", "reflectance": [0.66, 0.60, 0.52]}, "bumpmap": "textures/plaster.png",
                 "bumpscale": 0.1, "scaleU": 4, "scaleV": 3}
    return [{"type": "rectangle", "center": [0, 0, -0.5], "u": [12, 0, 0], "v": [0, 0, -7], "material": planks},
            {"type": "rectangle", "center": [0, 3, 3], "u": [16, 0, 0], "v": [0, -12, 0], "material": plastered}]


def filled_carafe(x, z):
    """Return the carafe with its water."""
    level = {"type": "disk", "center": [x, LIFT + LEVEL, z], "normal": [0, 1, 0],
             "radius": round(float(carafe()[1][0, 0]), 4), "material": glass(WATER)}
    return [mesh("carafe", [x, LIFT, z], glass(GLASS)), mesh("carafe_wet", [x, LIFT, z], glass(GLASS / WATER)), level]


def filled_bowl(x, z):
    """Return the bowl and three oranges in it."""
    glazed = {"type": "principled", "basecolor": "textures/glaze.jpg", "roughness": 0.3, "clearcoat": 0.6}
    places = ((-0.30, 0.66, -0.23, 0.40), (0.39, 0.68, -0.10, 0.41), (-0.03, 0.70, 0.51, 0.42))
    return [mesh("bowl", [x, LIFT, z], {"bsdf": glazed}),
            *(fruit(round(x + dx, 3), y, round(z + dz, 3), radius) for dx, y, dz, radius in places)]


def scene():
    """Return the scene as the text of a file."""
    peel = {"bsdf": {"type": "principled", "basecolor": [0.86, 0.62, 0.06], "roughness": 0.4},
            "bumpmap": "textures/orange_peel.png", "bumpscale": 0.006}
    lying = {"rotate": {"axis": [0, 0, 1], "angle": 90}}, {"rotate": {"axis": [0, 1, 0], "angle": -28}}
    shapes = [*room(), *window(), sun(), *filled_carafe(1.25, 0.35), *filled_bowl(-0.75, 0.15),
              mesh("vase", [-1.97, LIFT, 1.55], {"bsdf": {"type": "roughconductor", **BRASS, "alpha": 0.16}}),
              mesh("lemon", [0.62, 0.357, -1.0], peel, *lying)]
    sky = {"type": "arealight", "position": [-130, 55, -60], "u": [0, 110, 0], "v": [0, 0, 180], "twosided": False,
           "intensity": [2.1, 2.9, 4.1]}
    camera = {"type": "thinlens", "width": 900, "height": 600, "fov": 27, "position": [0.65, 2.5, -8.5],
              "lookAt": [0.2, 1.12, 0.5], "apertureRadius": 0.07, "focusDistance": 8.9, "exposure": 0.12}
    return text({"rendermode": "pathtracer", "samples": 384, "nbounces": 14, "filter": "gaussian", "tonemap": "filmic",
                 "camera": camera, "scene": {"backgroundcolor": [0.13, 0.15, 0.19], "lightsources": [sky],
                                             "shapes": shapes}})


def main():
    """Write everything."""
    (FOLDER / "meshes" / "morning").mkdir(exist_ok=True)
    for name, content in meshes().items():
        (FOLDER / "meshes" / "morning" / name).write_bytes(content)
    for name, picture in textures().items():
        options = {"quality": QUALITY} if name.endswith(".jpg") else {"optimize": True}
        picture.save(FOLDER / "textures" / name, **options)
    (FOLDER / "morning.json").write_text(scene())


if __name__ == "__main__":
    main()
