"""`python -m tools.guide [N]`: the steps of README.md's guide to the scene format, and their pictures.

With a number, the whole file of that step is printed. Without, all steps are rendered as they say, and written to
docs/guide: `steps.jpg`, all of them small, and `last.jpg`. README.md is the only place where the steps are kept: each
shows what is new, where keys replace those of earlier steps and shapes come after earlier shapes.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import re
from pathlib import Path

from scenes import making

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
FOLDER = ROOT / "docs" / "guide"
JSON_BLOCK = re.compile(r"^```json\n(.*?)^```", re.DOTALL | re.MULTILINE)
SCENES = ROOT / "scenes"  # stands in for the reader's folder beside it: both find the same files
HOLDERS = ("camera", "scene")  # objects of which a step changes single keys
GROWING = "shapes"  # the list to which a step adds
CELL = 300, 200  # pixels of a small picture
COLUMNS, GAP = 4, 4  # small pictures side by side, and pixels between them
QUALITY = 90  # of JPEG files: noise would make a PNG file many times as large


def written(text: str | None = None) -> list[str]:
    """Return the JSON of each step as README.md (or the given text) shows it."""
    return JSON_BLOCK.findall(README.read_text(encoding="utf-8") if text is None else text)


def steps(text: str | None = None) -> list[dict]:
    """Return the whole document of each step."""
    documents = [{}]
    for block in written(text):
        documents.append(grown(documents[-1], json.loads(block)))
    return documents[1:]


def grown(document: dict, new: dict) -> dict:
    """Return a document with what a step adds; neither is changed."""
    result = dict(document)
    for key, value in new.items():
        if key in HOLDERS:
            result[key] = grown(result.get(key, {}), value)
        elif key == GROWING:
            result[key] = [*result.get(key, []), *value]
        else:
            result[key] = value
    return result


def rendered(document: dict, **settings):
    """Return the picture of a scene as an image; settings are those of `loader.override`."""
    from PIL import Image

    from renderer.engine.render import render
    from renderer.scene.loader import from_dict, override

    picture = render(override(from_dict(document, directory=SCENES, strict=True), **settings))
    return Image.frombytes("RGB", (picture.width, picture.height), bytes(picture.rgb8()))


def digest(documents: list[dict]) -> str:
    """Return a digest of all steps, which pictures carry as a comment: so a test finds them out of date."""
    return hashlib.sha256(json.dumps(documents, sort_keys=True).encode()).hexdigest()[:16]


def place(number: int) -> tuple[int, int]:
    """Return the left upper corner in `steps.jpg` of a step, counted from 0."""
    return number % COLUMNS * (CELL[0] + GAP), number // COLUMNS * (CELL[1] + GAP)


def page(pictures):
    """Return all pictures small and numbered on one page."""
    from PIL import Image, ImageDraw, ImageFont

    last = place(COLUMNS * math.ceil(len(pictures) / COLUMNS) - 1)
    sheet = Image.new("RGB", (last[0] + CELL[0], last[1] + CELL[1]), "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(22)
    for number, picture in enumerate(pictures):
        x, y = place(number)
        sheet.paste(picture.resize(CELL, Image.Resampling.BOX), (x, y))
        draw.text((x + 8, y + 4), str(number + 1), fill="white", font=font, stroke_width=2, stroke_fill="black")
    return sheet


def main(arguments=None):
    """Print a step or write the pictures; return the exit status."""
    documents = steps()
    parser = argparse.ArgumentParser(prog="python -m tools.guide", description=__doc__)
    parser.add_argument("number", nargs="?", type=int, choices=range(1, len(documents) + 1),
                        help="print the file of this step")
    options = parser.parse_args(arguments)
    if options.number:
        print(making.text(documents[options.number - 1]), end="")
        return 0
    pictures = [rendered(document) for document in documents]
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, picture in (("steps", page(pictures)), ("last", pictures[-1])):
        picture.save(FOLDER / f"{name}.jpg", quality=QUALITY, comment=digest(documents))
        print(FOLDER / f"{name}.jpg")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
