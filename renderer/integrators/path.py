"""Path tracing: light that reaches the camera over up to `nbounces` surfaces [Kajiya1986].

At every surface one direction is drawn from a light and one from the BSDF; light that either may find is weighted by
the power heuristic [Veach1997, sec. 9.2]. The next segment follows the BSDF's direction. From the fourth bounce on, a
path ends at random with the probability of what it has lost [Arvo1990], unless the scene forbids it.

Where the scene has lamps and mirrors of simple forms, a third direction is drawn: over a mirror to a lamp
(scene/mirrors.py). It competes with paths that find the lamp in the mirror.

Numbers: three pairs a vertex: choice of light and of lobe, point on the light, direction from the BSDF; the roulette
takes a fourth dimension, light over mirrors two more pairs.

Two drivers share the vertex. Where all shapes are tested one after the other, a step is a whole vertex with its
shadow ray. Where rays go through a hierarchy, their ways differ in length: there a step is a few records of the way of
either ray, after which the lanes that have arrived are shaded, so that none waits for the longest way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr

from renderer.accel.bvh import Bvh, Walk
from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.numeric import FAR, LEAST_NORMAL, greater, lesser
from renderer.core.records import NO_SHAPE, Hit, Ray, Surface
from renderer.integrators.base import register
from renderer.integrators.mis import power_heuristic
from renderer.samplers.base import PATH, Draws
from renderer.scene.geometry import SHADOW_END, leave
from renderer.scene.mirrors import Reflection, Spread
from renderer.scene.scattering import Look
from renderer.scene.schema import PATHTRACER

DIMENSIONS = 6  # of a vertex
CHOICES, ON_LIGHT, DIRECTION, ROULETTE, MIRROR, ON_LAMP = range(DIMENSIONS)
ROULETTE_DEPTH = 4  # the first bounce at which it is played
MOST_SURVIVAL = 0.95  # so that no path goes on for ever
STEPS = 5  # through the hierarchy between shadings, at most


@dataclass
class Mirrored:
    """A segment that leaves a mirror, which a path went to from a surface that is none."""

    pdf_sa: Float  # of the direction to the mirror, by the BSDF there; 0 for segments that are none of these
    spread: Spread


@dataclass
class Path:
    """The segment of each lane, and what the path is worth."""

    o: Vector3f
    d: Vector3f
    left_index: UInt32  # the primitive it left, NO_SHAPE for the camera
    left_inwards: Bool
    throughput: Vector3f  # share of the radiance along the segment that reaches the camera
    pdf_sa: Float  # of the segment's direction, by its BSDF; 0 where it was the only one possible
    eta: Float  # index of refraction here over that at the camera: radiance in glass is seen scaled by its square
    depth: UInt32  # bounces so far
    mirrored: Mirrored | None = None  # None in scenes without lamps in mirrors

    @property
    def ray(self):
        """The segment as a ray."""
        return Ray(self.o, self.d, self.left_index, self.left_inwards)


@dataclass
class Vertex:
    """What a path finds at the end of its segment."""

    radiance: Vector3f  # reaches the camera
    direct: Vector3f | None  # also reaches it where `towards_light` is not blocked; None without lights
    towards_light: Ray | None
    distance: Float | None  # of the light, scene units
    alive: Bool  # whether the path goes on
    path: Path  # along its next segment
    reflected: Vector3f | None = None  # also reaches it where `towards_mirror` meets the mirror of `way`, then the lamp
    towards_mirror: Ray | None = None
    way: Reflection | None = None


@dataclass
class Interaction:
    """The surface at the end of a path's segment."""

    path: Path
    hit: Hit
    shape: UInt32  # its number in the compiled order
    surface: Surface
    look: Look
    active: Bool  # whether the path may bounce there
    dimension: UInt32  # the first of its random numbers

    def leave(self, direction):
        """Return the ray that goes on from there."""
        return leave(self.surface, self.hit.index, direction)


@register(PATHTRACER)
def path_tracer(scene, bounces):
    """Return the integrator for a PathScene."""
    return (WalkingPathTracer if isinstance(scene.structure, Bvh) else PathTracer)(scene, bounces)


class PathTracer:
    """A step is a vertex; see the module docstring."""

    uneven = False

    def __init__(self, scene, bounces):
        self._scene = scene
        self._limit = dr.opaque(UInt32, bounces)
        self._mirrors = scene.mirrors
        self.looks_ahead = scene.lighting.has_background and not scene.empty  # else next to all rays hit something

    def start(self, lanes):
        """Return lanes without a ray."""
        path = dr.zeros(Path, lanes)
        path.mirrored = dr.zeros(Mirrored, lanes) if self._mirrors else None
        return path

    def restart(self, path, where, o, d):
        """Return the path with fresh camera rays in the lanes `where`."""
        return dr.select(where, self._fresh(o, d), path)

    def trace(self, path):
        """Return what the segments hit."""
        return self._scene.intersect(path.ray)

    def missed(self, path):
        """Return what reaches the camera along segments that hit nothing."""
        arriving, pdf_sa = self._scene.lighting.background(path.o, path.d)
        return path.throughput * arriving * _weight(path, pdf_sa)

    def step(self, path, draws, hit=None):
        """Return what the segment and the light at its end bring, whether the path goes on, and the next segment."""
        if hit is None or not self._scene.lighting.has_image:
            return self._shaded(path, hit or self.trace(path), draws)
        # an image is costly to look up and to sample, also for packets of lanes that all look past everything
        behind = self.missed(path)

        def shaded(path, hit, sample):
            return self._shaded(path, hit, Draws(draws.sampler, sample))

        def skipped(path, hit, sample):
            return behind, Bool(False), path

        return dr.if_stmt((path, hit, draws.sample), hit.valid, shaded, skipped, label="shading")

    def _shaded(self, path, hit, draws):
        """Return the same for segments with known ends."""
        vertex = self._vertex(path, hit, draws)
        radiance = vertex.radiance
        if vertex.direct is not None:
            reaches = _any(vertex.direct)
            hidden = self._scene.occluded(vertex.towards_light, vertex.distance, reaches)
            radiance += dr.select(hidden, 0, vertex.direct)
        if vertex.reflected is not None:
            radiance += dr.select(self._arrives(vertex.towards_mirror, vertex.way), vertex.reflected, 0)
        return radiance, vertex.alive, vertex.path

    def _arrives(self, ray, way):
        """Return whether a ray meets the mirror that it is meant for, and goes on from there to the lamp."""
        first = self._scene.intersect(ray)
        onward = leave(Surface(way.x, way.n), way.mirror, way.to_lamp)
        return (first.index == way.mirror) & (self._scene.intersect(onward).index == way.lamp)

    def _fresh(self, o, d):
        """Return the first segments of paths."""
        mirrored = Mirrored(Float(0), Spread(Float(0), Float(0), Float(0))) if self._mirrors else None
        return Path(o, d, UInt32(NO_SHAPE), Bool(False), Vector3f(1), Float(0), Float(1), UInt32(0), mirrored)

    def _vertex(self, path, hit, draws):
        """Return the Vertex at a segment's end."""
        scene, lighting, ray = self._scene, self._scene.lighting, path.ray
        radiance = dr.select(hit.valid, Vector3f(0), self.missed(path)) if lighting.has_background else Vector3f(0)
        if scene.empty:
            return Vertex(radiance, None, None, None, Bool(False), path)

        scattering = scene.scattering
        surface = scene.surface(ray, hit, scattering.with_uv, scattering.with_tangents)
        shape = scene.shape_of(hit)
        if lighting.has_emitters:
            arriving, pdf_sa = lighting.emitted(path.o, path.d, hit, shape, surface, hit.valid)
            weight = _weight(path, pdf_sa)
            if self._mirrors:
                weight *= self._weight_in_mirror(path, hit, shape, surface)
            radiance += dr.select(hit.valid, path.throughput * arriving * weight, 0)

        active = hit.valid & (path.depth < self._limit)
        look, dimension = scattering.at(shape, surface, active), path.depth * DIMENSIONS + PATH
        here = Interaction(path, hit, shape, surface, look, active, dimension)
        choices = draws.u2(dimension + CHOICES)
        vertex = Vertex(radiance, None, None, None, None, None)
        if self._mirrors:
            self._look_into_mirrors(vertex, here, draws)
        if lighting.has_lights and scattering.smooth:
            self._look_at_light(vertex, here, choices.x, draws)
        self._go_on(vertex, here, choices.y, draws)
        return vertex

    def _look_at_light(self, vertex, here, u, draws):
        """Let the vertex draw a direction to one of the lights."""
        light = self._scene.lighting.sample(here.surface.p, u, draws.u2(here.dimension + ON_LIGHT))
        value, pdf_sa = here.look.evaluate(-here.path.d, light.wo)
        share = _light_share(light, pdf_sa) / greater(light.pdf_sa, Float(LEAST_NORMAL))
        vertex.direct = dr.select(here.active, here.path.throughput * value * light.radiance * share, 0)
        vertex.towards_light, vertex.distance = here.leave(light.wo), light.distance

    def _look_into_mirrors(self, vertex, here, draws):
        """Let the vertex draw a way over a mirror to a lamp."""
        path, numbers = here.path, [draws.u2(here.dimension + dimension) for dimension in (MIRROR, ON_LAMP)]
        way = self._mirrors.sample(here.surface.p, *numbers)
        value, pdf_sa = here.look.evaluate(-path.d, way.wo)
        weight = power_heuristic(way.pdf_sa, pdf_sa) / greater(way.pdf_sa, Float(LEAST_NORMAL))
        last = path.depth + 1 >= self._limit  # the mirror is a bounce too
        vertex.reflected = dr.select(here.active & ~last, path.throughput * value * way.radiance * weight, 0)
        vertex.way, vertex.towards_mirror = way, here.leave(way.wo)

    def _go_on(self, vertex, here, u, draws):
        """Let the vertex draw the path's next segment from the BSDF, and whether there is one."""
        path = here.path
        scattered = here.look.sample(-path.d, u, draws.u2(here.dimension + DIRECTION))
        onward = here.leave(scattered.wo)
        throughput, eta = path.throughput * scattered.weight, path.eta * scattered.eta
        vertex.alive = here.active & _any(throughput)
        if self._scene.roulette:
            worth = greater(throughput.x, greater(throughput.y, throughput.z)) * dr.square(eta)
            survival = dr.select(path.depth < ROULETTE_DEPTH - 1, Float(1), lesser(worth, Float(MOST_SURVIVAL)))
            vertex.alive &= draws.u1(here.dimension + ROULETTE) < survival
            throughput *= dr.rcp(survival)
        pdf_sa = dr.select(scattered.delta, 0, scattered.pdf_sa)
        mirrored = self._mirrored(here, scattered) if self._mirrors else None
        vertex.path = Path(onward.o, onward.d, onward.left_index, onward.left_inwards, throughput, pdf_sa, eta,
                           path.depth + 1, mirrored)

    def _mirrored(self, here, scattered):
        """Return what tells, of the segments that leave mirrors, how else lamps at their ends might be found."""
        path = here.path
        known, spread = self._mirrors.spread(here.shape, -dr.dot(here.surface.n_geo, path.d), here.hit.t)
        known = known & scattered.delta & (path.pdf_sa > 0)
        return Mirrored(dr.select(known, path.pdf_sa, 0), spread)

    def _weight_in_mirror(self, path, hit, shape, surface):
        """Return the weight of a lamp that was met over a mirror, which a way drawn to it might have found as well."""
        cosine = dr.dot(surface.n_geo, path.d)
        other = self._mirrors.pdf_sa(shape, cosine, hit.t, path.mirrored.spread)
        return dr.select(path.mirrored.pdf_sa > 0, power_heuristic(path.mirrored.pdf_sa, other), Float(1))


@dataclass
class Journey:
    """A path whose rays are on their way through a hierarchy."""

    path: Path
    goes_on: Bool  # whether the path does after the ray towards a light that is on its way
    to_light: Bool  # whether that is the ray on its way, and not the path's own segment
    begins: Bool  # whether that ray has not been tested against anything yet
    light_d: Vector3f
    light_o: Vector3f
    light_inwards: Bool
    pending: Vector3f  # arrives if nothing is between the path and the light
    t: Float
    index: UInt32
    record: UInt32 | None  # that of `index`; None where surfaces do not need it
    walk: Walk

    @property
    def ray(self):
        """The ray on its way; both leave the same primitive."""
        path, towards = self.path, self.to_light
        o, d = dr.select(towards, self.light_o, path.o), dr.select(towards, self.light_d, path.d)
        return Ray(o, d, path.left_index, dr.select(towards, self.light_inwards, path.left_inwards))


class WalkingPathTracer(PathTracer):
    """A step is part of a ray's way through the hierarchy; see the module docstring."""

    uneven = True

    def __init__(self, scene, bounces):
        super().__init__(scene, bounces)
        self.looks_ahead, self._mirrors = False, None
        asks = scene.scattering.with_uv or scene.scattering.with_tangents
        self._by_record = not asks and scene.triangles is not None and scene.triangles.as_in_records

    def start(self, lanes):
        """Return lanes without a ray."""
        nowhere, no, zero = dr.zeros(Vector3f, lanes), dr.zeros(Bool, lanes), dr.zeros(Float, lanes)
        return Journey(dr.zeros(Path, lanes), no, no, no, nowhere, nowhere, no, nowhere, zero,
                       dr.zeros(UInt32, lanes), dr.zeros(UInt32, lanes) if self._by_record else None,
                       self._scene.structure.start(lanes))

    def restart(self, journey, where, o, d):
        """Return the journey with fresh camera rays in the lanes `where`."""
        journey.path = dr.select(where, self._fresh(o, d), journey.path)
        return self._sent(journey, where, Bool(False), Float(FAR))

    def step(self, journey, draws):
        """Return what arrives at the camera, whether the path is still on its way, and its next state."""
        walk, t, index, record, active = self._walked(journey)
        arrived = ~active & journey.to_light
        radiance = dr.select(arrived & (index == NO_SHAPE), journey.pending, 0)

        ended = ~active & ~journey.to_light
        vertex = self._reached(journey.path, Hit(t, dr.select(ended, index, NO_SHAPE), record), draws)
        radiance += dr.select(ended, vertex.radiance, 0)
        onward, asks = ended & vertex.alive, Bool(False)
        journey = replace(journey, path=dr.select(ended, vertex.path, journey.path), begins=Bool(False),
                          t=t, index=index, record=record, walk=walk)
        if vertex.direct is not None:
            asks, towards = ended & _any(vertex.direct), vertex.towards_light
            journey.light_o = dr.select(asks, towards.o, journey.light_o)
            journey.light_d = dr.select(asks, towards.d, journey.light_d)
            journey.light_inwards = dr.select(asks, towards.left_inwards, journey.light_inwards)
            journey.pending = dr.select(asks, vertex.direct, journey.pending)
            journey = self._sent(journey, asks, Bool(True), vertex.distance * SHADOW_END)
        follows = (onward & ~asks) | (arrived & journey.goes_on)
        journey.goes_on = dr.select(ended, onward, journey.goes_on)
        return radiance, active | asks | follows, self._sent(journey, follows, Bool(False), Float(FAR))

    def _walked(self, journey):
        """Return walk, distance, index, record and whether they are still on their way, of rays after some steps."""
        scene, structure, ray = self._scene, self._scene.structure, journey.ray
        slabs, leaf = structure.slabs(ray), scene.leaf_test(ray)
        t, index = scene.loose_hit(ray, journey.t)
        t, index = dr.select(journey.begins, t, journey.t), dr.select(journey.begins, index, journey.index)
        active = slabs.valid & ~(journey.to_light & (index != NO_SHAPE))

        def one(k, walk, t, index, record, active):
            at, before = walk.record, index
            walk, t, index, active = structure.step(
                walk, structure.fetch(walk, active), slabs, t, index, leaf, active, journey.to_light
            )
            if self._by_record:
                record = dr.select(index == before, record, at)
            return k + 1, walk, t, index, record, active

        # a loop, because less code runs faster, and because packets without a lane on its way are done at once
        return dr.while_loop(
            (dr.zeros(UInt32, dr.width(t)), journey.walk, t, index, journey.record, active),
            lambda k, walk, t, index, record, active: active & (k < STEPS), one, label="steps",
        )[1:]

    def _reached(self, path, hit, draws):
        """Return the Vertex at a segment's end; packets whose segments have all hit nothing are not shaded."""
        lighting, smooth = self._scene.lighting, self._scene.scattering.smooth
        behind = self.missed(path) if lighting.has_background else Vector3f(0)

        def skipped(path, hit):
            if not (lighting.has_lights and smooth):
                return Vertex(behind, None, None, None, Bool(False), path)
            return Vertex(behind, Vector3f(0), path.ray, Float(0), Bool(False), path)

        return dr.if_stmt(
            (path, hit), hit.valid, lambda path, hit: self._vertex(path, hit, draws), skipped, label="shading"
        )

    @staticmethod
    def _sent(journey, where, to_light, end):
        """Return the journey with the rays `where` at the root of the hierarchy, to go up to the distance `end`."""
        walk = journey.walk
        journey.walk = Walk(dr.select(where, 0, walk.record), dr.select(where, 0, walk.height), walk.top, walk.stack)
        journey.t, journey.index = dr.select(where, end, journey.t), dr.select(where, NO_SHAPE, journey.index)
        journey.to_light, journey.begins = dr.select(where, to_light, journey.to_light), where | journey.begins
        return journey


def _any(colour):
    """Return whether any channel is not 0 or less; True for NaN, so that what went wrong is followed and noticed."""
    return ~((colour.x <= 0) & (colour.y <= 0) & (colour.z <= 0))


def _light_share(light, bsdf_pdf_sa):
    """Return the weight of light that was sampled, and that the BSDF might have found as well."""
    return dr.select(light.delta, Float(1), power_heuristic(light.pdf_sa, bsdf_pdf_sa))


def _weight(path, light_pdf_sa):
    """Return the weight of light that a path ran into, which a light might have sent to its last vertex as well."""
    return dr.select(path.pdf_sa > 0, power_heuristic(path.pdf_sa, light_pdf_sa), Float(1))
