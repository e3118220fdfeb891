"""Phong mode: Blinn-Phong shading with hard shadows, mirror reflection and glass, after Whitted [Whitted1980].

Local colour, summed over the lights that are visible and in front (N.L > 0):
  I (kd Cd N.L + ks Cs (N.H)^e), plus ambient Cd; N faces the viewer, H = unit(L + V) [Blinn1977].
A mirror or glass with share rho gives (1 - rho) local + rho reflected; for glass the second part is split by the
Fresnel equations between reflected and refracted ray, both of which are followed, to the last bounce. A ray without
bounces left, or without a hit, brings the background's colour.

With more than one sample a pixel, samples are spread over what is not sharp: a lamp is a light at a random one of its
points, and a rough mirror reflects at a random one of the normals that are seen of its GGX distribution, at full
weight.

Numbers: a pair for each lamp and one for a rough mirror, at each depth of the tree; branches of a depth share them.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.elementary import exp2, log2_below_1
from renderer.core.frame import Frame
from renderer.core.fresnel import dielectric, reflect, refract
from renderer.core.numeric import TINY, greater, lesser
from renderer.core.records import NO_SHAPE, Ray
from renderer.core.rows import repeat
from renderer.integrators.base import register
from renderer.samplers.base import PATH
from renderer.scene.compiled import ALPHA, ETA, EXPONENT, GLASS, KD, SHARE, SPECULAR
from renderer.scene.geometry import leave
from renderer.scene.schema import MAX_BOUNCES

# One segment a level waits while its sibling is followed. The size is the same for every scene, and appears in the
# kernel as the greatest index: Dr.Jit 1.5 takes kernels that differ only in the size of local memory for the same one.
STACK_SIZE = MAX_BOUNCES
STACK_TOP = STACK_SIZE - 1
MOST_UNROLLED_LIGHTS = 4  # each brings a shadow test of all shapes into the kernel


@dataclass
class Segment:
    """A ray on its way, and what it is worth."""

    o: Vector3f
    d: Vector3f
    left_index: UInt32  # the shape it left, NO_SHAPE for the camera
    left_inwards: UInt32  # 0 or 1, because Dr.Jit 1.5 compiles no masks in local memory
    weight: Float  # share of its radiance in the pixel
    depth: UInt32  # bounces so far


@dataclass
class Tree:
    """The ray tree of each lane: the segment at hand, and those that wait."""

    now: Segment
    waiting: dr.Local | None  # stack of Segments; None without glass
    waiting_count: UInt32


@register("phong")
class Phong:
    """See the module docstring. Without mirrors and glass a lane ends after one step and nothing else is compiled."""

    looks_ahead = False
    uneven = False

    def __init__(self, scene, bounces):
        self._scene = scene
        self._limit = dr.opaque(UInt32, bounces)
        # of random numbers a depth: one for the mirror, one for each lamp
        self._pairs = 1 + sum(group.rows.count for group in scene.lights if group.kind.extended)

    def start(self, lanes):
        """Return lanes without a ray."""
        now = dr.zeros(Segment, lanes)
        waiting = dr.alloc_local(Segment, STACK_SIZE) if self._scene.has_glass else None
        return Tree(now, waiting, dr.zeros(UInt32, lanes))

    def restart(self, tree, where, o, d):
        """Return the tree with fresh camera rays in the lanes `where`."""
        fresh = Segment(o, d, UInt32(NO_SHAPE), UInt32(0), Float(1), UInt32(0))
        return Tree(dr.select(where, fresh, tree.now), tree.waiting, tree.waiting_count)

    def step(self, tree, draws):
        """Return what the segment at hand brings, whether the lane has another one, and the tree with that one."""
        scene, now = self._scene, tree.now
        ray = Ray(now.o, now.d, now.left_index, now.left_inwards != 0) if scene.has_mirrors else Ray(now.o, now.d)
        hit = scene.intersect(ray)
        if scene.empty:
            return now.weight * scene.behind(ray.d), Bool(False), tree

        surface = scene.surface(ray, hit, with_uv=scene.texture is not None)
        material = scene.material(hit)
        entering = dr.dot(surface.n_geo, ray.d) < 0
        n = _facing(surface, entering, ray.d)
        dimension = now.depth * self._pairs + PATH if scene.has_mirrors else PATH
        local = self._local(hit, surface, material, n, -ray.d, draws, dimension)
        if not scene.has_mirrors:
            return now.weight * dr.select(hit.valid, local, scene.behind(ray.d)), Bool(False), tree

        cos_i = -dr.dot(n, ray.d)
        direction = reflect(ray.d, n, cos_i)
        if scene.has_rough_mirrors:
            direction = _blurred(direction, n, ray.d, material[ALPHA], draws.u2(dimension))
        share = dr.select(hit.valid, material[SHARE], 0)
        last = now.depth >= self._limit
        behind = scene.behind(ray.d if scene.environment is None else dr.select(hit.valid, direction, ray.d))
        radiance = dr.select(hit.valid, (1 - share) * local, behind)
        radiance = now.weight * (radiance + dr.select(last, share, 0) * behind)
        onward = (share > 0) & ~last

        mirrored = self._segment(now, surface, hit, direction, share)
        if not scene.has_glass:
            return radiance, onward, Tree(mirrored, None, tree.waiting_count)
        eta = dr.select(entering, material[ETA], dr.rcp(material[ETA]))
        reflectance, cos_t = dielectric(cos_i, eta)
        reflectance = dr.select(material[GLASS] > 0, reflectance, 1)
        through = self._segment(
            now, surface, hit, refract(ray.d, n, cos_i, cos_t, eta), share * (1 - reflectance)
        )
        mirrored.weight *= reflectance
        return radiance, *self._branch(tree, mirrored, through, onward)

    def _local(self, hit, surface, material, n, wi, draws, dimension):
        """Return the colour of the surface itself, shadows included; lamps take pairs of numbers after `dimension`."""
        scene = self._scene
        diffuse = scene.diffuse_colour(hit, surface, material)
        kd_diffuse, specular, exponent = material[KD] * diffuse, material.vector(SPECULAR), material[EXPONENT]
        colour = scene.ambient * diffuse

        for group in scene.lights:
            random = scene.random and group.kind.extended

            def add(k, colour, group=group, random=random, dimension=dimension):
                u2 = draws.u2(dimension + 1 + k) if random else None
                light = group.kind.sample(group.rows[k], surface.p, u2)
                cos_o = dr.dot(n, light.wo)
                facing = hit.valid & (cos_o > 0)
                lit = facing & ~scene.occluded(leave(surface, hit.index, light.wo), light.distance, facing)
                shine = specular * highlight(n, wi, light.wo, exponent)
                return (colour + dr.select(lit, light.radiance * (kd_diffuse * cos_o + shine), 0),)

            unroll, label = scene.light_count <= MOST_UNROLLED_LIGHTS, f"lights {group.kind.name}"
            (colour,) = repeat(group.rows.count, add, (colour,), label, unroll)
            dimension = dimension + group.rows.count if random else dimension
        return colour

    @staticmethod
    def _segment(now, surface, hit, direction, share):
        """Return the segment that goes on from a hit."""
        ray = leave(surface, hit.index, direction)
        inwards = dr.select(ray.left_inwards, UInt32(1), 0)
        return Segment(ray.o, ray.d, ray.left_index, inwards, now.weight * share, now.depth + 1)

    def _branch(self, tree, mirrored, through, onward):
        """Return whether lanes go on, and the tree: at hand is a child, whose sibling waits, or one that waited."""
        goes_back, goes_through = onward & (mirrored.weight > 0), onward & (through.weight > 0)
        both = goes_back & goes_through
        tree.waiting.write(mirrored, lesser(tree.waiting_count, UInt32(STACK_TOP)), both)
        count = tree.waiting_count + dr.select(both, UInt32(1), 0)

        ended = ~goes_back & ~goes_through
        waits = ended & (count > 0)
        count = dr.select(waits, count - 1, count)
        waiting = tree.waiting.read(count, waits)
        now = dr.select(goes_through, through, mirrored)
        return ~ended | waits, Tree(dr.select(waits, waiting, now), tree.waiting, count)


def highlight(n, wi, wo, exponent):
    """Return (n.h)^exponent for unit directions, h between wi and wo; 1 at exponent 0, also of n.h <= 0.

    What n.h lacks of 1 is |h - n|^2 / 2, which rounding of lengths does not change.
    """
    h = dr.normalize(wi + wo)
    return exp2(log2_below_1(greater(dr.dot(n, h), TINY), 0.5 * dr.squared_norm(h - n)) * exponent)


def _blurred(mirrored, n, d, alpha, u2):
    """Return the direction in which a rough surface reflects d; `mirrored` where alpha is 0.

    Directions into the surface are reflected at it once more, so that no light is lost.
    """
    from renderer.bsdfs import microfacet  # other scenes start faster without

    frame = Frame.of(n)
    wi = frame.to_local(-d)
    width = greater(alpha, Float(microfacet.ALPHA_MIN))
    wo = microfacet.reflect(wi, microfacet.Ggx(width, width).sample(wi, u2))
    return dr.select(alpha > 0, frame.to_world(Vector3f(wo.x, wo.y, abs(wo.z))), mirrored)


def _facing(surface, entering, d):
    """Return the normal to shade with, turned to where the ray comes from.

    Near its outline a smooth mesh has interpolated normals that point away from who looks at it; the triangle's own
    normal serves there.
    """
    n_geo = dr.select(entering, surface.n_geo, -surface.n_geo)
    if surface.n_smooth is None:
        return n_geo
    n = dr.select(entering, surface.n_smooth, -surface.n_smooth)
    return dr.select(dr.dot(n, d) < 0, n, n_geo)
