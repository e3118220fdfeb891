"""Both sides of a comparison of path-traced pictures: batches of ours and of Mitsuba's, and small scenes for them."""

from __future__ import annotations

import functools
import json
import zlib
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from converters import mitsuba as export
from renderer.core.backend import Float
from renderer.engine.film import Film
from renderer.engine.filters import FILTERS
from renderer.engine.passes import View
from renderer.integrators import integrator_of
from renderer.samplers import KINDS as SAMPLERS
from renderer.scene.arrange import AUTO
from renderer.scene.loader import load
from renderer.scene.paths import compile_paths
from renderer.scene.tables import compile_camera
from tests.support.documents import changed
from tests.support.stats import LEAST_BATCHES, compare, demand_equal

SIZE = 48, 32
CAMERA = {"type": "pinhole", "width": SIZE[0], "height": SIZE[1], "position": [0.4, 0.9, -4.0],
          "lookAt": [0.05, 0.1, 0.0], "upVector": [0.0, 1.0, 0.0], "fov": 34.0}


def scene(*shapes, lights=(), camera=None, bounces=4, sampler="independent", **settings):
    """Return a document of mode `pathtracer`; `settings` are keys of the file, and `background`."""
    world = {"backgroundcolor": settings.pop("background", [0.0, 0.0, 0.0]), "lightsources": list(lights),
             "shapes": list(shapes)}
    return {"nbounces": bounces, "rendermode": "pathtracer", "sampler": sampler, **settings,
            "camera": {**CAMERA, **(camera or {})}, "scene": world}


def seeds(loaded):
    """Return a seed for us and the first of Mitsuba's: another pair for each scene, so that luck is not shared."""
    digest = zlib.crc32(loaded.source.text.encode())
    return digest & 0xFFFFFF, digest >> 8


class _Tall(View):
    """Pictures one above the other, as one: its rows repeat, and each lane draws by its own number."""

    def _lanes(self, pixel, width, seed):
        """Return sampler and corner of each lane; the corner is that within its own picture."""
        sampler, corner = super()._lanes(pixel, width, seed)
        height = Float(self.height // LEAST_BATCHES)
        corner.y -= height * dr.floor((corner.y + 0.5) / height)
        return sampler, corner


def ours(loaded, samples):
    """Return (LEAST_BATCHES, H, W, 3) independent pictures of so many samples a pixel, rendered at once."""
    description = loaded.description
    width, height = description.camera.width, description.camera.height
    integrator = integrator_of(description.rendermode)(compile_paths(loaded, AUTO), description.nbounces)
    view = _Tall(integrator, compile_camera(description.camera), SAMPLERS[description.sampler], width,
                 LEAST_BATCHES * height, seeds(loaded)[0], pixel_filter=FILTERS[description.filter]())
    film = view.expose(Film.empty(width * view.height, signed=view.pixel_filter.signed), 0, samples)
    colour = film.mean(samples)
    dr.eval(film, colour)
    assert not dr.any(film.lost > 0), "samples that are not finite"
    channels = [channel.numpy().reshape(LEAST_BATCHES, height, width) for channel in colour]
    return np.stack(channels, axis=-1).astype(np.float64)


def theirs(loaded, samples):
    """Return (LEAST_BATCHES, H, W, 3) pictures of Mitsuba's path integrator."""
    whole = mi.load_dict(export.to_dict(loaded, exact=True))
    first = seeds(loaded)[1]
    batches = [mi.render(whole, spp=samples, seed=first + k).numpy() for k in range(LEAST_BATCHES)]
    return np.array(batches, np.float64)


@dataclass(frozen=True, eq=False)
class Case:
    """One feature: a scene, and one thing in it that is a little wrong on our side only."""

    document: dict
    path: str  # of the key that is changed, see documents.changed
    value: object  # or a function of the old one
    samples: int = 64  # a pixel and batch
    files: tuple = ()  # functions that write a file into a folder


class Judge:
    """Renders the cases of a module in one folder; Mitsuba's side of a case and its twin is rendered once."""

    def __init__(self, folder):
        self._folder = folder

    def load(self, case, document):
        """Return a document loaded."""
        for write in case.files:
            write(self._folder)
        path = self._folder / "scene.json"
        path.write_text(json.dumps(document))
        return load(path)

    def decide(self, case):
        """Demand that our picture has Mitsuba's expectation, and that the changed one has not."""
        self.agree(case)
        self.refuse(case)

    def agree(self, case):
        """Demand that our picture has Mitsuba's expectation; return the Verdict."""
        right = self.load(case, case.document)
        assert not right.warnings, right.warnings
        return demand_equal(ours(right, case.samples), self.reference(case))

    def refuse(self, case):
        """Demand that the changed scene is told from Mitsuba's right one."""
        wrong = self.load(case, changed(case.document, case.path, case.value))
        verdict = compare(ours(wrong, case.samples), self.reference(case))
        assert verdict.refused, verdict

    @functools.lru_cache(maxsize=4)
    def reference(self, case):
        """Return Mitsuba's batches."""
        return theirs(self.load(case, case.document), case.samples)


def times(factor):
    """Return a function that scales a number or a vector."""
    return lambda old: [factor * x for x in old] if isinstance(old, (list, tuple)) else factor * old
