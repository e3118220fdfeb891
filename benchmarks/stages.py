"""A process that does what `python -m renderer SCENE -o FILE` does and tells what its time went into.

Run as a file with a scene, a size and a file to write; prints JSON: when the first line ran and the last one
(time.monotonic(), which all processes share), and seconds by stage.
"""

import time

STARTED = time.monotonic()

import json  # noqa: E402  (the clock comes first)
import os  # noqa: E402
import sys  # noqa: E402


def main(path, size, picture):
    """Render and return {stage: seconds} and the time at the end."""
    clock, stages = STARTED, {}

    def passed(stage):
        nonlocal clock
        now = time.monotonic()
        stages[stage], clock = now - clock, now

    from renderer import cli, options  # noqa: F401 (the command imports it, so its time counts)
    from renderer.io import outputs
    from renderer.scene import loader

    options.build_parser()
    passed("import of the command line and the loader")
    width, height = map(int, size.split("x"))
    loaded = loader.override(loader.load(path), width=width, height=height)
    passed("reading the scene")
    from renderer.engine.render import render

    passed("import of Dr.Jit and the renderer")
    rendering = render(loaded)
    passed("render")
    outputs.write_all([picture], rendering, outputs.Grading(), {})
    passed("tone mapping and writing")
    return _divided(stages, rendering.timings), clock


def _divided(stages, timings):
    """Return the stages with that of rendering divided into its parts."""
    parts = {"scene to arrays": timings.build, "kernels: compiled, or from the cache": timings.compile}
    parts["kernels: traced and run"] = stages["render"] - timings.build - timings.compile
    return {
        name: seconds
        for stage, total in stages.items()
        for name, seconds in (parts if stage == "render" else {stage: total}).items()
    }


if __name__ == "__main__":
    sys.path.insert(0, os.getcwd())
    found, done = main(*sys.argv[1:])
    print(json.dumps({"started": STARTED, "stages": found, "done": done}), flush=True)
    os._exit(0)  # as the command does
