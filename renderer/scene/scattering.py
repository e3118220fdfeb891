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
from renderer.bsdfs.base import BsdfKind
from renderer.core.backend import UInt32, Vector3f
from renderer.core.frame import Frame
from renderer.core.rows import SELECT_LIMIT, Rows

COURSEWORK = "coursework"  # the BSDF of materials that name none


@dataclass(frozen=True)
class BsdfGroup:
    """All different BSDFs of one kind; in the order of all, theirs begin at `first`."""

    kind: BsdfKind
    rows: Rows
    first: int
    has: frozenset
    shapes: tuple  # for each record, the shapes that have it, by their number in the compiled order


class Scattering:
    """The BSDFs of a scene."""

    def __init__(self, materials, outside):
        """Hold the Materials of the shapes in the compiled order; `outside` is the index of refraction around each."""
        members = {}  # kind: {record: [shapes]}, in the order of their first shape
        has, self.smooth = {}, False
        for number, (material, around) in enumerate(zip(materials, outside)):
            bsdf, kind = bsdf_of(material)
            record = tuple(kind.pack(bsdf, around))
            members.setdefault(kind.name, {}).setdefault(record, []).append(number)
            has[kind.name] = has.get(kind.name, frozenset()) | frozenset(kind.features(bsdf))
            self.smooth |= kind.smooth(bsdf)
        self.groups, first = [], 0
        for name, records in members.items():
            shapes = tuple(map(tuple, records.values()))
            self.groups.append(BsdfGroup(KINDS[name], Rows([*records]), first, has[name], shapes))
            first += len(records)
        few = len(materials) <= SELECT_LIMIT or first == 1
        self._looks = None if few else Rows(_places(self.groups, len(materials)), UInt32)
        self.textured = False

    def at(self, shape, surface, active):
        """Return the Look of each lane's shape at a point of its surface, meaningful where `active`."""
        return Look(Frame.of(surface.n_shade), self._parts(shape, active))

    def _parts(self, shape, active):
        """Return (group, lanes of that kind, their parameters) of the groups."""
        if self._looks is None:
            masks = [[_any_of(shape, members) for members in group.shapes] for group in self.groups]
            return [(group, _any(own), group.rows.chosen(own[1:])) for group, own in zip(self.groups, masks)]
        place, parts = self._looks.row(shape, active)[0], []
        for group in self.groups:
            here = active & (place >= group.first) & (place < group.first + group.rows.count)
            parts.append((group, here, group.rows.row(place - group.first, here)))
        return parts


class Look:
    """What each lane's surface does to light. Directions are local, as in bsdfs/base.py; the frame is not turned."""

    def __init__(self, frame, parts):
        self.frame = frame
        self._parts = parts  # of (group, lanes of that kind, their parameters)

    def sample(self, wi, u, u2):
        """Return the BsdfSample of each lane."""

        def ask(group, p):
            found = group.kind.sample(p, _turned(group.kind, wi, wi), u, u2, group.has)
            found.wo = _turned(group.kind, found.wo, wi)
            return found

        return self._joined(ask)

    def evaluate(self, wi, wo):
        """Return the BSDF times |cosine| at wo, and the density of `sample` per steradian."""
        return self._joined(
            lambda group, p: group.kind.evaluate(p, _turned(group.kind, wi, wi), _turned(group.kind, wo, wi), group.has)
        )

    def albedo(self):
        """Return the colour for pictures of first hits."""
        return self._joined(lambda group, p: group.kind.albedo(p))

    def _joined(self, ask):
        """Return what the kinds answer, each for its own lanes."""
        group, _, p = self._parts[0]
        result = ask(group, p)
        for group, here, p in self._parts[1:]:
            result = dr.select(here, ask(group, p), result)
        return result


def bsdf_of(material):
    """Return the record and the kind of what a Material does to light."""
    if material.bsdf is None:
        return material, KINDS[COURSEWORK]
    return material.bsdf, KINDS[material.bsdf.type]


def _turned(kind, w, wi):
    """Return a direction in the frame that a kind wants: kinds that only reflect see both sides alike."""
    return w if kind.transmits else Vector3f(w.x, w.y, dr.select(wi.z < 0, -w.z, w.z))


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
