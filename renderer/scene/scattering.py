"""How surfaces scatter light: the BSDFs of a scene by kind, and for each lane that of the shape that it met.

This is the only place that goes from a lane's shape to its kind of BSDF. A kernel contains the kinds that the scene
has, and of each what its instances need.
"""

from __future__ import annotations

import functools
import operator
from dataclasses import dataclass

import drjit as dr

from renderer.bsdfs import KINDS
from renderer.bsdfs.base import BsdfKind, mirrored
from renderer.core.backend import UInt32, Vector3f
from renderer.core.frame import Frame
from renderer.core.rows import SELECT_LIMIT, Rows
from renderer.scene.materials import uses_uv
from renderer.scene.relief import Relief
from renderer.scene.texturing import Parameters, uses_of

COURSEWORK = "coursework"  # the BSDF of materials that name none


@dataclass(frozen=True)
class BsdfGroup:
    """All different BSDFs of one kind; in the order of all, theirs begin at `first`."""

    kind: BsdfKind
    rows: Rows
    first: int
    has: frozenset
    shapes: tuple  # for each record, the shapes that have it, by their number in the compiled order
    textured: Parameters | None  # what textures give


class Scattering:
    """The BSDFs of a scene."""

    def __init__(self, materials, outside, texturing):
        """Hold the Materials of the shapes in the compiled order; `outside` is the index of refraction around each."""
        members = {}  # kind: {(record, its textures): [shapes]}, in the order of their first shape
        has, self.smooth = {}, False
        for number, (material, around) in enumerate(zip(materials, outside)):
            bsdf, kind = bsdf_of(material)
            record = tuple(kind.pack(bsdf, around)), uses_of(kind, material, bsdf)
            members.setdefault(kind.name, {}).setdefault(record, []).append(number)
            has[kind.name] = has.get(kind.name, frozenset()) | frozenset(kind.features(bsdf))
            self.smooth |= kind.smooth(bsdf)
        self.groups, first = [], 0
        for name, records in members.items():
            shapes, kind = tuple(map(tuple, records.values())), KINDS[name]
            firsts = [materials[numbers[0]] for numbers in shapes]
            textured = texturing.parameters(kind, [(material, bsdf_of(material)[0]) for material in firsts])
            rows = Rows([record for record, _ in records])
            self.groups.append(BsdfGroup(kind, rows, first, has[name], shapes, textured))
            first += len(records)
        few = len(materials) <= SELECT_LIMIT or first == 1
        self._looks = None if few else Rows(_places(self.groups, len(materials)), UInt32)
        relief = Relief(texturing, materials)
        self._relief = None if relief.flat else relief
        self.with_uv = any(uses_uv(material, paths=True) for material in materials)
        self.with_tangents = bool(self._relief) or any(getattr(m.bsdf, "anisotropic", 0) for m in materials)

    def at(self, shape, surface, active):
        """Return the Look of each lane's shape at a point of its surface, meaningful where `active`."""
        parts = self._parts(shape, surface, active)
        if self._relief is not None:
            return Look(self._relief.frame(shape, surface, active), parts, surface.n_shade)
        n = surface.n_shade
        return Look(Frame.along(n, surface.dp_du) if self.with_tangents else Frame.of(n), parts)

    def albedo(self, shape, surface, active):
        """Return the colour that tells the material of each lane's shape apart."""
        parts = self._parts(shape, surface, active)
        return _joined(parts, lambda group, p: group.kind.albedo(p))

    def _parts(self, shape, surface, active):
        """Return [(group, lanes of that kind, their parameters)]."""
        found = []
        for group, here, pick in self._places(shape, active):
            p = pick(group.rows)
            found.append((group, here, group.textured.over(pick, p, surface.uv, here) if group.textured else p))
        return found

    def _places(self, shape, active):
        """Return (group, lanes of that kind, function from tables of its records to each lane's row) of the groups."""
        if self._looks is None:
            for group in self.groups:
                masks = [_any_of(shape, members) for members in group.shapes]
                yield group, _any(masks), lambda rows, masks=masks: rows.chosen(masks[1:])
            return
        place = self._looks.row(shape, active)[0]
        for group in self.groups:
            here = active & (place >= group.first) & (place < group.first + group.rows.count)
            yield group, here, lambda rows, group=group, here=here: rows.row(place - group.first, here)


class Look:
    """What each lane's surface does to light. Directions are in the world, and point away from the surface."""

    def __init__(self, frame, parts, n_shade=None):
        """Hold frames, parts (group, lanes of that kind, their parameters), and the normals that maps turned."""
        self._frame, self._parts, self._n_shade = frame, parts, n_shade

    def sample(self, wi, u, u2):
        """Return the BsdfSample of each lane; its `wo` is in the world."""

        def ask(group, p):
            view = self._view(group.kind, wi)
            found = group.kind.sample(p, view.local(wi), u, u2, group.has)
            possible, found.wo = view.possible(found.wo), view.world(found.wo)
            found.weight = dr.select(possible, found.weight, 0)
            return found

        return _joined(self._parts, ask)

    def evaluate(self, wi, wo):
        """Return the BSDF times |cosine| at wo, and the density of `sample` per steradian."""

        def ask(group, p):
            view = self._view(group.kind, wi)
            local = view.local(wo)
            value, pdf_sa = group.kind.evaluate(p, view.local(wi), local, group.has)
            return dr.select(view.possible(local), value, 0), pdf_sa

        return _joined(self._parts, ask)

    def _view(self, kind, wi):
        """Return how a kind sees directions: those that only reflect see both sides of the surface alike."""
        if self._n_shade is None:
            return View(self._frame, None if kind.transmits else self._frame.to_local(wi).z < 0)
        return MappedView(self._frame, None if kind.transmits else dr.dot(wi, self._n_shade) < 0, self._n_shade)


@dataclass(frozen=True)
class View:
    """Directions in a frame, which is turned where the surface is seen from behind."""

    frame: Frame
    behind: object  # mask, or None if that does not count

    def local(self, w):
        """Return a world direction in the frame."""
        return self._turned(self.frame.to_local(w))

    def world(self, w):
        """Return a local direction in the world."""
        return self.frame.to_world(self._turned(w))

    def possible(self, w):
        """Return whether light can take a local direction."""
        return True

    def _turned(self, w):
        return w if self.behind is None else mirrored(w, self.behind)


@dataclass(frozen=True)
class MappedView:
    """Directions in a frame that a map has turned: what is behind the surface is mirrored by the surface itself."""

    frame: Frame
    behind: object
    n_shade: Vector3f

    def local(self, w):
        """Return a world direction in the frame."""
        return self.frame.to_local(self._mirrored(w))

    def world(self, w):
        """Return a local direction in the world."""
        return self._mirrored(self.frame.to_world(w))

    def possible(self, w):
        """Return whether a local direction is on the same side of the surface's and of the map's normal."""
        return dr.dot(self.frame.to_world(w), self.n_shade) * w.z > 0

    def _mirrored(self, w):
        return w if self.behind is None else dr.select(self.behind, w - self.n_shade * (2 * dr.dot(w, self.n_shade)), w)


def bsdf_of(material):
    """Return the record and the kind of what a Material does to light."""
    if material.bsdf is None:
        return material, KINDS[COURSEWORK]
    return material.bsdf, KINDS[material.bsdf.type]


def _joined(parts, ask):
    """Return what the kinds answer, each for its own lanes."""
    group, _, p = parts[0]
    result = ask(group, p)
    for group, here, p in parts[1:]:
        result = dr.select(here, ask(group, p), result)
    return result


def _places(groups, count):
    """Return for each shape [the place of its record among all]."""
    places = [[0]] * count
    for group in groups:
        for k, shapes in enumerate(group.shapes):
            for shape in shapes:
                places[shape] = [group.first + k]
    return places


def _any(masks):
    return functools.reduce(operator.or_, masks)


def _any_of(index, numbers):
    """Return whether a lane's index is one of some numbers."""
    return _any([index == number for number in numbers])
