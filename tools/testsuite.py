"""`python -m tools.testsuite`: render what is handed in under TestSuite/.

The coursework's pictures as PPM at full size, a contact sheet of them beside Mitsuba's pictures and the difference
of the two, the same sheets for the smallest scene of every feature, the Utah teapot, path-traced pictures, and scenes
of our own. Everything takes some minutes; names of groups after the folder (see GROUPS) render these only.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from converters.mitsuba.srgb import encoded
from renderer.core.errors import SceneError, UsageError
from renderer.engine.render import render
from renderer.io.image import write_png, write_ppm
from renderer.scene.loader import load, override
from renderer.scene.schema import PATHTRACER

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
PATH_TRACED = {"scene_pathtracer": 512, "cornell": 1024, "studio": 512}  # scene and samples a pixel
OWN = ("morning", "poster", "lanterns", "nautilus", "reflections")  # as their files say, to JPEG
DENOISED = ("morning",)  # of these: caustics of glass in the sun are found by chance
SHEET_SAMPLES = 128  # a pixel of path-traced pictures on a sheet
SHEET_SIZE = 240, 160  # pixels of these pictures
BLOCK = 8  # pixels along the sides of the squares whose means are compared, as noise decides about single pixels
NOISY_SAMPLES = 16  # a pixel of the picture that is denoised
COMPARED = "450x300"  # pixels of pictures that are compared
QUALITY = 90  # of JPEG files: noise would make a PNG file ten times as large


def ours_and_mitsubas(loaded):
    """Return our picture and Mitsuba's, (height, width, 3) in [0, 1] as they are shown, of a loaded scene."""
    from converters.whitted import reference

    ours = picture_of(render(loaded))
    mode = loaded.description.rendermode
    theirs = reference(loaded)
    if mode == "phong":
        return ours, coarse(toned(theirs["rgb"], loaded.description))
    return ours, {"binary": lambda: theirs["rgb"], "depth": lambda: depth_picture(theirs),
                  "normals": lambda: np.where(theirs["hit"][..., None], 0.5 + 0.5 * theirs["normal"], 0),
                  "uv": lambda: uv_picture(theirs), "albedo": lambda: theirs["albedo"],
                  "shapes": lambda: shape_picture(theirs, ours)}[mode]()  # fmt: skip


def path_traced_twice(loaded):
    """Return our picture and that of Mitsuba's path integrator, as `ours_and_mitsubas` does, with equal samples."""
    from converters.path_traced import reference

    return picture_of(render(loaded)), coarse(encoded(toned(reference(loaded), loaded.description)))


def picture_of(rendering):
    """Return a Rendering as (height, width, 3) in [0, 1]."""
    return np.frombuffer(rendering.rgb8(), np.uint8).reshape(rendering.height, rendering.width, 3) / 255


def toned(radiance, description):
    """Return linear radiance as a picture in [0, 1], by the formulae of the tone curves."""
    x = radiance * description.camera.exposure / 0.1
    if description.tonemap == "reinhard":
        x = x / (1 + x)
    elif description.tonemap == "filmic":
        x = (2.51 * x**2 + 0.03 * x) / (2.43 * x**2 + 0.59 * x + 0.14)
    return np.clip(x, 0, 1)


def coarse(picture):
    """Return a picture as coarse as ours, or the difference would show rounding."""
    return np.round(255 * picture) / 255


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


def image_of(picture):
    """Return a picture as an image; what is not in [0, 1] is clipped."""
    return Image.fromarray(np.uint8(np.round(255 * np.clip(picture, 0, 1))))


def small(picture):
    """Return a picture in [0, 1] as an image of one cell."""
    return image_of(picture).resize(CELL, Image.Resampling.BOX)


def blocks(difference):
    """Return (height, width, 3) differences with the mean of its square, BLOCK pixels wide, in place of each pixel."""
    height, width = (size // BLOCK for size in difference.shape[:2])
    squares = difference[: height * BLOCK, : width * BLOCK].reshape(height, BLOCK, width, BLOCK, 3)
    return squares.mean((1, 3)).repeat(BLOCK, 0).repeat(BLOCK, 1)


def sheet(rows, columns, evened=lambda difference: difference):
    """Return a contact sheet: `columns` triples of ours, Mitsuba's and the difference side by side.

    `rows` is a list of (caption, our picture, Mitsuba's picture); `evened` is done to differences first.
    """
    width, height = 3 * CELL[0] + 6, CELL[1] + CAPTION
    lines = -(-len(rows) // columns)
    page = Image.new("RGB", (columns * (width + 8), lines * (height + 6)), "white")
    draw = ImageDraw.Draw(page)
    for number, (caption, ours, theirs) in enumerate(rows):
        x, y = number % columns * (width + 8), number // columns * (height + 6)
        difference = DIFFERENCE_GAIN * np.abs(evened(ours - theirs))
        for place, picture in enumerate((ours, theirs, difference)):
            page.paste(small(picture), (x + place * (CELL[0] + 3), y))
        draw.text((x + 2, y + CELL[1] + 1), f"{caption}: ours, Mitsuba, difference x {DIFFERENCE_GAIN}", fill="black")
    return page


def save(page, path):
    """Write a contact sheet, as PNG or as JPEG."""
    if path.suffix == ".jpg":
        page.save(path, quality=QUALITY)
    else:
        write_png(path, page.tobytes(), *page.size)
    print(path)


def beside(pictures):
    """Return pictures of equal size, (height, width, 3) in [0, 1], side by side."""
    height, width = pictures[0].shape[:2]
    page = Image.new("RGB", (len(pictures) * (width + 3) - 3, height), "white")
    for number, picture in enumerate(pictures):
        page.paste(image_of(picture), (number * (width + 3), 0))
    return page


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
    pictures = [picture_of(render(each)) for each in (override(scene, samples=1), scene)]
    save(beside(pictures), folder / "antialiased.png")


def shown(folder, name, samples):
    """Write a scene at full size."""
    picture = render(override(load(str(ROOT / "scenes" / f"{name}.json")), samples=samples))
    write_png(folder / f"{name}.png", picture.rgb8(), picture.width, picture.height)
    print(folder / f"{name}.png")


def phong(folder):
    """Write the teapot, soft shadows with blurred mirrors, and lights that are no points."""
    shown(folder, "teapot", TEAPOT_SAMPLES)
    shown(folder, "soft_shadows", None)
    shown(folder, "phong_lights", None)


def path_traced(folder):
    """Write our path-traced scenes, and a noisy one beside what the denoiser makes of it."""
    for name, samples in PATH_TRACED.items():
        shown(folder, name, samples)
    from renderer.denoise import denoised

    noisy = render(override(load(str(ROOT / "scenes" / "studio.json")), samples=NOISY_SAMPLES))
    try:
        save(beside([picture_of(noisy), picture_of(denoised(noisy))]), folder / "denoised.jpg")
    except UsageError as error:
        print(f"{folder / 'denoised.jpg'} stays as it is: {error}")


def own(folder):
    """Write the scenes of our own; where the denoiser is missing, those that need it stay as they are."""
    from renderer.denoise import denoised
    from renderer.denoise import load as load_denoiser

    for name in OWN:
        try:
            if name in DENOISED:
                load_denoiser()
        except UsageError as error:
            print(f"{folder / name}.jpg stays as it is: {error}")
            continue
        picture = render(load(str(ROOT / "scenes" / f"{name}.json")))
        picture = denoised(picture) if name in DENOISED else picture
        save(beside([picture_of(picture)]), folder / f"{name}.jpg")


def features(folder):
    """Write the contact sheets of the smallest scene of every feature, path-traced ones on one of their own."""
    rows, paths = [], []
    for path in sorted((ROOT / "scenes" / "features").glob("*.json")):
        loaded = load(str(path))
        if loaded.description.rendermode == PATHTRACER:
            loaded = override(loaded, width=SHEET_SIZE[0], height=SHEET_SIZE[1], samples=SHEET_SAMPLES)
            paths.append((path.stem, *path_traced_twice(loaded)))
        else:
            loaded = override(loaded, width=CELL[0], height=CELL[1], samples=1)  # the reference takes one ray
            rows.append((path.stem, *ours_and_mitsubas(loaded)))
    save(sheet(rows, 2), folder / "features.png")
    save(sheet(paths, 2, blocks), folder / "paths.jpg")


def compared(folder):
    """Write what `compare` shows of a picture without mirrors beside the right one."""
    from renderer import cli

    scene, path = str(ROOT / "scenes" / "scene.json"), folder / "compared.png"
    with tempfile.TemporaryDirectory() as work:
        pictures = [f"{work}/{name}.ppm" for name in ("wrong", "right")]
        for picture, options in zip(pictures, (["--bounces", "0"], [])):
            cli.main([scene, "--quiet", "--size", COMPARED, *options, "-o", picture])
        cli.main(["compare", *pictures, "--encoding", "linear", "-o", str(path)])
    print(path)


GROUPS = {"coursework": coursework, "features": features, "antialiased": antialiased, "phong": phong,
          "path_traced": path_traced, "own": own, "compared": compared}


def main(arguments=None):
    """Render into TestSuite/, or into the folder that is given; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.testsuite", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "TestSuite")
    parser.add_argument("groups", nargs="*", choices=[[], *GROUPS], help="what is rendered; absent: everything")
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    try:
        for name in options.groups or GROUPS:
            GROUPS[name](options.folder)
    except SceneError as error:
        print(error)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
