"""Tell what hierarchies cost, and building them: `python -m tests.accel.measure_build 100000`.

Cost is what a random ray visits (inner nodes); time is CPU time, the least of three builds, kernels compiled before.
`--yardstick` adds the full-sweep builder, which takes about half a minute for 100,000 primitives; `--mitsuba` adds the
time of Mitsuba's Embree for as many triangles. `--set module.NAME=value` changes a constant of `renderer/accel` first.
"""

import argparse
import importlib
import time

import drjit as dr

from renderer.accel.build import ROUNDS, build
from tests.accel import build_inputs


def least_seconds(action, repetitions=3):
    """Return the least CPU time of an action, and its last result."""
    least = float("inf")
    for _ in range(repetitions):
        start = time.process_time()
        result = action()
        dr.sync_thread()
        least = min(least, time.process_time() - start)
    return least, result


def embree_seconds(lo, hi):
    """Return the CPU time of Mitsuba's Embree for triangles with these bounds."""
    import mitsuba as mi
    import numpy as np

    mi.set_variant("llvm_ad_rgb")
    vertices = np.stack([lo, hi, np.concatenate([lo[:, :1], hi[:, 1:]], 1)], 1)
    mesh = mi.Mesh("mesh", vertex_count=3 * len(lo), face_count=len(lo))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"], parameters["faces"] = vertices.ravel(), np.arange(3 * len(lo), dtype=np.uint32)
    parameters.update()
    return least_seconds(lambda: mi.load_dict({"type": "scene", "mesh": mesh}))[0]


def main():
    """Print a line an input."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int)
    parser.add_argument("--rounds", type=int, nargs="+", default=[ROUNDS])
    parser.add_argument("--width", type=int, default=4)
    parser.add_argument("--yardstick", action="store_true")
    parser.add_argument("--mitsuba", action="store_true")
    parser.add_argument("--set", nargs="+", default=[], metavar="module.NAME=value")
    chosen = parser.parse_args()
    for setting in chosen.set:
        name, value = setting.split("=")
        module, name = name.split(".")
        setattr(importlib.import_module(f"renderer.accel.{module}"), name, number(value))
    for name, make in build_inputs.INPUTS.items():
        lo, hi = make(chosen.count)
        lanes = build_inputs.vector(lo), build_inputs.vector(hi)
        dr.eval(lanes)
        for rounds in chosen.rounds:
            build(*lanes, chosen.width, rounds)
            seconds, tree = least_seconds(lambda: build(*lanes, chosen.width, rounds))
            print(f"{name:8} {len(lo):8} primitives, {rounds:2} rounds: {build_inputs.cost(tree):8.3f} nodes visited, "
                  f"depth {tree.depth:2}, {seconds:.3f} s", flush=True)
        if chosen.yardstick:
            print(f"{name:8} full sweep: {build_inputs.yardstick_cost(lo, hi, chosen.width):8.3f} nodes", flush=True)
        if chosen.mitsuba:
            print(f"{name:8} Embree: {embree_seconds(lo, hi):.3f} s", flush=True)


def number(text):
    """Return a number as int where it is one."""
    return float(text) if "." in text else int(text)


if __name__ == "__main__":
    main()
