"""Parts of the renderer left out or replaced while a kernel is recorded, where the program has no switch for them."""

from __future__ import annotations

from contextlib import contextmanager, nullcontext
from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, Vector3f
from renderer.engine import render
from renderer.integrators import path, phong
from renderer.scene import light_choice
from renderer.scene.compiled import CompiledScene


@dataclass
class Direction:
    """The camera ray of each lane."""

    d: Vector3f


class Looking:
    """An integrator that returns the direction of the camera's ray, whatever is there."""

    looks_ahead = uneven = False

    def __init__(self, scene, bounces):
        pass

    def start(self, lanes):
        """Return lanes without a ray."""
        return Direction(dr.zeros(Vector3f, lanes))

    def restart(self, state, where, o, d):
        """Return the state with fresh camera rays in the lanes `where`."""
        return dr.select(where, Direction(d), state)

    def step(self, state, draws):
        """Return the direction; no lane goes on."""
        return state.d, Bool(False), state


class Nothing(Looking):
    """An integrator that needs no ray; the camera is left out of the kernel."""

    def restart(self, state, where, o, d):
        """Return the state."""
        return state


def _ambient(self, hit, surface, material, *_):
    """Return what is left of local colour without lights."""
    return self._scene.ambient * self._scene.diffuse_colour(hit, surface, material)


def _met(path, pdf_sa):
    """Return the weight of light that a path ran into where lights are left to be sampled."""
    return dr.select((path.pdf_sa > 0) & (pdf_sa > 0), 0, Float(1))


def _alike(middles, lights, by_power):
    """Return (cells, lights) weights that are the same in all cells."""
    import numpy as np

    power = np.array([light.strength if by_power else 1.0 for light in lights])
    return np.broadcast_to(power / power.sum(), (len(middles), len(lights))).copy()


PATCHES = {  # (module or class, name): what takes its place
    "": {},
    "camera alone": {(render, "integrator_of"): lambda mode: Looking},
    "no camera": {(render, "integrator_of"): lambda mode: Nothing},
    "ambient alone": {(phong.Phong, "_local"): _ambient},
    "no highlight": {(phong, "highlight"): lambda *_: Float(0)},
    "no shadows": {(CompiledScene, "occluded"): lambda *_: Bool(False)},
    "BSDFs alone": {(path, "_light_share"): lambda *_: Float(0), (path, "_weight"): lambda *_: Float(1)},
    "early roulette": {(path, "ROULETTE_DEPTH"): 1},
    "lights by power": {(light_choice, "_cell_weights"): lambda lights, middles, _: _alike(middles, lights, True)},
    "lights alike": {(light_choice, "_cell_weights"): lambda lights, middles, _: _alike(middles, lights, False)},
    "lights alone": {(path, "_light_share"): lambda *_: Float(1), (path, "_weight"): _met},
}


def patched(name):
    """Return a context in which the patch of this name is in force."""
    return _replaced(PATCHES[name]) if PATCHES[name] else nullcontext()


@contextmanager
def _replaced(things):
    """Replace attributes for a while."""
    before = {(owner, name): vars(owner).get(name) for owner, name in things}
    try:
        for (owner, name), thing in things.items():
            setattr(owner, name, thing)
        yield
    finally:
        for (owner, name), thing in before.items():
            delattr(owner, name) if thing is None else setattr(owner, name, thing)
