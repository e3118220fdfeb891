"""Where rays meet the shapes of a scene: the closest hit, whether there is any, and the surface there.

Shapes outside of the structure (planes, and all of a small scene) are tested one after the other by every ray; the
others are found through the structure, whose leaf records carry their parameters. This is the only place that goes
from a lane's primitive to its kind.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.accel import watertight
from renderer.accel.records import FREE, LEAF, PRIMITIVE, TAG
from renderer.core import rows
from renderer.core.backend import Bool, Float, UInt32, Vector2f, Vector3f
from renderer.core.numeric import EPSILON, FAR, LEAVE_ULPS, largest
from renderer.core.records import NO_SHAPE, Hit, Ray, Surface
from renderer.core.rows import Columns, Rows, repeat
from renderer.scene.triangles import Triangles
from renderer.shapes.base import ShapeKind, starts_off_sheet

TRIANGLES = 0  # code of leaf records that hold triangles; those of shapes count from 1
# a shadow ray ends this many roundoffs before its light, so that a light on a surface is not hidden by it
SHADOW_END = 1 - 8 * EPSILON


@dataclass(frozen=True)
class ShapeGroup:
    """All shapes of one kind; their indices run from `first` on."""

    kind: ShapeKind
    rows: Rows
    first: int
    code: int | None = None  # the kind's in leaf records; None outside of the structure

    def holds(self, index):
        """Return whether a lane's shape is one of these."""
        return (index >= self.first) & (index < self.first + self.rows.count)

    @property
    def inline(self):
        """Whether a leaf record holds the parameters themselves."""
        return self.rows.width <= len(FREE)


class LeafRow(Columns):
    """A shape's record, read from the words of its leaf."""

    def __init__(self, words):
        self._words = words

    def __getitem__(self, column):
        return dr.reinterpret_array(Float, self._words[FREE[column]])


@dataclass(frozen=True)
class Geometry:
    """The shapes of a scene; see the module docstring.

    A hit's index counts primitives: first the shapes that are no meshes, then the triangles of these.
    """

    shapes: tuple[ShapeGroup, ...]
    triangles: Triangles | None  # of meshes; of all `triangle` shapes too where there is a structure
    structure: object | None  # Bvh, Grid or BruteForce over leaf records
    shape_count: int

    @property
    def empty(self):
        """Whether there is nothing to hit."""
        return not self.shape_count

    @property
    def _unroll(self):
        """Whether loops over shapes are unrolled: by the number of all shapes, because all are in one kernel."""
        return sum(group.rows.count for group in self._loose) <= rows.UNROLL_LIMIT

    @property
    def _loose(self):
        """The groups outside of the structure."""
        return [group for group in self.shapes if group.code is None]

    def intersect(self, ray):
        """Return the closest hit of each ray."""
        t, index = self.loose_hit(ray, Float(FAR))
        if self.structure is not None:
            t, index = self.structure.trace(ray, t, index, self.leaf_test(ray), Bool(True))
        return Hit(t, index)

    def loose_hit(self, ray, end):
        """Return distance and index of the closest hit before `end` outside of the structure; `end` for none."""
        t, index = end, UInt32(NO_SHAPE)
        t_min = _closest_allowed(ray)
        for group in self._loose:

            def closer(k, t, index, group=group):
                this = group.first + k
                valid, distance = _distance(group.kind, group.rows[k], ray, this, t_min)
                closer = valid & (distance < t)
                return dr.select(closer, distance, t), dr.select(closer, this, index)

            t, index = repeat(group.rows.count, closer, (t, index), f"intersect {group.kind.name}", self._unroll)
        return t, index

    def occluded(self, ray, distance, active):
        """Return whether anything lies on the rays before `distance`; False where not active."""
        blocked, end = ~active, distance * SHADOW_END
        t_min = _closest_allowed(ray)
        for group in self._loose:

            def block(k, blocked, group=group):
                valid, t = _distance(group.kind, group.rows[k], ray, group.first + k, t_min)
                return (blocked | (valid & (t < end)),)

            (blocked,) = repeat(group.rows.count, block, (blocked,), f"occlude {group.kind.name}", self._unroll)
        if self.structure is not None:
            _, index = self.structure.trace(ray, end, UInt32(NO_SHAPE), self.leaf_test(ray), ~blocked, any_hit=True)
            blocked |= index != NO_SHAPE
        return blocked & active

    def leaf_test(self, ray):
        """Return the function that a structure calls with the words of a leaf: (words) -> (met, distance, index)."""
        t_min = _closest_allowed(ray)
        groups = [group for group in self.shapes if group.code is not None]
        axes = watertight.Axes.of(ray) if self.triangles else None

        def test(words):
            this = words[PRIMITIVE]
            found = []
            if axes:
                here = words[TAG] == LEAF | TRIANGLES
                for inside, t, index in watertight.test(words, axes):
                    met = here & inside & (t > 0)  # what leaves triangles starts off them
                    found.append((met if ray.left_index is None else met & (index != ray.left_index), t, index))
            for group in groups:
                here = words[TAG] == LEAF | group.code
                row = LeafRow(words) if group.inline else group.rows.row(this - group.first, here)
                met, t = _distance(group.kind, row, ray, this, t_min)
                found.append((met & here, t, this))
            return _nearest(found)

        return test

    def surface(self, ray, hit, with_uv, with_tangents=False):
        """Return the point, the outward normal and, if asked, texture coordinates and their tangents of each hit."""
        # lanes without a hit stay at the origin: their FAR squared would overflow to infinity
        p = dr.fma(ray.d, dr.select(hit.valid, hit.t, 0), ray.o)
        results = []
        if self.triangles:
            here = self.triangles.hold(hit.index)
            if hit.record is None:
                found = self.triangles.surface(ray, hit.index, here, with_uv, with_tangents)
            else:
                words = self.structure.words(hit.record, here)
                found = self.triangles.plain_surface(ray, watertight.corners(words, hit.index))
            results.append((here, found))
        for group in self.shapes:
            here = group.holds(hit.index)
            row = group.rows.row(hit.index - group.first, here)
            found = group.kind.surface(row, p)
            if with_uv:
                found.uv = group.kind.texture_coordinates(row, found)
            if with_tangents:
                found.dp_du, found.dp_dv = group.kind.tangents(row, found)
            if self.triangles:
                found.n_smooth, found.rounding = found.n_geo, Float(0)
            results.append((here, found))
        if not results:
            tangents = (Vector3f(1, 0, 0), Vector3f(0, 1, 0)) if with_tangents else (None, None)
            return Surface(p, Vector3f(0, 0, 1), Vector2f(0) if with_uv else None, None, *tangents)
        result = results[0][1]
        for here, found in results[1:]:
            result = dr.select(here, found, result)
        return result

    def shape_of(self, hit):
        """Return the number of the shape that was hit, NO_SHAPE where none was."""
        if self.triangles is None or not self.triangles.of_meshes:
            return hit.index
        in_mesh = hit.valid & (hit.index >= self.triangles.first)
        return dr.select(in_mesh, self.triangles.shape(hit.index, in_mesh), hit.index)


def leave(surface, index, direction):
    """Return the ray that leaves a surface point of the primitive `index` in a unit direction."""
    inwards = dr.dot(surface.n_geo, direction) < 0
    p = surface.p
    if surface.rounding is not None:
        p = dr.fma(surface.n_geo, dr.select(inwards, -surface.rounding, surface.rounding), p)
    return Ray(p, direction, index, inwards)


def _closest_allowed(ray):
    """Return how far rounding can put the origin off the surface just left, and so off others that touch it; else 0."""
    if ray.left_index is None:
        return Float(0)
    return largest(ray.o) * (LEAVE_ULPS * EPSILON)


def _distance(kind, row, ray, this, t_min):
    """Return whether a ray meets the shape with the index `this`, and where."""
    own = None if ray.left_index is None else ray.left_index == this
    if not kind.solid:
        met, t = kind.distance(row, ray)
        met &= t > 0
        return met if own is None else met & ~own & starts_off_sheet(row, ray, t_min), t
    met, near, far = kind.interval(row, ray)
    if own is not None:
        # a shape that is left inwards is met again, on its far side only, and one that is left outwards never
        near = dr.select(own, -FAR, near)
        met = dr.select(own, ray.left_inwards, met)
    t = dr.select(near > t_min, near, far)
    return met & (t > t_min), t


def _nearest(found):
    """Return the nearest of several (met, distance, index), the lower index where two are equally near."""
    met, t, index = found[0]
    for other_met, other_t, other_index in found[1:]:
        nearer = other_met & (~met | (other_t < t) | ((other_t == t) & (other_index < index)))
        met, t, index = met | other_met, dr.select(nearer, other_t, t), dr.select(nearer, other_index, index)
    return met, t, index
