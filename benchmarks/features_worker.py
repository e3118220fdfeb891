"""A process that measures features with an empty cache of kernels, for the benchmark `features`.

`python -m benchmarks.features_worker KEYS WIDTHxHEIGHT SAMPLES REPEATS`, the keys with commas between them, prints
{key: {side: what was found}} as JSON. Path-traced pictures are half as large on each side.
"""

from __future__ import annotations

import json
import statistics
import sys
from dataclasses import replace

import drjit as dr

from benchmarks import feature_scenes
from benchmarks.feature_patches import patched
from benchmarks.measure import interleaved
from renderer.engine.film import Film
from renderer.engine.render import set_up
from renderer.scene import loader

HAVING, WITHOUT = "with", "without"
SMALL = 8  # pixels: sides of a picture that takes next to no time but what recording a kernel takes
THEIR_SAMPLES = 16  # a pixel, at most, of Mitsuba's pictures
THEIR_REPEATS = 3  # at most
SECONDS_TO_NS = 1e9


class Ours:
    """A scene, set up once."""

    def __init__(self, document, folder, side):
        loaded = loader.from_dict(document, directory=folder)
        self.samples, self._side = loaded.description.spp, side
        with patched(side.patch):
            _, self._view = set_up(loaded, accel=side.accel, single=self.samples == 1)

    def render(self, small=False):
        """Render all samples in one pass; return how many."""
        view = replace(self._view, width=SMALL, height=SMALL) if small else self._view
        pixels = view.width * view.height
        film = Film.empty(pixels, self.samples == 1, view.pixel_filter.signed)
        with patched(self._side.patch):
            film = view.expose(film if self.samples == 1 else film.opaque(), 0, self.samples)
        dr.eval(film)
        dr.sync_thread()
        return pixels * self.samples

    def compiled(self):
        """Return the seconds that the first picture's kernels took to compile, and the operations of the largest."""
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            self.render(small=True)
            kernels = [kernel for kernel in dr.kernel_history() if "backend_time" in kernel]
        seconds = sum(kernel["codegen_time"] + kernel["backend_time"] for kernel in kernels) / 1000
        return {"compile": seconds, "operations": max(kernel["operation_count"] for kernel in kernels)}


class Theirs:
    """The same scene in Mitsuba, with its sampler of independent numbers."""

    def __init__(self, document, folder):
        from converters.mitsuba import to_dict

        self._scenes, self._pixels = {}, document["camera"]["width"] * document["camera"]["height"]
        for small in (False, True):
            size = {"width": SMALL, "height": SMALL} if small else {}
            made = document | {"camera": document["camera"] | size}
            loaded = loader.from_dict(made, directory=folder)
            self._samples = min(loaded.description.spp, THEIR_SAMPLES)
            tree = to_dict(loaded, exact=True)  # chooses the variant
            import mitsuba as mi

            tree["sensor"]["sampler"] = {"type": "independent", "sample_count": self._samples}
            self._scenes[small] = mi.load_dict(tree)

    def render(self, small=False):
        """Render all samples; return how many those of the large picture are."""
        import mitsuba as mi

        dr.eval(mi.render(self._scenes[small], spp=self._samples))
        dr.sync_thread()
        return self._pixels * self._samples


def of_feature(feature, size, samples, repeats):
    """Return {side: {"ns", "theirs", "compile", "operations"}}, the first two CPU nanoseconds a sample, by repeat."""
    folder, sides = feature_scenes.folder(feature), {HAVING: feature.having, WITHOUT: feature.without}
    documents = {name: feature_scenes.document(feature, side, size, samples) for name, side in sides.items()}
    ours = {name: Ours(made, folder, sides[name]) for name, made in documents.items()}
    found = {name: one.compiled() for name, one in ours.items()}
    for name, times in _each_sample(ours, repeats).items():
        found[name]["ns"] = times
    if feature.mitsuba:
        theirs = {name: Theirs(made, folder) for name, made in documents.items()}
        for name, times in _each_sample(theirs, min(repeats, THEIR_REPEATS)).items():
            found[name]["theirs"] = times
    return found


def _each_sample(pictures, repeats):
    """Return {name: CPU nanoseconds a sample, by repeat} of {name: picture}; what recording takes is subtracted."""
    actions = {(name, small): lambda one=one, small=small: one.render(small)
               for name, one in pictures.items() for small in (False, True)}  # fmt: skip
    seconds, counts = interleaved(actions, repeats), {name: one.render() for name, one in pictures.items()}
    recording = {name: statistics.median(seconds[name, True]) for name in pictures}
    return {name: [SECONDS_TO_NS * (full - recording[name]) / counts[name] for full in seconds[name, False]]
            for name in pictures}  # fmt: skip


def main(keys, size, samples, repeats):
    """Print what was found."""
    width, height = map(int, size.split("x"))
    found = {}
    for key in keys.split(","):
        feature = feature_scenes.SCENES[key]
        half = 2 if feature_scenes.is_path_traced(feature) else 1
        found[key] = of_feature(feature, (max(width // half, 1), max(height // half, 1)), int(samples), int(repeats))
    print(json.dumps(found))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
