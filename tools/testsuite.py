"""`python -m tools.testsuite`: render what is handed in under TestSuite/.

The coursework's pictures as PPM at full size, a contact sheet of them beside Mitsuba's pictures and the difference
of the two, the same sheet for the smallest scene of every feature, and the Utah teapot.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from renderer.core.errors import SceneError
from renderer.engine.render import render
from renderer.io.image import write_png, write_ppm
from renderer.scene.loader import load, override

ROOT = Path(__file__).resolve().parent.parent
PICTURES = {  # name in TestSuite/: scene and render mode
    "binary_primitives": ("binary_primitives", "binary"),
    "simple_phong": ("simple_phong", "phong"),
    "scene_binary": ("scene", "binary"),
    "scene_phong": ("scene", "phong"),
    "mirror_image": ("mirror_image", "phong"),
}
CELL = 300, 200  # pixels of one picture on a sheet
CAPTION = 14  # pixels below it
TEAPOT_SAMPLES = 16  # rays a pixel
DIFFERENCE_GAIN = 20  # a difference of 1/20 of white is white


def ours_and_mitsubas(loaded):
    """Return our picture and Mitsuba's, (height, width, 3) in [0, 1] as they are shown, of a loaded scene."""
    from converters.whitted import reference

    rendering = render(loaded)
    ours = np.frombuffer(rendering.rgb8(), np.uint8).reshape(rendering.height, rendering.width, 3) / 255
    mode = loaded.description.rendermode
    theirs = reference(loaded)
    if mode == "phong":
        return ours, shown(theirs["rgb"], loaded.description)
    return ours, {"binary": lambda: theirs["rgb"], "depth": lambda: depth_picture(theirs),
                  "normals": lambda: np.where(theirs["hit"][..., None], 0.5 + 0.5 * theirs["normal"], 0),
                  "uv": lambda: uv_picture(theirs), "albedo": lambda: theirs["albedo"],
                  "shapes": lambda: shape_picture(theirs, ours)}[mode]()  # fmt: skip


def shown(radiance, description):
    """Return linear radiance as a picture in [0, 1], by the formulae of the tone curves."""
    x = radiance * description.camera.exposure / 0.1
    if description.tonemap == "reinhard":
        x = x / (1 + x)
    elif description.tonemap == "filmic":
        x = (2.51 * x**2 + 0.03 * x) / (2.43 * x**2 + 0.59 * x + 0.14)
    return np.round(255 * np.clip(x, 0, 1)) / 255  # as coarse as ours, or the difference would show rounding


def depth_picture(theirs):
    """Return near as white and far as dark."""
    near, far = theirs["depth"][theirs["hit"]].min(), theirs["depth"][theirs["hit"]].max()
    grey = 1 - 0.9 * (theirs["depth"] - near) / max(far - near, 1e-9)
    return np.where(theirs["hit"], grey, 0)[..., None].repeat(3, axis=-1)


def uv_picture(theirs):
    """Return the fractions of u and v as red and green."""
    picture = np.zeros((*theirs["hit"].shape, 3))
    picture[..., :2] = np.where(theirs["hit"][..., None], theirs["uv"] - np.floor(theirs["uv"]), 0)
    return picture


def shape_picture(theirs, ours):
    """Return Mitsuba's shape numbers in the colours that ours have for the same numbers most often."""
    picture = np.zeros_like(ours)
    for number in np.unique(theirs["shape"][theirs["hit"]]):
        where = theirs["shape"] == number
        colours, counts = np.unique(ours[where].reshape(-1, 3), axis=0, return_counts=True)
        picture[where] = colours[counts.argmax()]
    return picture


def small(picture):
    """Return a picture in [0, 1] as an image of one cell."""
    return Image.fromarray(np.uint8(np.round(255 * np.clip(picture, 0, 1)))).resize(CELL, Image.Resampling.BOX)


def sheet(rows, columns):
    """Return a contact sheet: `columns` triples of ours, Mitsuba's and the difference side by side.

    `rows` is a list of (caption, our picture, Mitsuba's picture).
    """
    width, height = 3 * CELL[0] + 6, CELL[1] + CAPTION
    lines = -(-len(rows) // columns)
    page = Image.new("RGB", (columns * (width + 8), lines * (height + 6)), "white")
    draw = ImageDraw.Draw(page)
    for number, (caption, ours, theirs) in enumerate(rows):
        x, y = number % columns * (width + 8), number // columns * (height + 6)
        for place, picture in enumerate((ours, theirs, DIFFERENCE_GAIN * np.abs(ours - theirs))):
            page.paste(small(picture), (x + place * (CELL[0] + 3), y))
        draw.text((x + 2, y + CELL[1] + 1), f"{caption}: ours, Mitsuba, difference x {DIFFERENCE_GAIN}", fill="black")
    return page


def save(page, path):
    """Write a contact sheet as PNG."""
    write_png(path, page.tobytes(), *page.size)
    print(path)


def coursework(folder):
    """Write the coursework's pictures at full size and their contact sheet."""
    rows = []
    for name, (scene, mode) in PICTURES.items():
        loaded = override(load(str(ROOT / "scenes" / f"{scene}.json")), mode=mode)
        rendering = render(loaded)
        write_ppm(folder / f"{name}.ppm", rendering.rgb8(), rendering.width, rendering.height)
        print(folder / f"{name}.ppm")
        rows.append((name, *ours_and_mitsubas(override(loaded, width=2 * CELL[0], height=2 * CELL[1]))))
    save(sheet(rows, 1), folder / "contact_sheet.png")


def antialiased(folder):
    """Write a picture with one ray a pixel beside the same with many."""
    scene = load(str(ROOT / "scenes" / "features" / "samples.json"))
    pair = [render(picture) for picture in (override(scene, samples=1), scene)]
    page = Image.new("RGB", (2 * pair[0].width + 3, pair[0].height), "white")
    for number, picture in enumerate(pair):
        page.paste(Image.frombytes("RGB", (picture.width, picture.height), picture.rgb8()), (number * (picture.width + 3), 0))
    save(page, folder / "antialiased.png")


def teapot(folder):
    """Write the teapot scene at full size."""
    picture = render(override(load(str(ROOT / "scenes" / "teapot.json")), samples=TEAPOT_SAMPLES))
    write_png(folder / "teapot.png", picture.rgb8(), picture.width, picture.height)
    print(folder / "teapot.png")


def features(folder):
    """Write the contact sheet of the smallest scene of every feature."""
    rows = []
    for path in sorted((ROOT / "scenes" / "features").glob("*.json")):
        loaded = override(load(str(path)), width=CELL[0], height=CELL[1], samples=1)  # the reference takes one ray
        rows.append((path.stem, *ours_and_mitsubas(loaded)))
    save(sheet(rows, 2), folder / "features.png")


def main(arguments=None):
    """Render into TestSuite/, or into the folder that is given; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.testsuite", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "TestSuite")
    folder = parser.parse_args(arguments).folder
    folder.mkdir(parents=True, exist_ok=True)
    try:
        coursework(folder)
        features(folder)
        antialiased(folder)
        teapot(folder)
    except SceneError as error:
        print(error)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
