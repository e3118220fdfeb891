"""Only what a scene needs is compiled into its kernel: what that is, and what it is worth.

Each scene is rendered as it is, and with inert things of every kind added that do not change its picture
(`inert.py`): every kind of shape, light, material, texture, an image around everything, and a lens. These cost not only
code: rays are tested against up to 20 more shapes, and there are more lights to choose from or to cast shadows to. With
a mesh as well, shapes are found through a hierarchy, as in any scene that has one; scenes that have a hierarchy by
themselves are measured with that alone.

What a kernel has is asked of the compiled scene. Operations are Dr.Jit's, code is what LLVM is given, both of the
largest kernel; compiling is the time for all kernels of a picture in a process with an empty cache. Time is CPU time of
a render after that, without building the scene, in turns. Means apart: root mean square difference of blocks of pixels
to those of the scene as it is, in standard errors; if the two are not the same picture, measuring ends. Ways over
mirrors to lamps (`mirrorlight`) are off: there are none with a hierarchy.
"""

from __future__ import annotations

import json
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks import inert, needs_worker
from benchmarks.measure import BenchmarkError, interleaved, result, run_process, spread
from benchmarks.needs_scenes import SCENES, document
from benchmarks.needs_worker import Picture, compiled_in
from renderer.scene import loader

TAKEN_APART = ("simple_phong", "Cornell box, glass and mirror")  # for which each part is added alone
STARTS = 3  # processes with an empty cache
SEEDS = 4  # pictures that are compared
BLOCK = 10  # pixels: sides of blocks whose means are compared
MOST_APART = 3.0  # standard errors between the means of blocks; about 1 is noise
FAINT = 1e-4  # share of the mean by which blocks may differ in any case
REPEATS = 5  # at most
AS_IT_IS, EVERYTHING, WITH_MESH = "nothing else", "everything", "everything and a mesh"
VARIANTS = {AS_IT_IS: (), EVERYTHING: inert.PARTS, WITH_MESH: (*inert.PARTS, inert.MESH)}
ALONE = {AS_IT_IS: ()} | {part: (part,) for part in (*inert.PARTS, inert.MESH)}


def measure(effort):
    """Return what the kernels of the scenes contain, and what they would cost with everything in them."""
    names = [name for name in SCENES if not effort.scenes or name in effort.scenes]
    tables = {"what is compiled in": [], "kernels": [], "each part alone": []}
    for name in names:
        print(f"  {name}", file=sys.stderr)
        with tempfile.TemporaryDirectory() as folder:
            has, rows = of_scene(name, Path(folder), effort, VARIANTS)
            tables["what is compiled in"].append(has)
            tables["kernels"] += rows
            if name in TAKEN_APART:
                tables["each part alone"] += of_scene(name, Path(folder), effort, ALONE)[1]
    return result([], **tables)


def of_scene(name, folder, effort, variants):
    """Return what a scene's own kernel has, and the rows of {variant: parts that are added}; the first adds none."""
    plain = document(name, folder, effort)
    documents = {variant: inert.with_parts(plain, folder, parts) for variant, parts in variants.items()}
    pictures = {variant: Picture(loader.from_dict(made, directory=folder)) for variant, made in documents.items()}
    own = pictures[AS_IT_IS]
    if own.scene.structure is not None:  # the scene has a mesh, or as many shapes as need a hierarchy
        pictures.pop(EVERYTHING, None)
    times = interleaved({variant: partial(picture.render, 1) for variant, picture in pictures.items()},
                        min(effort.repeats, REPEATS))  # fmt: skip
    rows = []
    for variant, picture in pictures.items():
        cold, far = _cold(documents[variant], folder), same_picture(own, picture) if picture is not own else None
        if far and far > MOST_APART:
            raise BenchmarkError(f"{name}, {variant}: another picture, {far:.1f} standard errors away")
        ratios = [time / base for time, base in zip(times[variant], times[AS_IT_IS])]
        rows.append({"scene": name, "with": variant, **cold, "CPU time (s)": spread(times[variant]),
                     "time, x as it is": spread(ratios), "means apart": far})  # fmt: skip
    return {"scene": name} | compiled_in(own), rows


def same_picture(one, other):
    """Return how far apart two Pictures are, in standard errors of the difference of their blocks' means.

    The root mean square over blocks; 1 is what noise gives, and 0 what rounding gives where there is no noise.
    """
    sides = [np.array([_blocks(picture.render(seed)) for seed in range(SEEDS)]) for picture in (one, other)]
    means = [side.mean(axis=0) for side in sides]
    noise = sum(side.var(axis=0, ddof=1) / SEEDS for side in sides)
    # seeds are few: the noise of dim blocks is pooled with that of all
    scale = noise + noise.mean() + (FAINT * (means[0] + means[1]).mean()) ** 2
    return float(np.sqrt(np.mean((means[0] - means[1]) ** 2 / scale)))


def _blocks(picture):
    """Return the means of square blocks of an (H, W, 3) picture."""
    height, width, _ = picture.shape
    rows, columns = max(height // BLOCK, 1), max(width // BLOCK, 1)
    cut = picture[: height // rows * rows, : width // columns * columns]
    return cut.reshape(rows, height // rows, columns, width // columns, 3).mean(axis=(1, 3))


def _cold(made, folder):
    """Return what a process with an empty cache tells of a document's kernels, its times as spreads."""
    path = folder / "cold.json"
    path.write_text(json.dumps(made))
    told = []
    for _ in range(STARTS):
        with tempfile.TemporaryDirectory() as cache:
            output = run_process("-m", needs_worker.__name__, path, DRJIT_CACHE_DIR=cache).output
            told.append(json.loads(output))
    return told[0] | {"compile (s)": spread([one["compile (s)"] for one in told])}
