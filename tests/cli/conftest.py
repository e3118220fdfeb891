"""A smallest scene, the real command line in a process of its own, and a stand-in for the engine.

The stand-in is for what a real render cannot be made to do on demand: fail, run out of memory, block.
"""

import copy
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from renderer import cli

ROOT = Path(__file__).parents[2]
SCENE = {
    "nbounces": 2,
    "rendermode": "phong",
    "camera": {"type": "pinhole", "width": 6, "height": 4, "position": [0, 0, 0], "lookAt": [0, 0, 1],
               "upVector": [0, 1, 0], "fov": 45, "exposure": 0.1},
    "scene": {
        "backgroundcolor": [0.25, 0.25, 0.25],
        "lightsources": [{"type": "pointlight", "position": [0, 1, 0], "intensity": [1, 1, 1]}],
        "shapes": [{"type": "sphere", "center": [0, 0, 1], "radius": 0.3}],
    },
}


class StandInPicture:
    """What the engine returns, with pixels that tell their place."""

    def __init__(self, loaded):
        camera = loaded.description.camera
        self.width, self.height = camera.width, camera.height
        self.samples, self.mode, self.lost = loaded.description.spp, loaded.description.rendermode, None
        self.timings = SimpleNamespace(build=0.02, compile=0.0, render=0.03)
        self.samples_per_second = 32e6
        self.graded = []

    def rgb8(self, tonemap=None, exposure=None, encoding=None):
        self.graded.append((tonemap, exposure, encoding))
        return bytes(index % 256 for index in range(self.width * self.height * 3))

    def channels(self, beside=False):
        return {name: np.full((self.height, self.width), value, np.float32) for value, name in enumerate("RGB")}


@pytest.fixture
def document():
    """A copy of the smallest scene, to be changed at will."""
    return copy.deepcopy(SCENE)


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """The path of a smallest scene, in the current folder of the test."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.json").write_text(json.dumps(SCENE))
    return "small.json"


@pytest.fixture
def engine(monkeypatch):
    """A stand-in engine: `calls` records what it was asked, `render` may be replaced."""
    stand_in = SimpleNamespace(calls=[], accels=[], limits=[], loaded=[], pictures=[], render=None)

    def render(loaded, *, seed=0, accel="auto", until=None, variance=False, progress=None, interrupted=None):
        stand_in.limits.append((until, variance))
        stand_in.calls.append((loaded, seed))
        stand_in.accels.append(accel)
        if stand_in.render is not None:
            return stand_in.render(loaded, seed=seed, progress=progress, interrupted=interrupted)
        stand_in.pictures.append(StandInPicture(loaded))
        return stand_in.pictures[-1]

    def load(backend, threads):
        stand_in.loaded.append((backend, threads))
        return render

    monkeypatch.setattr(cli, "_load_engine", load)
    return stand_in


@pytest.fixture
def start():
    """Start `python -m renderer` as the user would, in the current folder; returns the process."""
    def start_renderer(*arguments, **options):
        return subprocess.Popen([sys.executable, "-m", "renderer", *arguments], stderr=subprocess.PIPE,
                                **with_renderer(options))

    return start_renderer


@pytest.fixture
def run_python():
    """Run a program that can import the renderer; returns the finished process with its output."""
    def run(code, *arguments, **options):
        return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True,
                              **with_renderer(options))

    return run


def with_renderer(options):
    """Return the options of a process with an environment in which the renderer is found."""
    environment = {name: value for name, value in os.environ.items() if name != "RENDERER_DEBUG"}
    return options | {"env": environment | {"PYTHONPATH": str(ROOT)} | options.get("env", {})}


@pytest.fixture
def interruptible():
    """Start a command to which Ctrl-C means what it does on a terminal, whatever the tests were started with."""
    def start_command(*command, **options):
        return subprocess.Popen(["env", "--default-signal=INT", *command], stderr=subprocess.PIPE,
                                **with_renderer(options))

    return start_command
