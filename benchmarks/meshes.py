"""Meshes beside Mitsuba, which traces with Embree: closest hits, shadow rays, building, memory, and diffuse paths.

Meshes and rays are made by numpy, always the same: `bumpy`, a closed surface with bumps of every size, and `soup`,
loose triangles anywhere. Both tracers get identical arrays in memory. Closest hit: distance and triangle evaluated,
beside `Scene.ray_intersect_preliminary`. Shadow: whether anything is in the way, beside `Scene.ray_test`. Ours is told
whether neighbouring rays are alike; Mitsuba's hint for that is tried both ways, and the faster counts. Primary rays
come row by row and in tiles; each side's best order counts. Rays that differ: hit on one side only, or at another
distance, or (shadow) blocked on one side only; Mitsuba does not ask Embree for its robust test of triangles.

Building: ours from arrays on the host, Mitsuba's from a mesh in memory; both without compiling. Memory: by how much a
process of its own grows, and by how much at most while it builds; Mitsuba shares the vertices with Embree, and those
are not counted. Diffuse paths: a bumpy mesh of albedo 0.8 under a square light and nothing else, at most 6 segments a
path (5 scatterings), no Russian roulette, independent samples, box filter, beside `path`; the noise is the variance of
a pixel between two seeds.

CPU time of all threads, in turns; every measurement takes at least half a second, and ratios are taken turn by turn.
Fall: the rate times the logarithm of the number of triangles, as a share of that at the smallest mesh: 1 or more means
that the rate falls no faster than the logarithm grows.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from benchmarks import embree, mesh_memory, our_meshes, stand_in
from benchmarks.lanes import done, lanes, vectors
from benchmarks.measure import interleaved, result, spread
from benchmarks.mesh_rays import ray_sets
from benchmarks.mesh_scenes import KINDS, DiffusePicture
from benchmarks.targets import HIGHER, LOWER, Figure
from renderer.core.backend import Float, Vector3f

# What is compared with Mitsuba: a module with `build`, `closest`, `occluded` and `diffuse_path` as in stand_in.py.
OURS = our_meshes
SIZES = (10_000, 100_000, 1_000_000, 10_000_000)  # triangles, about
SHORTEST = 0.5  # CPU seconds of one measurement: some systems count in steps of 4 ms
RELATIVE, ABSOLUTE = 1e-4, 1e-6  # distances further apart than both together differ; roundoff is 6e-8 in the unit ball
NO_HIT = 1e29  # a miss is at 1e30 in our renderer and at infinity in Mitsuba
MEMORY_REPEATS = 3
LARGEST_PICTURE, SAMPLES_SHARE = 512, 4  # pixels a side; paths a pixel are this part of the effort's samples
INCOHERENT = ("from outside", "from inside", "bounce")
LEAST = {"incoherent": 1.0, "shadow": 1.0, "primary": 0.5, "paths": 1.0, "build": 4.0, "memory": 128.0, "fall": 1.0}
AIM = {"incoherent": 1.5, "shadow": 1.5, "primary": 1.0, "paths": 2.0, "build": 1.0, "memory": 64.0}


def measure(effort, tracer=None):
    """Return the ratios of speed for each mesh and ray set, and the rest that the module's text names."""
    tracer = tracer or OURS
    tables = {"rays": [], "building": [], "memory": [], "diffuse paths": []}
    for kind, make in KINDS.items():
        for size in sizes(effort.triangles):
            mesh = make(size)
            about = {"mesh": kind, "triangles": len(mesh[1])}
            tables["building"].append(about | _building(tracer, mesh, effort))
            tables["rays"] += [about | row for row in _all_rays(tracer, mesh, effort)]
            if kind == "bumpy":
                tables["diffuse paths"].append(about | _paths(tracer, mesh, effort))
        tables["memory"].append(about | _memory(tracer, mesh))
    tables["fall"] = falls(tables["rays"])
    if tracer is stand_in:  # nothing of ours was measured, and nothing is judged
        return result([], **{f"{title} of the stand-in": rows for title, rows in tables.items()})
    return result(figures(tables), **tables)


def sizes(largest):
    """Return the numbers of triangles to measure; a number below all of them stands for itself."""
    return [size for size in SIZES if size <= largest] or [largest]


def in_turns(actions, repeats):
    """Return {name: array of CPU seconds of a call}: the fastest action alone fills SHORTEST in each turn."""
    once = interleaved(actions, 1)
    calls = math.ceil(SHORTEST / max(min(min(seconds) for seconds in once.values()), 1e-4))
    return {name: np.array(seconds) for name, seconds in interleaved(actions, repeats, max(calls, 1)).items()}


def _spread(values):
    """Return the spread of an array as plain numbers."""
    return spread(values.tolist())


def _building(tracer, mesh, effort):
    """Return how long both take to build."""
    in_memory = embree.mesh_of(*mesh)
    times = in_turns({"ours": partial(tracer.build, *mesh), "theirs": partial(embree.build, in_memory)}, effort.repeats)
    return {"time, x Mitsuba": _spread(times["ours"] / times["theirs"]), "our CPU s": _spread(times["ours"]),
            "Mitsuba's CPU s": _spread(times["theirs"])}  # fmt: skip


def _memory(tracer, mesh):
    """Return how many bytes a triangle both take."""
    names = {"our": tracer.__name__, "Mitsuba's": embree.__name__}
    grown = {whose: [mesh_memory.grown(name, *mesh) for _ in range(MEMORY_REPEATS)] for whose, name in names.items()}
    return {f"{whose} bytes/triangle, {what}": _spread(np.array([run[what] for run in runs]) / len(mesh[1]))
            for what in ("kept", "peak") for whose, runs in grown.items()}  # fmt: skip


def _all_rays(tracer, mesh, effort):
    """Yield the row of each ray set."""
    accel, scene = tracer.build(*mesh), embree.build(embree.mesh_of(*mesh))
    for rays in ray_sets(*mesh, effort.width, effort.height):
        yield _compare(Ours(tracer, accel, rays), Theirs(scene, rays), rays, effort.repeats)


def _compare(ours, theirs, rays, repeats):
    """Return the row of one ray set."""
    hint, first = theirs.faster_hint(), next(iter(rays.orders))
    actions = {("ours", order): partial(ours.trace, order) for order in rays.orders}
    actions |= {("theirs", order): partial(theirs.trace, order, hint) for order in rays.orders}
    times = in_turns(actions, repeats)
    best = {side: min(rays.orders, key=lambda order: np.median(times[side, order])) for side in ("ours", "theirs")}
    our_time, their_time = (times[side, best[side]] for side in ("ours", "theirs"))
    count = len(rays.orders[first].o)
    found, expected = ours.trace(first), theirs.trace(first, hint)
    return {
        "rays": rays.name, "x Mitsuba": _spread(their_time / our_time),
        "our M rays/CPU s": _spread(count / 1e6 / our_time),
        "Mitsuba's M rays/CPU s": _spread(count / 1e6 / their_time),
        "order, ours": best["ours"], "order, Mitsuba": best["theirs"], "Mitsuba's hint": "coherent" if hint else "none",
        **agreement(*([array.numpy() for array in arrays] for arrays in (found, expected))),
    }  # fmt: skip


def agreement(ours, theirs):
    """Return how many rays hit, and how many differ, from (blocked,) or (distances, triangles) of both."""
    if len(theirs) == 1:
        return {"share that hits": float(theirs[0].mean()), "rays that differ": int((ours[0] != theirs[0]).sum()),
                "other triangle, same distance": None}  # fmt: skip
    hits = [side[0] < NO_HIT for side in (ours, theirs)]
    both = hits[0] & hits[1]
    t, expected = ours[0][both], theirs[0][both]
    apart = np.abs(t - expected) > RELATIVE * expected + ABSOLUTE
    other = (ours[1][both] != theirs[1][both]) & ~apart
    return {"share that hits": float(hits[1].mean()), "rays that differ": int((hits[0] != hits[1]).sum() + apart.sum()),
            "other triangle, same distance": int(other.sum())}  # fmt: skip


class Ours:
    """Our tracer with the rays of one set in memory."""

    def __init__(self, tracer, accel, rays):
        self._tracer, self._accel, self._set = tracer, accel, rays
        self._rays = {order: _our_rays(host) for order, host in rays.orders.items()}

    def trace(self, order):
        """Return evaluated lanes: (blocked,) or (distance, triangle)."""
        trace = self._tracer.occluded if self._set.shadow else self._tracer.closest
        found = trace(self._accel, *self._rays[order], coherent=self._set.coherent)
        return done(found) if self._set.shadow else done(*found)


def _our_rays(host):
    """Return origins, directions and, of shadow rays, distances as the renderer's lanes."""
    rays = [vectors(Vector3f, Float, array) for array in (host.o, host.d)]
    return rays if host.distance is None else [*rays, lanes(Float, host.maxt)]


class Theirs:
    """Mitsuba with the rays of one set in memory. Its scene has to live as long as what it traced."""

    def __init__(self, scene, rays):
        self._scene, self._trace = scene, embree.occluded if rays.shadow else embree.closest
        self._rays = {order: embree.rays_of(host) for order, host in rays.orders.items()}

    def trace(self, order, coherent):
        """Return evaluated lanes: (blocked,) or (distance, triangle)."""
        return self._trace(self._scene, self._rays[order], coherent)

    def faster_hint(self):
        """Return the hint with which the first order is traced faster."""
        order = next(iter(self._rays))
        once = interleaved({hint: partial(self.trace, order, hint) for hint in (False, True)}, 1)
        return min(once, key=once.get)


def _paths(tracer, mesh, effort):
    """Return how fast both render the diffuse picture, how bright it is, and how noisy."""
    picture = DiffusePicture(size=1 << min(LARGEST_PICTURE, effort.height).bit_length() - 1)
    samples = max(1, effort.samples // SAMPLES_SHARE)
    accel, theirs = tracer.build(*mesh), embree.DiffusePath(*mesh, picture)
    renders = {"ours": lambda seed=0: done(tracer.diffuse_path(accel, picture, samples, seed))[0],
               "theirs": lambda seed=0: theirs.render(samples, seed)}  # fmt: skip
    times = in_turns(renders, effort.repeats)
    pictures = {side: [np.array(render(seed), dtype=np.float64) for seed in (1, 2)] for side, render in renders.items()}
    mean = {side: float(np.mean(pair)) for side, pair in pictures.items()}
    variance = {side: float(np.mean((pair[0] - pair[1]) ** 2) / 2) for side, pair in pictures.items()}
    millions = picture.size**2 * samples / 1e6
    return {
        "x Mitsuba": _spread(times["theirs"] / times["ours"]),
        "our M samples/CPU s": _spread(millions / times["ours"]),
        "Mitsuba's M samples/CPU s": _spread(millions / times["theirs"]),
        "mean radiance, x Mitsuba's": mean["ours"] / mean["theirs"],
        "noise, x Mitsuba's": variance["ours"] / variance["theirs"],
    }


def falls(rows):
    """Return the rates times the logarithm of the number of triangles, relative to the smallest mesh of the kind."""
    smallest = {}
    for row in rows:
        smallest.setdefault((row["mesh"], row["rays"]), row)
    return [
        {"mesh": row["mesh"], "rays": row["rays"], "triangles": row["triangles"],
         **{f"{whose}, of 1": _held(row, smallest[row["mesh"], row["rays"]], f"{whose} M rays/CPU s")
            for whose in ("our", "Mitsuba's")}}
        for row in sorted(rows, key=lambda row: (row["mesh"], row["rays"], row["triangles"]))
    ]  # fmt: skip


def _held(row, first, rate):
    """Return rate x log(triangles) of a row as a share of the first row's."""
    large, small = (one[rate]["median"] * math.log2(one["triangles"]) for one in (row, first))
    return large / small


def figures(tables):
    """Return the judged figures: of each kind's largest mesh, the least of the incoherent sets among them."""
    found = []
    for kind in KINDS:
        of_kind = {title: [row for row in rows if row["mesh"] == kind] for title, rows in tables.items()}
        largest = max(row["triangles"] for row in of_kind["rays"])
        last = {title: [row for row in rows if row["triangles"] == largest] for title, rows in of_kind.items()}
        name = f"{kind}, {largest} triangles"
        rays = {row["rays"]: row["x Mitsuba"]["median"] for row in last["rays"]}
        found += [
            _figure(f"{name}, slowest incoherent rays", "incoherent", min(rays[sort] for sort in INCOHERENT)),
            _figure(f"{name}, shadow rays", "shadow", rays["shadow"]),
            _figure(f"{name}, primary rays", "primary", rays["primary"]),
            *(_figure(f"{name}, diffuse paths", "paths", row["x Mitsuba"]["median"]) for row in last["diffuse paths"]),
            *(_figure(f"{name}, time to build", "build", row["time, x Mitsuba"]["median"], better=LOWER)
              for row in last["building"]),
            *(_figure(f"{name}, memory", "memory", row["our bytes/triangle, kept"]["median"], "bytes/triangle", LOWER)
              for row in last["memory"]),
            _figure(f"{name}, rate x log(triangles), least", "fall",
                    min(row["our, of 1"] for row in last["fall"] if row["rays"] in INCOHERENT), "x smallest mesh"),
        ]  # fmt: skip
    return found


def _figure(name, target, reached, unit="x Mitsuba", better=HIGHER):
    """Return a judged figure."""
    return Figure(name, unit, better, reached, LEAST[target], AIM.get(target))
