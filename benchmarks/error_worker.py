"""One contender on one scene, in a process of its own: renders on demand and tells what it took.

    python -m benchmarks.error_worker SIDE SCENE.json        SIDE: `ours`, or a variant of Mitsuba

Speaks JSON, a line for each question and answer. It begins with {"import", "build"} in seconds; to
{"sampler", "samples", "seed", "picture": FILE.npy} it answers {"cpu", "wall", "compile", "samples"}, seconds and the
samples a pixel that were really taken, once the picture lies in the file; to {} it answers {"peak"} in MB and ends.

Building is what comes between the description and a scene that can be rendered. Reading ours is not counted, nor what
it takes to translate it for Mitsuba. Compiling is the time in which Dr.Jit writes and compiles kernels.
"""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import dataclass

OURS = "ours"


@dataclass(frozen=True)
class Shot:
    """A picture and what it took."""

    picture: object  # (H, W, 3) float32, linear
    samples: int  # a pixel, taken
    cpu: float  # seconds, all threads
    wall: float
    compile: float  # of these, for kernels; 0 where all were there

    def told(self):
        """Return what the parent is told."""
        return {"samples": self.samples, "cpu": self.cpu, "wall": self.wall, "compile": self.compile}


class Ours:
    """Our renderer with the sampler that it has by default."""

    def __init__(self, path):
        start = time.perf_counter()
        import drjit as dr

        from renderer.engine.render import set_up
        from renderer.scene import loader, paths  # noqa: F401 (everything that a render imports)

        self.imported = time.perf_counter() - start
        loaded = loader.load(path)
        start = time.perf_counter()
        _, self._view = set_up(loaded)
        dr.sync_thread()
        self.built = time.perf_counter() - start

    def render(self, sampler, samples, seed):
        """Return the Shot; `sampler` None is the scene's own. Raises RuntimeError where samples were not finite."""
        import dataclasses

        import drjit as dr

        from renderer.engine.passes import Until, find_lost, refine
        from renderer.samplers import KINDS

        view = dataclasses.replace(self._view, seed=seed, **({"sampler": KINDS[sampler]} if sampler else {}))

        def work():
            exposure = refine(view, Until(samples))
            colour = exposure.film.mean(exposure.taken)
            dr.eval(colour)
            return exposure, colour

        (exposure, colour), *took = _timed(work)
        if find_lost(view, exposure):
            raise RuntimeError("samples that are not finite")
        return Shot(_pixels(colour, view), exposure.samples, *took)


class Theirs:
    """Mitsuba's `path` in one of its variants."""

    def __init__(self, path, variant):
        start = time.perf_counter()
        import mitsuba as mi

        mi.set_variant(variant)
        self.imported = time.perf_counter() - start
        from converters.mitsuba.as_dict import scene_dictionary
        from converters.mitsuba.plan import plan
        from renderer.scene import loader

        planned = plan(loader.load(path), exact=True)
        start = time.perf_counter()
        whole = scene_dictionary(planned)
        self._scene = mi.load_dict(whole)
        self._wait()
        self.built = time.perf_counter() - start
        self._camera, self._sensors = whole["sensor"], {}

    @staticmethod
    def _wait():
        """Wait for what runs in the background; in scalar variants nothing does."""
        import drjit as dr
        import mitsuba as mi

        if not mi.variant().startswith("scalar"):
            dr.sync_thread()

    def render(self, sampler, samples, seed):
        """Return the Shot; some samplers take more samples than they are asked for."""
        import drjit as dr
        import mitsuba as mi
        import numpy as np

        if sampler not in self._sensors:  # a camera cannot change its sampler
            self._sensors[sampler] = mi.load_dict(self._camera | {"sampler": {"type": sampler}})
        sensor = self._sensors[sampler]

        def work():
            picture = mi.render(self._scene, sensor=sensor, spp=samples, seed=seed)
            dr.eval(picture)
            self._wait()
            return picture

        picture, *took = _timed(work)
        return Shot(np.array(picture, dtype=np.float32), sensor.sampler().sample_count(), *took)


def _timed(work):
    """Return what `work` returns, its CPU and wall seconds, and those for kernels that were not there before."""
    import drjit as dr

    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        cpu, wall = time.process_time(), time.perf_counter()
        made = work()
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        history = dr.kernel_history()
    new = [kernel for kernel in history if kernel.get("cache_hit") == 0]  # sums and copies have no such entry
    compiling = sum(kernel["codegen_time"] + kernel["backend_time"] for kernel in new)
    return made, cpu, wall, compiling / 1000


def _pixels(colour, view):
    """Return the picture of our lanes."""
    import numpy as np

    return np.stack([channel.numpy().reshape(view.height, view.width) for channel in colour], axis=-1)


def peak():
    """Return the largest resident memory of this process since it began, in MB (10^6 bytes)."""
    with open("/proc/self/status") as lines:
        return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:")) * 1024 / 1e6


def serve(contender, questions, answers):
    """Answer until the questions end."""

    def tell(told):
        print(json.dumps(told), file=answers, flush=True)

    tell({"import": contender.imported, "build": contender.built})
    for line in questions:
        asked = json.loads(line)
        if not asked:
            break
        shot = contender.render(asked["sampler"], asked["samples"], asked["seed"])
        import numpy as np

        np.save(asked["picture"], shot.picture)
        tell(shot.told())
    tell({"peak": peak()})


def main(side, path):
    """Serve on standard input and output; what libraries print goes to the errors."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    serve(Ours(path) if side == OURS else Theirs(path, side), sys.stdin, answers)


if __name__ == "__main__":
    main(*sys.argv[1:])
