"""Textures: whatever parameter they give, of whichever record, at each lane's point.

All images of a scene lie in one atlas. A `Slot` is one parameter of a list of records, textured in some of them; its
kernel contains the lookups that these need. Path tracing decodes its colours from sRGB; numbers, normals and the other
modes' colours are taken as they are written.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

import drjit as dr

from renderer.core.backend import Float, UInt32, Vector2f, Vector3f
from renderer.core.errors import SceneError
from renderer.core.rows import Columns, Rows
from renderer.io.image import read_texture
from renderer.scene.materials import textures_of
from renderer.textures import bitmap
from renderer.textures.checkerboard import Checkerboards

LOOKUP, SCALE_U, SCALE_V, FACTOR = 3, 4, 5, 6  # columns of a slot's records, after the three of the texture's own
PLAIN = (0, 0, 0, 0, 0, 0, 0)
COLOUR, NUMBER, AS_WRITTEN = bitmap.decoded, bitmap.number, bitmap.as_written  # forms of a texture's values
BOARD = "checkerboard"


class Use(NamedTuple):
    """A texture and how it lies on a surface; uses that are equal look alike."""

    source: object  # file name or Checkerboard
    filter: str
    wrap: str
    scale_u: float
    scale_v: float


def use_of(material, record, key):
    """Return the Use of the texture at a key of `record`, a Material or its BSDF; None where there is none."""
    source = getattr(record, key)
    if not isinstance(source, str) and getattr(source, "type", None) != BOARD:
        return None
    squares = 1.0 if isinstance(source, str) else source.scale
    scale = material.scaleU * squares, material.scaleV * squares
    return Use(source, material.texturefilter, material.texturewrap, *scale)


class Texturing:
    """The textures of a scene."""

    def __init__(self, loaded, ordered, paths=True):
        """Read the images that the materials of [(index in the file, shape)] name and the mode uses (`paths`: tracing).

        Raises: SceneError with the place in the scene of a file that cannot be used.
        """
        self._images, self._boards = {}, {}
        for index, shape in ordered:
            for path, source in textures_of(shape.material, paths):
                if not isinstance(source, str):
                    self._boards.setdefault(source, len(self._boards))
                elif source not in self._images:
                    self._images[source] = _read(loaded, source, ("scene", "shapes", index, "material", *path))
        self._atlas = bitmap.Atlas(self._images.values()) if self._images else None
        self._places = dict(zip(self._images, self._atlas.offsets)) if self._images else {}
        self._checkerboards = Checkerboards(self._boards) if self._boards else None

    def slot(self, uses, form):
        """Return the Slot of one Use or None for each record, None where all are; `form` is one of those above."""
        if not any(uses):
            return None
        kinds = list(dict.fromkeys(_lookup_of(use) for use in uses if use))
        lookups = [self._lookup(kind, form) for kind in kinds]
        return Slot(self._rows(uses, kinds), lookups, all(uses), form)

    def heights(self, uses, factors):
        """Return the Slot of bump maps, whose values are the slopes (Vector2f) by u and v of heights times factors."""
        if not any(uses):
            return None
        kinds = list(dict.fromkeys(use.wrap for use in uses if use))
        uses = [use and use._replace(filter=None) for use in uses]
        rows = self._rows(uses, [(None, wrap) for wrap in kinds], factors)
        return Slot(rows, [_chained(self._atlas.slope(wrap)) for wrap in kinds], all(uses))

    def parameters(self, kind, members):
        """Return the textured parameters of a BsdfKind with the records [(Material, its BSDF)], None where none is."""
        slots = []
        for key, (column, width) in (kind.textured or {}).items():
            uses = [use_of(material, bsdf, key) for material, bsdf in members]
            slots.append((column, self.slot(uses, COLOUR if width == 3 else NUMBER)))
        slots = [(column, slot) for column, slot in slots if slot]
        return Parameters(slots) if slots else None

    def _rows(self, uses, kinds, factors=None):
        factors = factors or [1.0] * len(uses)
        return Rows([self._record(use, kinds, f) if use else PLAIN for use, f in zip(uses, factors)], UInt32)

    def _record(self, use, kinds, factor):
        if isinstance(use.source, str):
            image = self._images[use.source]
            own = self._places[use.source], image.width, image.height
        else:
            own = self._boards[use.source], 0, 0
        return *own, 1 + kinds.index(_lookup_of(use)), *map(_bits, (use.scale_u, use.scale_v, factor))

    def _lookup(self, kind, form):
        """Return the function (row, uv, active) of one kind of lookup."""
        if kind != BOARD:
            return _scaled(self._atlas.sampler(*kind, form))
        sample = self._checkerboards.sample
        return _scaled((lambda row, uv, active: sample(row, uv, active).x) if form is NUMBER else sample)


class Slot:
    """One parameter of many records; `rows` has a record for each of them."""

    def __init__(self, rows, lookups, everywhere, form=None):
        self.rows, self.form, self._lookups, self._everywhere = rows, form, lookups, everywhere

    def value(self, row, uv, active, plain):
        """Return the value at texture coordinates, `plain` where the lane's record (a row of `rows`) has no texture."""
        if self._everywhere and len(self._lookups) == 1:
            return self._lookups[0](row, uv, active)
        for number, lookup in enumerate(self._lookups, start=1):
            here = active & (row[LOOKUP] == number)
            plain = dr.select(here, lookup(row, uv, here), plain)
        return plain


class Parameters:
    """Parameters of a kind of BSDF that textures give, by the columns of its records."""

    def __init__(self, slots):
        self._slots = slots  # [(column, Slot)]

    def over(self, pick, p, uv, active):
        """Return the parameters p with those of textures in place; `pick` goes from Rows to each lane's row."""
        values = {}
        for column, slot in self._slots:
            plain = p.vector(column) if slot.form is COLOUR else p[column]
            values[column] = slot.value(pick(slot.rows), uv, active, plain)
        return Overlay(p, values)


class Overlay(Columns):
    """A row of which some columns have other values: {column: Float, or Vector3f for this and the two that follow}."""

    def __init__(self, row, values):
        self._row, self._vectors, self._numbers = row, {}, {}
        for column, value in values.items():
            if isinstance(value, Vector3f):
                self._vectors[column] = value
                self._numbers |= {column + axis: value[axis] for axis in range(3)}
            else:
                self._numbers[column] = value

    def __getitem__(self, column):
        return self._numbers[column] if column in self._numbers else self._row[column]

    def vector(self, column):
        """Return three neighbouring columns as a vector."""
        return self._vectors[column] if column in self._vectors else super().vector(column)


def uses_of(kind, material, bsdf):
    """Return the Use or None of each key of a BSDF that may be textured; it tells records apart besides values."""
    return tuple(use_of(material, bsdf, key) for key in kind.textured or ())


def _lookup_of(use):
    """Return which lookup a use needs: filter and wrap, or the checkerboard's."""
    return (use.filter, use.wrap) if isinstance(use.source, str) else BOARD


def _bits(value):
    """Return the bits of a number as float32."""
    return struct.unpack("I", struct.pack("f", value))[0]


def _scale(row):
    return Vector2f(*(dr.reinterpret_array(Float, row[column]) for column in (SCALE_U, SCALE_V)))


def _scaled(lookup):
    """Return a lookup that repeats the texture as its record says."""
    return lambda row, uv, active: lookup(row, uv * _scale(row), active)


def _chained(slope):
    """Return the same for slopes, which grow with the repetitions."""

    def sample(row, uv, active):
        scale = _scale(row)
        return slope(row, uv * scale, active) * scale * dr.reinterpret_array(Float, row[FACTOR])

    return sample


def _read(loaded, filename, path):
    """Return the Image in a texture file, which is named at `path`."""
    try:
        return bitmap.Image(*read_texture(loaded.resolve(filename)))
    except SceneError as error:
        raise loaded.refused(error, *path) from error
