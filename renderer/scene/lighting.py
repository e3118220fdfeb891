"""Where light comes from in path-traced scenes: lights to sample, shapes that shine, and what is behind everything.

Lights are numbered in groups of one kind. This is the only place that goes from a lane's light, or from the shape that
it met, to the kind of light. Boxes, cylinders, convex volumes and planes that shine are not sampled: paths find them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.errors import SceneError
from renderer.core.numeric import TINY
from renderer.core.rows import Rows
from renderer.core.vectors import cross, unit
from renderer.io.image import read_environment
from renderer.lights import KINDS, sheet, sphere
from renderer.lights.base import area_pdf_sa
from renderer.lights.choice import Estimate, FewLights
from renderer.lights.environment import Environment

LUMINANCE = (0.2126, 0.7152, 0.0722)  # of linear sRGB [ITU-R BT.709]
BOTH_SIDES = ("rectangle", "disk", "triangle")  # shapes that shine on both
RADIANCE, INVERSE_AREA, ONE_SIDED, RADIUS = 0, 3, 4, 5  # columns of emitters


def luminance(colour):
    """Return the luminance of a linear colour on the host."""
    return sum(weight * part for weight, part in zip(LUMINANCE, colour))


@dataclass
class LightRows:
    """All lights of one kind, with records; those of the first have the number `first`."""

    sample: object  # (row, p, u, u2, has) -> DirectSample
    rows: Rows
    has: object
    first: int

    def direct(self, chosen, p, u2):
        """Return the DirectSample of each lane whose light is one of these."""
        return self.sample(chosen.row(self.rows, self.first), p, chosen.u, u2, self.has)

    @property
    def count(self):
        """Number of lights."""
        return self.rows.count


@dataclass
class Surroundings:
    """An environment image as a light."""

    image: Environment
    first: int
    count: int = 1

    def direct(self, chosen, p, u2):
        """Return a DirectSample for each lane."""
        return self.image.sample(chosen.u, u2)


@dataclass(frozen=True)
class Emitter:
    """A shape that shines. Host."""

    shape_index: int  # in the compiled order
    shape: object
    twosided: bool
    area: float | None  # of one side; None if it is not sampled


class Lighting:
    """See the module docstring."""

    def __init__(self, lights, emitters, backgroundcolor, environment=None):
        """Hold lights of the file that rays cannot hit, Emitters, and a constant colour or an Environment for it."""
        self._groups, estimates, self._numbers = _groups(lights, emitters)
        self._environment, self._environment_number = environment, None
        if environment is not None and environment.shines:
            self._environment_number = len(estimates)
            self._groups.append(Surroundings(environment, len(estimates)))
            # half of what comes from everywhere together: a surface sees half of it, but mostly turned to the brightest
            estimates.append(Estimate(constant=2 * math.pi * environment.mean))
        self._choice = FewLights(estimates) if estimates else None
        self._shapes = [emitter.shape_index for emitter in emitters]
        records = [_emitter_record(emitter) for emitter in emitters]
        self._emitters = Rows(records) if records else None
        self._has_spheres = any(record[RADIUS] for record in records)
        self._has_one_sided = any(record[ONE_SIDED] for record in records)
        self._all_one_sided = all(record[ONE_SIDED] for record in records)
        self._world = Rows([backgroundcolor])
        self.has_lights = self._choice is not None
        self.has_emitters = bool(emitters)
        self.has_background = any(backgroundcolor) if environment is None else environment.shines

    @classmethod
    def of(cls, loaded, shapes, triangles):
        """Return the Lighting of a LoadedScene, its shapes [(index in the file, shape)] in the compiled order."""
        world = loaded.description.scene
        emitters = []
        for number, (index, shape) in enumerate(shapes):
            if any(shape.emission):
                light = index - len(world.shapes)
                twosided = shape.type in BOTH_SIDES if light < 0 else world.lightsources[light].twosided
                emitters.append(Emitter(number, shape, twosided, _area(shape)))
        lights = [light for light in world.lightsources if light.type in KINDS and any(light.intensity)]
        lights = [light for light in lights if KINDS[light.type].direct]
        return cls(lights, emitters, world.backgroundcolor, environment_of(loaded))

    def sample(self, p, u, u2):
        """Return a DirectSample for each point p; its pdf_sa includes the probability of choosing the light."""
        chosen = self._choice.choose(p, u)
        found = self._groups[0].direct(chosen, p, u2)
        for group in self._groups[1:]:
            found = dr.select(chosen.within(group.first, group.count), group.direct(chosen, p, u2), found)
        if self._choice.count > 1:
            some = chosen.probability > 0
            found.radiance = dr.select(some, found.radiance, Vector3f(0))
            found.pdf_sa = dr.select(some, found.pdf_sa * chosen.probability, 1)
        return found

    def emitted(self, o, d, hit, shape_index, surface, active):
        """Return the radiance that a hit surface sends back along the ray, and the density of this direction.

        The density is that with which `sample` chooses the direction at o; 0 for shapes that are not sampled.
        """
        masks = [active & (shape_index == number) for number in self._shapes]
        row = self._emitters.chosen(masks[1:])
        shines = masks[0]
        for mask in masks[1:]:
            shines = shines | mask
        cosine = -dr.dot(surface.n_geo, d)
        if self._all_one_sided:
            shines = shines & (cosine > 0)
        elif self._has_one_sided:
            shines = shines & ((cosine > 0) | (row[ONE_SIDED] == 0))
        radiance = dr.select(shines, row.vector(RADIANCE), Vector3f(0))
        if not self.has_lights:
            return radiance, Float(0)

        pdf_sa = area_pdf_sa(hit.t, abs(cosine), row[INVERSE_AREA])
        if self._has_spheres:
            round_pdf_sa = sphere.pdf_sa(o, surface.p, surface.n_geo, row[RADIUS])
            pdf_sa = dr.select(row[RADIUS] > 0, round_pdf_sa, pdf_sa)
        of_lights = [None] * self._choice.count
        for mask, light in zip(masks, self._numbers):
            if light is not None:
                of_lights[light] = mask
        return radiance, dr.select(shines, pdf_sa * self._choice.probability(o, of_lights), 0)

    def background(self, o, d):
        """Return the radiance of what is infinitely far away in a direction, and the density of `sample` for it."""
        if self._environment is None:
            return self._world[0].vector(0), Float(0)
        radiance, pdf_sa = self._environment.radiance(d)
        masks = [None] * self._choice.count
        masks[self._environment_number] = Bool(True)
        return radiance, pdf_sa * self._choice.probability(o, masks)


def environment_of(loaded):
    """Return the Environment of a LoadedScene, None if it has none; raises SceneError if its image cannot be read."""
    for index, light in enumerate(loaded.description.scene.lightsources):
        if light.type == "environment":
            try:
                pixels = read_environment(loaded.resolve(light.filename))
            except SceneError as error:
                raise loaded.refused(error, "scene", "lightsources", index, "filename") from error
            return Environment(pixels, light.intensity, light.rotation)
    return None


def _area(shape):
    """Return the area of one side of a shape that is sampled; None for others, and where float32 cannot hold it."""
    if shape.type in sheet.CODES:
        area = sheet.area(shape)
    elif shape.type == "sphere":
        area = 4 * math.pi * shape.radius**2
    else:
        return None
    return area if TINY < area < 1 / TINY else None


def _groups(lights, emitters):
    """Return the LightRows of lights and of the emitters that are sampled, each light's Estimate, and for each emitter
    the number of its light or None."""
    groups, estimates, numbers = [], [], [None] * len(emitters)
    for name in dict.fromkeys(light.type for light in lights):
        kind, own = KINDS[name], [light for light in lights if light.type == name]
        groups.append(LightRows(kind.direct, Rows([kind.pack(light) for light in own]), None, len(estimates)))
        estimates += [Estimate(**kind.estimate(light, luminance(light.intensity))) for light in own]
    for kind, names, directions in ((sheet, BOTH_SIDES, sheet.EDGES), (sphere, ("sphere",), ())):
        own = [k for k, emitter in enumerate(emitters) if emitter.area and emitter.shape.type in names]
        if not own:
            continue
        records = [kind.pack(emitters[k].shape, emitters[k].twosided) for k in own]
        groups.append(LightRows(kind.sample, Rows(records, directions=directions), kind.features(records), len(estimates)))
        for k in own:
            numbers[k] = len(estimates)
            shape = emitters[k].shape
            estimates.append(Estimate(**kind.estimate(shape, emitters[k].twosided, luminance(shape.emission))))
    return groups, estimates, numbers


def _emitter_record(emitter):
    """Return the record of a shape that shines, in the columns above."""
    radius = emitter.shape.radius if emitter.area and emitter.shape.type == "sphere" else 0.0
    return [*emitter.shape.emission, 1 / emitter.area if emitter.area else 0.0, float(not emitter.twosided), radius]
