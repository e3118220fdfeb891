"""How no structure, the grid, the hierarchy and Mitsuba's Embree get slower as a mesh gets finer.

Closest hits of bounced rays and of a pinhole camera's in tiles (mesh_rays.py) on the meshes of mesh_scenes.py, a power
of ten of triangles after the other, and what building takes, from arrays on the host as in meshes.py. Without a
structure fewer rays are traced, evenly picked, so that no measurement takes long. All that have a structure get the
same rays, in the same order. CPU time of all threads, in turns, at least a quarter of a second each. Bytes are those of
the structure's arrays, records of leaves included, vertices and corners not.
"""

from __future__ import annotations

import dataclasses
import math
import time
from functools import partial

import drjit as dr

from benchmarks import embree
from benchmarks.lanes import done, vectors
from benchmarks.measure import interleaved, result, spread
from benchmarks.mesh_rays import AS_MADE, ray_sets
from benchmarks.mesh_scenes import KINDS
from renderer.core.backend import Float, UInt32, Vector3f
from renderer.core.records import Ray
from renderer.engine import queries
from renderer.scene.geometry import Geometry
from renderer.scene.meshes import plain_triangles
from renderer.scene.structures import structure_over

SIZES = (100, 1_000, 10_000, 100_000, 1_000_000)  # triangles, about
SORTS = {"bounce": AS_MADE, "primary": "8 x 8 tiles"}  # sets of rays, and the order in which they are traced
ACCELS, MITSUBA = ("none", "grid", "bvh"), "Mitsuba"
SHORTEST = 0.25  # CPU seconds of one measurement
MOST_TESTS = 100_000_000  # rays times triangles that are traced without a structure


def measure(effort):
    """Return rates by mesh, size and rays, and what building takes; nothing is judged."""
    rates, building = [], []
    for mesh, make in KINDS.items():
        for size in SIZES:
            if size > max(effort.triangles, SIZES[0]):
                break
            arrays = make(size)
            about = {"mesh": mesh, "triangles": len(arrays[1])}
            structures = {accel: _of(accel, *arrays) for accel in ACCELS}
            building.append(about | _building(arrays, structures, effort.repeats))
            rates += [about | row for row in _rates(arrays, structures, effort)]
    return result([], rates=rates, building=building)


def _of(accel, vertices, faces):
    """Return the Geometry of a mesh with one of our structures."""
    triangles = plain_triangles(vertices, faces)
    geometry = Geometry((), triangles, structure_over(triangles, accel=accel), 1)
    dr.sync_thread()
    return geometry


def _building(arrays, structures, repeats):
    """Return how long each takes to build, and how many bytes a triangle our structures take."""
    actions = {accel: partial(_of, accel, *arrays) for accel in structures}
    times = timed(actions | {MITSUBA: partial(embree.build, embree.mesh_of(*arrays))}, repeats)
    return {f"{name}, CPU s": spread(seconds) for name, seconds in times.items()} | {
        f"{accel}, bytes/triangle": held(geometry.structure) / len(arrays[1]) for accel, geometry in structures.items()
    }


def held(structure):
    """Return how many bytes the arrays of one of our structures take."""
    return sum(4 * len(array) for array in vars(structure).values() if isinstance(array, UInt32))


def _rates(arrays, structures, effort):
    """Yield the rates of each set of rays."""
    scene = embree.build(embree.mesh_of(*arrays))
    for rays in ray_sets(*arrays, effort.width, effort.height):
        if rays.name not in SORTS:
            continue
        host = rays.orders[SORTS[rays.name]]
        few = _thinned(host, math.ceil(len(host.o) * len(arrays[1]) / MOST_TESTS))
        counts = {name: len((few if name == "none" else host).o) for name in (*structures, MITSUBA)}
        actions = {accel: _trace(geometry, few if accel == "none" else host, rays.coherent)
                   for accel, geometry in structures.items()}  # fmt: skip
        actions[MITSUBA] = partial(embree.closest, scene, embree.rays_of(host), rays.coherent)
        times = timed(actions, effort.repeats)
        yield {"rays": rays.name} | {
            f"{name}, M rays/CPU s": spread([counts[name] / 1e6 / second for second in seconds])
            for name, seconds in times.items()
        }


def _thinned(host, step):
    """Return every `step`-th of the rays."""
    parts = {field.name: getattr(host, field.name) for field in dataclasses.fields(host)}
    return type(host)(**{name: part if part is None else part[::step] for name, part in parts.items()})


def _trace(geometry, host, coherent):
    """Return a function that traces rays of the host, which it brings to the device only once."""
    ray = Ray(vectors(Vector3f, Float, host.o), vectors(Vector3f, Float, host.d))

    def trace():
        """Return the closest hits, once they are there."""
        hit = queries.closest(geometry, ray, coherent)
        done(hit.t, hit.index)
        return hit

    return trace


def timed(actions, repeats):
    """Return {name: CPU seconds of a call, a list over the repeats}; each is called as often as fills SHORTEST."""
    calls = {name: max(1, math.ceil(SHORTEST / max(seconds, 1e-4))) for name, seconds in _once(actions).items()}
    times = interleaved({name: partial(_often, action, calls[name]) for name, action in actions.items()}, repeats)
    return {name: [second / calls[name] for second in seconds] for name, seconds in times.items()}


def _once(actions):
    """Return the CPU seconds of one call of each, kernels being there."""
    seconds = {}
    for name, action in actions.items():
        action()
        start = time.process_time()
        action()
        seconds[name] = time.process_time() - start
    return seconds


def _often(action, calls):
    """Call an action so many times."""
    for _ in range(calls):
        action()
