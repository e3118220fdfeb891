"""The structures beside each other, and from how many shapes on the hierarchy pays.

Closest hits of incoherent rays (from inside, as in mesh_rays.py) and of a pinhole camera's, per CPU second, with `bvh`,
`grid` and `none`; building them from arrays is told apart. Scenes: the bumpy mesh and the soup of mesh_scenes.py; the
mesh in a stadium, which is 200 triangles 50 times as large around it; and a cloud of spheres and cylinders.
Crossover: spheres in a box, tested one after the other (unrolled, as `auto` does with few shapes) and through the
hierarchy, with what compiling the kernel took.
"""

from __future__ import annotations

import time
from functools import partial

import drjit as dr
import numpy as np

from benchmarks.lanes import done, vectors
from benchmarks.measure import interleaved, result, spread
from benchmarks.mesh_rays import ray_sets
from benchmarks.mesh_scenes import bumpy, in_ball, on_sphere, soup
from renderer.core.backend import Float, Vector3f
from renderer.core.records import Ray
from renderer.engine import queries
from renderer.scene.geometry import Geometry
from renderer.scene.loader import from_dict
from renderer.scene.meshes import plain_triangles
from renderer.scene.structures import structure_over
from renderer.scene.tables import compile_scene

SIZE, SMALL = 10_000, 1_000  # triangles, or shapes; `none` is only measured with few of them
CLOUD = 12_800
CROSSOVER = (2, 4, 8, 16, 32, 64, 128)  # spheres
STADIUM = 50.0
ACCELS = ("bvh", "grid", "none")
SEED = 5


def measure(effort):
    """Return both tables; nothing is judged."""
    return result([], structures=[*_structures(effort)], crossover=[_crossover(count, effort) for count in CROSSOVER])


def _structures(effort):
    """Yield a row for each scene and kind of rays."""
    meshes = {"bumpy mesh": bumpy(SIZE), "soup": soup(SIZE), "mesh in a stadium": _stadium()}
    meshes["small mesh"] = bumpy(SMALL)
    made = {name: _of_mesh(*mesh) for name, mesh in meshes.items()} | {"spheres and cylinders": _cloud()}
    rays = {rays.name: rays for rays in ray_sets(*meshes["bumpy mesh"], effort.width, effort.height)}
    for name, geometry_of in made.items():
        found = {}
        for accel in ACCELS[: 3 if name == "small mesh" else 2]:
            geometry_of(accel)  # once for the kernels
            start = time.process_time()
            geometry = geometry_of(accel)
            found[accel] = geometry, time.process_time() - start
        for sort in ("from inside", "primary"):
            host = next(iter(rays[sort].orders.values()))
            ray = Ray(vectors(Vector3f, Float, host.o), vectors(Vector3f, Float, host.d))
            actions = {
                accel: partial(_trace, geometry, ray, sort == "primary") for accel, (geometry, _) in found.items()
            }
            times = interleaved(actions, effort.repeats)
            yield {"scene": name, "rays": sort} | {
                f"{accel}, {what}": value
                for accel, seconds in times.items()
                for what, value in (
                    ("M rays/CPU s", spread([len(host.o) / 1e6 / second for second in seconds])),
                    ("build, CPU s", found[accel][1]),
                )
            } | {f"{accel}, {what}": None for accel in ACCELS if accel not in times
                 for what in ("M rays/CPU s", "build, CPU s")}  # fmt: skip


def _trace(geometry, ray, coherent):
    """Trace closest hits and wait for them."""
    hit = queries.closest(geometry, ray, coherent)
    done(hit.t, hit.index)


def _of_mesh(vertices, faces):
    """Return a function from the structure's name to the Geometry of one mesh."""
    triangles = plain_triangles(vertices, faces)

    def build(accel):
        geometry = Geometry((), triangles, structure_over(triangles, accel=accel), 1)
        dr.sync_thread()
        return geometry

    return build


def _stadium():
    """Return the bumpy mesh with 200 large triangles around it."""
    vertices, faces = bumpy(SIZE)
    rng = np.random.default_rng(SEED)
    centres = STADIUM * on_sphere(rng, 200)
    large = (centres[:, None] + STADIUM / 4 * rng.normal(size=(200, 3, 3))).reshape(-1, 3)
    around = np.arange(len(large)).reshape(-1, 3) + len(vertices)
    return np.concatenate([vertices, large]).astype(np.float32), np.concatenate([faces, around]).astype(np.uint32)


def _cloud():
    """Return a function from the structure's name to the Geometry of many spheres and cylinders."""
    rng = np.random.default_rng(SEED)
    centres, axes = in_ball(rng, CLOUD), on_sphere(rng, CLOUD)
    shapes = [
        {"type": "sphere", "center": center.tolist(), "radius": 0.02} if k % 2 else
        {"type": "cylinder", "center": center.tolist(), "axis": axis.tolist(), "radius": 0.01, "height": 0.03}
        for k, (center, axis) in enumerate(zip(centres, axes))
    ]  # fmt: skip
    loaded = from_dict(_document(shapes))
    return partial(_compiled, loaded)


def _compiled(loaded, accel):
    """Return a scene compiled with a structure, once it is there."""
    scene = compile_scene(loaded, accel)
    dr.sync_thread()
    return scene


def _document(shapes):
    """Return a scene file's content."""
    camera = {"type": "pinhole", "width": 8, "height": 8, "position": [0, 0, -4], "lookAt": [0, 0, 0],
              "upVector": [0, 1, 0], "fov": 40, "exposure": 0.1}  # fmt: skip
    world = {"backgroundcolor": [0, 0, 0], "lightsources": [], "shapes": shapes}
    return {"rendermode": "phong", "camera": camera, "scene": world}


def _crossover(count, effort):
    """Return the row of so many spheres."""
    rng = np.random.default_rng(SEED)
    radius = 0.4 / count ** (1 / 3)
    shapes = [{"type": "sphere", "center": center.tolist(), "radius": radius} for center in in_ball(rng, count)]
    loaded = from_dict(_document(shapes))
    rays = {rays.name: rays for rays in ray_sets(*bumpy(SMALL), effort.width, effort.height)}
    row = {"spheres": count}
    for sort in ("from inside", "primary"):
        host = next(iter(rays[sort].orders.values()))
        ray = Ray(vectors(Vector3f, Float, host.o), vectors(Vector3f, Float, host.d))
        scenes = {accel: compile_scene(loaded, accel) for accel in ("none", "bvh")}
        actions = {accel: partial(_trace, scene, ray, sort == "primary") for accel, scene in scenes.items()}
        for accel, seconds in interleaved(actions, effort.repeats).items():
            whose = "unrolled" if accel == "none" else "hierarchy"
            row[f"{sort}, {whose}, M rays/CPU s"] = spread([len(host.o) / 1e6 / second for second in seconds])
    return row
