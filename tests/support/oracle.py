"""Both sides of a comparison: what our renderer sees in a scene, what Mitsuba sees, and scenes changed on purpose."""

from __future__ import annotations

import functools
import json

import numpy as np

from converters import whitted
from renderer.engine.render import render
from renderer.scene.loader import load, override
from tests.support import compare

WIDTH, HEIGHT = 240, 160  # pixels of a comparison
DEBUG = {"depth": ("Z",), "normals": ("N.X", "N.Y", "N.Z"), "uv": ("U", "V"),
         "albedo": ("Albedo.R", "Albedo.G", "Albedo.B"), "shapes": ("Shape",)}
NAMES = {"depth": "depth", "normals": "normal", "uv": "uv", "albedo": "albedo", "shapes": "shape"}
ROUND = ("sphere", "cylinder")  # shapes whose u is an angle


def prepare(path, width=WIDTH, height=HEIGHT, **settings):
    """Return the loaded scene at the size of a comparison, one ray through each pixel centre."""
    return override(load(str(path)), width=width, height=height, samples=1, **settings)


def write(directory, document, name="scene.json"):
    """Write a scene document (nested dicts) into the directory and return its path."""
    path = directory / name
    path.write_text(json.dumps(document))
    return path


def observe(loaded, what):
    """Return our renderer's picture: `rgb` (the scene's own mode), `depth`, `normal`, `uv`, `albedo` or `shape`."""
    if what == "rgb":
        channels = render(loaded).channels()
        return np.stack([channels[c] for c in "RGB"], axis=-1)
    mode = next(mode for mode, name in NAMES.items() if name == what)
    channels = render(override(loaded, mode=mode)).channels()
    picture = np.stack([np.asarray(channels[c]) for c in DEBUG[mode]], axis=-1)
    return picture[..., 0] if picture.shape[-1] == 1 else picture


class Oracle:
    """Mitsuba's view of a scene, and how far rounding of the camera rays may move each value."""

    def __init__(self, loaded):
        self.loaded = loaded
        self.reference = whitted.reference(loaded)
        self.hit, self.shape = self.reference["hit"], self.reference["shape"]
        self._moved = whitted.neighbours(loaded)
        self.uncertain = np.any([m["shape"] != self.shape for m in self._moved], axis=0)
        self.edges = self.uncertain | np.any([self._edge(m) for m in self._moved], axis=0)
        kinds = dict(loaded.shapes)
        self.round = np.isin(self.shape, [k for k, s in kinds.items() if s.type in ROUND])

    def _edge(self, moved):
        """Return where the pictures of moved rays see another facet or a sharp bend, (H, W)."""
        bent = np.abs(moved["normal"] - self.reference["normal"]).max(axis=-1) > whitted.EDGE_ANGLE
        return bent | (moved["part"] != self.reference["part"])

    def spread(self, name):
        """Return (H, W): the greatest change of a value within the camera's rounding; 0 across silhouettes."""
        centre, result = self.reference[name], np.zeros(self.hit.shape)
        for moved in self._moved:
            value = compare.unwrap(moved[name], centre) if name == "uv" else moved[name]
            result = np.maximum(result, compare.difference(value, centre))
        return np.where(self.edges, 0, result)

    def check(self, name, ours):
        """Raise Mismatch unless our picture `name` (see `observe`) agrees; return counts for `shape`."""
        if name == "rgb":
            return self._check_colour(ours)
        if name == "shape":
            return compare.check_shapes(ours, self.shape, self.uncertain)
        where = self.hit & ~self.edges
        if name == "albedo":  # a texel's edge is as uncertain as a silhouette
            where &= self.spread(name) < compare.COLOUR_VISIBLE
        return compare.check_values(name, ours, self.reference[name], where, self.spread(name),
                                    self.round if name == "uv" else None)

    def _check_colour(self, ours):
        """Raise Mismatch unless the colours agree; pixels where Mitsuba's own colour hangs on rounding do not count."""
        try:
            return compare.check_colour(ours, self.reference["rgb"], self.shape)
        except compare.Mismatch:
            unsettled = self.uncertain | (self.colour_uncertainty > compare.COLOUR_VISIBLE)
            if unsettled.mean() > compare.UNSETTLED_SHARE:
                raise
            ours = np.where(unsettled[..., None], self.reference["rgb"], ours)
            return compare.check_colour(ours, self.reference["rgb"], self.shape)

    @functools.cached_property
    def colour_uncertainty(self):
        """How much Mitsuba's colour changes within rounding, (H, W); 0 in binary mode, where only the mask counts."""
        if self.loaded.description.rendermode != "phong":
            return np.zeros(self.hit.shape)
        return whitted.colour_uncertainty(self.loaded)


@functools.cache
def oracle(loaded):
    """Return the Oracle of a loaded scene; Mitsuba renders each scene once."""
    return Oracle(loaded)
