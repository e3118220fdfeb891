"""The scene as a kernel sees it: what is asked of it in lanes, with only the kinds that it has compiled in.

This is the only place that goes from a lane's shape index to the kind of the shape.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from renderer.core import rows
from renderer.core.backend import Float, UInt32, Vector2f, Vector3f
from renderer.core.numeric import EPSILON, FAR, LEAVE_ULPS, greater
from renderer.core.records import NO_SHAPE, Hit, Ray, Surface
from renderer.core.rows import Rows, repeat
from renderer.lights.base import LightKind
from renderer.shapes.base import ShapeKind

# columns of the material records
DIFFUSE, KD, SPECULAR, EXPONENT, SHARE, GLASS, ETA, SCALE_U, SCALE_V = 0, 3, 4, 7, 8, 9, 10, 11, 12
# columns of the texture records: three for the kind's own use, then which lookup is meant
TEXTURE_KIND, NOT_TEXTURED = 3, 0
# a shadow ray ends this many roundoffs before its light, so that a light on a surface is not hidden by it
SHADOW_END = 1 - 8 * EPSILON


@dataclass(frozen=True)
class ShapeGroup:
    """All shapes of one kind; their indices run from `first` on."""

    kind: ShapeKind
    rows: Rows
    first: int

    def holds(self, index):
        """Return whether a lane's shape is one of these."""
        return (index >= self.first) & (index < self.first + self.rows.count)


@dataclass(frozen=True)
class LightGroup:
    """All lights of one kind."""

    kind: LightKind
    rows: Rows


@dataclass(frozen=True)
class CompiledScene:
    """Device data and the list of what the scene has; see the module docstring."""

    shapes: tuple[ShapeGroup, ...]
    lights: tuple[LightGroup, ...]
    world: Rows  # one record: backgroundcolor, ambientlight
    materials: Rows | None  # by shape index; None without shapes
    file_indices: Rows | None  # by shape index: its place in the file
    texture_rows: Rows | None  # by shape index; None where nothing is textured
    textures: tuple[Callable, ...]  # lookups (record, uv, active) -> colour; records name them from 1
    has_mirrors: bool
    has_glass: bool

    @property
    def background(self):
        """Colour of what is behind everything."""
        return self.world[0].vector(0)

    @property
    def ambient(self):
        """Light from everywhere."""
        return self.world[0].vector(3)

    @property
    def light_count(self):
        """Number of lights."""
        return sum(group.rows.count for group in self.lights)

    @property
    def _unroll(self):
        """Whether loops over shapes are unrolled: by the number of all shapes, because all are in one kernel."""
        return sum(group.rows.count for group in self.shapes) <= rows.UNROLL_LIMIT

    def intersect(self, ray):
        """Return the closest hit of each ray."""
        t, index = Float(FAR), UInt32(NO_SHAPE)
        t_min = _closest_allowed(ray)
        for group in self.shapes:

            def closer(k, t, index, group=group):
                this = group.first + k
                distance, valid = _distance(group, k, ray, t_min)
                closer = valid & (distance < t)
                return dr.select(closer, distance, t), dr.select(closer, this, index)

            t, index = repeat(group.rows.count, closer, (t, index), f"intersect {group.kind.name}", self._unroll)
        return Hit(t, index)

    def occluded(self, ray, distance, active):
        """Return whether anything lies on the rays before `distance`; False where not active."""
        blocked, end = ~active, distance * SHADOW_END
        t_min = _closest_allowed(ray)
        for group in self.shapes:

            def block(k, blocked, group=group):
                t, valid = _distance(group, k, ray, t_min)
                return (blocked | (valid & (t < end)),)

            (blocked,) = repeat(group.rows.count, block, (blocked,), f"occlude {group.kind.name}", self._unroll)
        return blocked & active

    def surface(self, ray, hit, with_uv):
        """Return the point, the outward normal and, if asked, the texture coordinates of each hit."""
        # lanes without a hit stay at the origin: their FAR squared would overflow to infinity
        p = dr.fma(ray.d, dr.select(hit.valid, hit.t, 0), ray.o)
        result = Surface(p, Vector3f(0, 0, 1), Vector2f(0) if with_uv else None)
        for number, group in enumerate(self.shapes):
            here = group.holds(hit.index)
            row = group.rows.row(hit.index - group.first, here)
            found = group.kind.surface(row, p)
            if with_uv:
                found.uv = group.kind.texture_coordinates(row, found)
            result = found if number == 0 else dr.select(here, found, result)
        return result

    def material(self, hit):
        """Return the material record of each hit, in the columns above."""
        return self.materials.row(hit.index, hit.valid)

    def diffuse_colour(self, hit, surface, material):
        """Return the texture's colour where there is one, else the material's."""
        colour = material.vector(DIFFUSE)
        if not self.textures:
            return colour
        row = self.texture_rows.row(hit.index, hit.valid)
        uv = Vector2f(surface.uv.x * material[SCALE_U], surface.uv.y * material[SCALE_V])
        for number, lookup in enumerate(self.textures, start=1):
            textured = hit.valid & (row[TEXTURE_KIND] == number)
            colour = dr.select(textured, lookup(row, uv, textured), colour)
        return colour


def _closest_allowed(ray):
    """Return the distance that rounding of the origin can fake on shapes that touch the one just left; else 0."""
    if ray.left_index is None:
        return Float(0)
    o = abs(ray.o)
    return greater(o.x, greater(o.y, o.z)) * (LEAVE_ULPS * EPSILON)


def _distance(group, k, ray, t_min):
    """Return the distance to one shape, and whether it counts as a hit."""
    this = group.first + k
    own = None if ray.left_index is None else ray.left_index == this
    row = group.rows[k]
    if not group.kind.solid:
        met, t = group.kind.distance(row, ray)
        met &= t > t_min
        return t, met if own is None else met & ~own
    met, near, far = group.kind.interval(row, ray)
    if own is not None:
        # a shape that is left inwards is met again on its far side only, one that is left outwards never
        near = dr.select(own, -FAR, near)
        met &= ray.left_outwards != this
    t = dr.select(near > t_min, near, far)
    return t, met & (t > t_min)


def leave(surface, index, direction):
    """Return the ray that leaves a surface point of the shape `index` in a unit direction."""
    return Ray(surface.p, direction, index, dr.dot(surface.n_geo, direction) < 0)
