"""The scenes of the benchmark `needs`: the coursework's in mode `phong`, and the path-traced ones."""

from __future__ import annotations

import json
from functools import partial

from benchmarks import path_scenes
from benchmarks.measure import ROOT
from benchmarks.scenes import COURSEWORK

SMALLER = 3  # times smaller than the effort's pictures on each side, and as many times fewer samples


def phong(name, folder):
    """Return a scene of the coursework."""
    return json.loads((ROOT / "scenes" / f"{name}.json").read_text()) | {"rendermode": "phong"}


SCENES = {name: partial(phong, name) for name in COURSEWORK} | path_scenes.SCENES


def document(name, folder, effort):
    """Return the document of a scene at the benchmark's size; what it names lies in `folder`."""
    made = SCENES[name](folder) | {"mirrorlight": False, "samples": max(effort.samples // SMALLER, 2)}
    made["camera"] |= {"width": max(effort.width // SMALLER, 1), "height": max(effort.height // SMALLER, 1)}
    return made
