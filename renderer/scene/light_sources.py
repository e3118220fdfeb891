"""What shines in a description: lights of the file and shapes, as groups of one kind with records, and what each may
bring (see light_choice.py)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from renderer.core.colour import luminance
from renderer.core.errors import SceneError
from renderer.core.numeric import TINY
from renderer.core.packets import Packets
from renderer.core.rows import Rows
from renderer.io.image import read_environment
from renderer.lights import KINDS, sheet, sphere
from renderer.lights.environment import Environment
from renderer.lights.mesh import MeshLights
from renderer.scene.light_choice import FEW, Estimate
from renderer.shapes import KINDS as SHAPES

MESH = "mesh"


@dataclass(frozen=True)
class Emitter:
    """A shape that shines."""

    shape_index: int  # in the compiled order
    shape: object
    twosided: bool
    area: float | None  # of one side; None if it is not sampled
    triangles: tuple | None = None  # of a mesh: the first one's number, and (N,) areas

    @property
    def radius(self):
        """Radius of a sphere that is sampled, else 0."""
        return self.shape.radius if self.area and self.shape.type == "sphere" else 0.0


@dataclass(frozen=True)
class LightRows:
    """All lights of one kind, with records; they are numbered from `first` on."""

    sample: Callable  # (row, p, u, u2, has) -> DirectSample
    rows: Rows | Packets
    has: object
    first: int

    def direct(self, chosen, p, u2):
        """Return the DirectSample of each lane whose light is one of these."""
        return self.sample(chosen.row(self.rows, self.first), p, chosen.u, u2, self.has)

    @property
    def count(self):
        """Number of lights."""
        return self.rows.count


@dataclass(frozen=True)
class Surroundings:
    """An environment image as a light with the number `first`."""

    image: Environment
    first: int
    count: int = 1

    def direct(self, chosen, p, u2):
        """Return a DirectSample for each lane."""
        return self.image.sample(u2)


def emitters_of(world, shapes, triangles):
    """Return the Emitters among shapes [(index in the file, shape)], whose lamps follow the file's own shapes."""
    emitters = []
    host = _on_host(triangles) if any(shape.type == MESH and any(shape.emission) for _, shape in shapes) else None
    for number, (index, shape) in enumerate(shapes):
        if any(shape.emission):
            light, own = index - len(world.shapes), None
            twosided = shape.type in sheet.CODES if light < 0 else world.lightsources[light].twosided
            if shape.type == MESH:
                own = _areas(host, number)
            emitters.append(Emitter(number, shape, twosided, _area(shape, own), own))
    return emitters


def environment_of(loaded, sampled=True):
    """Return the Environment of a LoadedScene, None if it has none; raises SceneError if its image cannot be read."""
    for index, light in enumerate(loaded.description.scene.lightsources):
        if light.type == "environment":
            try:
                pixels = read_environment(loaded.resolve(light.filename))
            except SceneError as error:
                raise loaded.refused(error, "scene", "lightsources", index, "filename") from error
            return Environment(pixels, light.intensity, light.rotation, sampled)
    return None


def light_groups(lights, emitters, environment, triangles):
    """Return the groups of lights, the Estimate of each light, and for each Emitter its light's number or None."""
    lights = [light for light in lights if light.type in KINDS and KINDS[light.type].direct and any(light.intensity)]
    sampled = [k for k, emitter in enumerate(emitters) if emitter.area]
    groups, estimates, numbers = [], [], [None] * len(emitters)
    surrounds = environment is not None and environment.shines
    many = len(lights) + len(sampled) + surrounds > FEW

    def enter(sample, records, has, made, directions=()):
        rows = Packets(records) if many else Rows(records, directions=directions)
        groups.append(LightRows(sample, rows, has, len(estimates)))
        estimates.extend(Estimate(**values) for values in made)

    for name in dict.fromkeys(light.type for light in lights):
        kind, own = KINDS[name], [light for light in lights if light.type == name]
        made = [kind.estimate(light, luminance(light.intensity)) for light in own]
        enter(kind.direct, [kind.pack(light) for light in own], None, made)
    for kind, names, directions in ((sheet, sheet.CODES, sheet.EDGES), (sphere, ("sphere",), ())):
        places = [k for k in sampled if emitters[k].shape.type in names]
        if places:
            numbers_from(numbers, places, len(estimates))
            own = [(emitters[k].shape, emitters[k].twosided) for k in places]
            records = [kind.pack(*shape) for shape in own]
            made = [kind.estimate(*shape, luminance(shape[0].emission)) for shape in own]
            enter(kind.sample, records, kind.features(records), made, directions)
    places = [k for k in sampled if emitters[k].shape.type == MESH]
    if places:
        numbers_from(numbers, places, len(estimates))
        own = [(*emitters[k].triangles, emitters[k].shape.emission) for k in places]
        groups.append(MeshLights(triangles, own, len(estimates)))
        host = _on_host(triangles)
        estimates.extend(_of_mesh(host, emitters[k]) for k in places)
    if surrounds:
        groups.append(Surroundings(environment, len(estimates)))
        # half of what comes from everywhere together: a surface sees half of it, but mostly turned to the brightest
        estimates.append(Estimate(constant=2 * math.pi * environment.mean))
    return groups, estimates, numbers


def numbers_from(numbers, places, first):
    """Number some places of a list from `first` on."""
    for number, place in enumerate(places, first):
        numbers[place] = number


def extent(shapes, triangles, estimates):
    """Return corners of a box around all that is bounded: shapes [(index in the file, shape)], triangles and lights."""
    lowest, highest = [], []
    for _, shape in shapes:
        bounds = SHAPES[shape.type].bounds if shape.type != MESH else None
        if bounds:
            low, high = bounds(shape)
            lowest.append(low)
            highest.append(high)
    for corner in triangles.positions() if triangles else ():
        lowest.append([dr.min(axis)[0] for axis in corner])
        highest.append([dr.max(axis)[0] for axis in corner])
    local = [estimate.center for estimate in estimates if estimate.strength]
    ends = [(min(axis), max(axis)) for axis in zip(*lowest, *highest, *local)]
    return tuple(zip(*ends)) if ends else ((0.0,) * 3, (0.0,) * 3)


def _area(shape, triangles):
    """Return the area of one side of a shape that is sampled; None for others, and where float32 cannot hold it."""
    if shape.type in sheet.CODES:
        area = sheet.area(shape)
    elif shape.type == "sphere":
        area = 4 * math.pi * shape.radius**2
    elif triangles is not None:
        area = float(triangles[1].sum())
    else:
        return None
    return area if TINY < area < 1 / TINY else None


def _on_host(triangles):
    """Return the (N,) shapes of all triangles, in order, and their three corners, (3, N) each, as host arrays.

    Once for all meshes: each time it copies every triangle.
    """
    return triangles.shapes().numpy(), [corner.numpy() for corner in triangles.positions()]


def _areas(host, shape_index):
    """Return the number of the first triangle of a mesh, and the (N,) areas of its triangles."""
    import numpy as np

    shapes, corners = host
    first, end = np.searchsorted(shapes, (shape_index, shape_index + 1)).tolist()
    v0, v1, v2 = (corner[:, first:end].astype(np.float64) for corner in corners)
    return first, 0.5 * np.linalg.norm(np.cross(v1 - v0, v2 - v0, axis=0), axis=0)


def _of_mesh(host, emitter):
    """Return the Estimate of a mesh: as of a sphere around its middle that has its area."""
    import numpy as np

    first, areas = emitter.triangles
    middle = np.mean([corner[:, first : first + len(areas)] for corner in host[1]], axis=0)
    center = tuple(map(float, (middle * areas).sum(axis=1) / areas.sum()))
    strength = 0.25 * emitter.area * luminance(emitter.shape.emission)  # by Cauchy, seen from outside of a convex one
    return Estimate(center=center, strength=strength, least=0.25 * emitter.area / math.pi)
