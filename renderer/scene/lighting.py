"""Where light comes from in path-traced scenes: lights to sample, shapes that shine, and what is behind everything.

Lights are numbered in groups of one kind. This is the only place that goes from a lane's light, or from the shape that
it met, to the kind of light. Boxes, cylinders, convex volumes and planes that shine are not sampled: paths find them,
as they find a constant background. That has a third of the error x time of sampling it too, because a direction from
the BSDF meets it nearly always.
"""

from __future__ import annotations

import functools
import operator

import drjit as dr

from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.packets import Packets
from renderer.core.rows import SELECT_LIMIT, Rows
from renderer.lights import sphere
from renderer.lights.base import area_pdf_sa
from renderer.scene.light_choice import FEW, FewLights, ManyLights
from renderer.scene.light_sources import environment_of, extent, light_groups

RADIANCE, INVERSE_AREA, ONE_SIDED, RADIUS, LIGHT = 0, 3, 4, 5, 6  # columns of emitters
NO_EMITTER = 0xFFFFFFFF


class Lighting:
    """See the module docstring.

    `has_lights` tells whether `sample` can be called, `has_emitters` and `has_background` whether `emitted` and
    `background` bring anything, `has_image` whether there is an image all around.
    """

    def __init__(self, groups, choice, emitters, background, environment, environment_number):
        """Hold groups of lights with a choice among them, emitters, and a colour or an Environment around all."""
        self._groups, self._choice, self._emitters = groups, choice, emitters
        self._environment, self._environment_number = environment, environment_number
        self._background = Rows([background])
        self.has_lights = choice is not None
        self.has_emitters = emitters is not None
        self.has_image = environment is not None
        self.has_background = any(background) if environment is None else environment.shines

    @classmethod
    def of(cls, loaded, shapes, triangles, emitters):
        """Return the Lighting of a LoadedScene.

        `shapes` are [(index in the file, shape)] in the compiled order, `emitters` those that shine.

        Raises SceneError if the image of an environment cannot be read.
        """
        world = loaded.description.scene
        environment = environment_of(loaded)
        groups, estimates, numbers = light_groups(world.lightsources, emitters, environment, triangles)
        choice, number = None, None
        if len(estimates) > FEW:
            choice = ManyLights(estimates, *extent(shapes, triangles, estimates))
        elif estimates:
            choice = FewLights(estimates)
        if environment is not None and environment.shines:
            number = len(estimates) - 1
        kind = FewEmitters if len(emitters) <= SELECT_LIMIT else ManyEmitters
        found = kind(emitters, numbers, len(shapes)) if emitters else None
        return cls(groups, choice, found, world.backgroundcolor, environment, number)

    def sample(self, p, u, u2):
        """Return a DirectSample for each point p; its pdf_sa includes the probability of choosing the light."""
        chosen = self._choice.choose(p, u, u2.x)
        u2 = type(u2)(chosen.v, u2.y)
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
        emitters = self._emitters
        shines, row, light = emitters.at(shape_index, active)
        cosine = -dr.dot(surface.n_geo, d)
        if emitters.all_one_sided:
            shines = shines & (cosine > 0)
        elif emitters.any_one_sided:
            shines = shines & ((cosine > 0) | (row[ONE_SIDED] == 0))
        radiance = dr.select(shines, row.vector(RADIANCE), Vector3f(0))
        if light is None:
            return radiance, Float(0)

        pdf_sa = Float(0)
        if emitters.any_flat:
            pdf_sa = area_pdf_sa(hit.t, abs(cosine), row[INVERSE_AREA])
        if emitters.any_round:
            round_pdf_sa = sphere.pdf_sa(o, surface.p, surface.n_geo, row[RADIUS])
            pdf_sa = dr.select(row[RADIUS] > 0, round_pdf_sa, pdf_sa) if emitters.any_flat else round_pdf_sa
        return radiance, dr.select(shines, pdf_sa * self._choice.probability(o, light), 0)

    def background(self, o, d):
        """Return the radiance of what is infinitely far away in a direction, and the density of `sample` for it."""
        if self._environment is None:
            return self._background[0].vector(0), Float(0)
        radiance, pdf_sa = self._environment.radiance(d)
        return radiance, pdf_sa * self._choice.probability(o, Light({self._environment_number: Bool(True)}))


class Light:
    """Which light each lane means: that whose mask is true, of {number: mask}, or None at all."""

    def __init__(self, masks):
        self.masks = masks

    @property
    def number(self):
        """The number of the light; any where no mask is true."""
        (number, _), *others = self.masks.items()
        number = UInt32(number)
        for other, mask in others:
            number = dr.select(mask, UInt32(other), number)
        return number


class LightNumber:
    """Which light each lane means, by its number."""

    def __init__(self, number, numbers):
        """Hold a number in lanes, one of `numbers`."""
        self.number = number
        self.masks = {known: number == known for known in numbers} if len(numbers) <= FEW else {}


class Emitters:
    """What is common to the emitters of a scene, in records with the columns above."""

    def __init__(self, emitters, numbers):
        sides = {emitter.twosided for emitter in emitters}
        self.any_one_sided, self.all_one_sided = False in sides, sides == {False}
        sampled = [emitter for emitter in emitters if emitter.area]
        self.any_round = any(emitter.radius for emitter in sampled)
        self.any_flat = any(not emitter.radius for emitter in emitters)
        self._records = [
            [*emitter.shape.emission, 1 / emitter.area if emitter.area else 0.0, float(not emitter.twosided),
             emitter.radius, float(number or 0)]
            for emitter, number in zip(emitters, numbers)
        ]  # fmt: skip


class FewEmitters(Emitters):
    """Emitters that are looked for one after the other."""

    def __init__(self, emitters, numbers, shape_count):
        super().__init__(emitters, numbers)
        self._shapes, self._numbers = [emitter.shape_index for emitter in emitters], numbers
        self._rows = Rows(self._records)

    def at(self, shape_index, active):
        """Return whether each lane's shape is an emitter, its record, and its light (None if none is sampled)."""
        masks = [active & (shape_index == number) for number in self._shapes]
        lights = {number: mask for number, mask in zip(self._numbers, masks) if number is not None}
        return functools.reduce(operator.or_, masks), self._rows.chosen(masks[1:]), Light(lights) if lights else None


class ManyEmitters(Emitters):
    """Emitters that are found by a table over all shapes."""

    def __init__(self, emitters, numbers, shape_count):
        super().__init__(emitters, numbers)
        places = [[NO_EMITTER]] * shape_count
        for place, emitter in enumerate(emitters):
            places[emitter.shape_index] = [place]
        self._places, self._packets = Rows(places, UInt32), Packets(self._records)
        self._numbers = [number for number in numbers if number is not None]

    def at(self, shape_index, active):
        """Return whether each lane's shape is an emitter, its record, and its light (None if none is sampled)."""
        place = self._places.row(shape_index, active)[0]
        shines = active & (place != NO_EMITTER)
        row = self._packets.row(place, shines)
        return shines, row, LightNumber(UInt32(row[LIGHT]), self._numbers) if self._numbers else None
