"""Scenes of our own as TestSuite/ shows them, what they consist of, and what rendering them takes."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from renderer.engine.render import render, set_up
from renderer.scene.loader import load, override
from tools import testsuite
from tools.report import pairs, results

SCENES = "lanterns", "morning", "nautilus", "poster", "reflections"
FEW, MORE = 2, 8  # samples: what the difference takes is that of a sample, once kernels are there


def make(folder: Path) -> dict[str, str | list]:
    """Copy the pictures, and return size, samples, bounces, shapes, triangles and CPU time of each."""
    told = {}
    for scene in SCENES:
        shutil.copy(results.ROOT / "TestSuite" / f"{scene}.jpg", folder / f"{scene}.jpg")
        told |= {f"{scene}_{key}": value for key, value in facts(scene).items()}
    return told


def facts(scene):
    """Return what is told of a scene: its size, what it consists of, samples, and the CPU time of all of them."""
    loaded = load(str(results.ROOT / "scenes" / f"{scene}.json"))
    description = loaded.description
    few, more = (seconds(loaded, samples) for samples in (FEW, MORE))
    whole = few + (more - few) * (description.spp - FEW) / (MORE - FEW)
    return {"size": f"{description.camera.width} × {description.camera.height}", "samples": str(description.spp),
            "bounces": str(description.nbounces), "shapes": f"{len(loaded.shapes):,}",
            "time": results.unit(whole, "s", 1), "triangles": f"{triangles_of(loaded):,}",
            "finish": "denoised" if scene in testsuite.DENOISED else "as rendered"}  # fmt: skip


@pairs.slow(lambda loaded: 1000)
def triangles_of(loaded):
    """Return how many triangles lie in a scene's meshes."""
    found = set_up(loaded)[0].triangles
    return found.count if found else 0


@pairs.slow(lambda loaded, samples: samples / 10)
def seconds(loaded, samples):
    """Return the CPU seconds of all threads for a picture of so many samples a pixel."""
    begun = time.process_time()
    render(override(loaded, samples=samples)).rgb8()
    return time.process_time() - begun
