"""Flat emitters of path-traced scenes: rectangles, disks and triangles, with points spread evenly over their area.

All are images of (a, b) -> corner + a u + b v: of the unit square, the unit disk, or half of the square.
"""

import math

import drjit as dr

from renderer.core.backend import Bool, Float, Vector2f
from renderer.core.vectors import cross, frame, length, subtract, unit
from renderer.core.warp import square_to_disk, square_to_triangle
from renderer.lights.base import towards

CORNER, EDGE_U, EDGE_V, RADIANCE, INVERSE_AREA, INVERSE_CROSS, KIND, ONE_SIDED = 0, 3, 6, 9, 12, 13, 14, 15
EDGES = range(EDGE_U, RADIANCE)
WIDTH = 16
RECTANGLE, DISK, TRIANGLE = range(3)
CODES = {"rectangle": RECTANGLE, "disk": DISK, "triangle": TRIANGLE}
AREAS = {RECTANGLE: 1.0, DISK: math.pi, TRIANGLE: 0.5}  # of the image of unit edges at a right angle


def edges(shape):
    """Return a corner (of disks the middle) and two edges of a shape, in double precision."""
    if shape.type == "rectangle":
        return [c - 0.5 * (u + v) for c, u, v in zip(shape.center, shape.u, shape.v)], [*shape.u], [*shape.v]
    if shape.type == "disk":
        return [*shape.center], *([shape.radius * x for x in edge] for edge in frame(unit(shape.normal)))
    return [*shape.v0], subtract(shape.v1, shape.v0), subtract(shape.v2, shape.v0)


def area(shape):
    """Return the area of one side."""
    _, u, v = edges(shape)
    return AREAS[CODES[shape.type]] * length(cross(u, v))


def pack(shape, twosided):
    """Return the record of a shining shape."""
    corner, u, v = edges(shape)
    across = length(cross(u, v))
    code = CODES[shape.type]
    return [*corner, *u, *v, *shape.emission, 1 / (AREAS[code] * across), 1 / across, code, float(not twosided)]


def features(records):
    """Return the codes of the kinds among packed records, and whether some shine on one side, and some on both."""
    sides = {record[ONE_SIDED] for record in records}
    return frozenset(record[KIND] for record in records), 1.0 in sides, 0.0 in sides


def estimate(shape, twosided, luminance):
    """Return the values of the light's Estimate: at most pi times radiance, and nothing behind one-sided lights."""
    corner, u, v = edges(shape)
    reach = {"rectangle": 0.5, "disk": 0.0, "triangle": 1 / 3}[shape.type]
    center = tuple(c + reach * (a + b) for c, a, b in zip(corner, u, v))
    values = {"center": center, "strength": area(shape) * luminance, "least": area(shape) / math.pi}
    return values if twosided else values | {"axis": tuple(unit(cross(u, v))), "gate": 0.0}


def sample(row, p, u, u2, has):
    """Return a point of the lane's emitter as a DirectSample; `has` is what `features` returned."""
    _, one_sided, two_sided = has
    both = row[ONE_SIDED] == 0 if one_sided and two_sided else Bool(two_sided)
    q, normal = point(row, u2, has)
    return towards(q, normal, p, row.vector(RADIANCE), row[INVERSE_AREA], both)


def point(row, u2, has):
    """Return a point of the lane's emitter, spread evenly, and the unit normal there."""
    place = _place(row, u2, has[0])
    across = row.vector(EDGE_U), row.vector(EDGE_V)
    q = dr.fma(across[0], place.x, dr.fma(across[1], place.y, row.vector(CORNER)))
    return q, dr.cross(*across) * row[INVERSE_CROSS]


def _place(row, u2, kinds):
    """Return (a, b), even over each lane's kind of shape."""
    maps = {RECTANGLE: lambda: Vector2f(u2), DISK: lambda: square_to_disk(u2), TRIANGLE: lambda: square_to_triangle(u2)}
    (first, *others) = sorted(kinds)
    place = maps[first]()
    for kind in others:
        place = dr.select(row[KIND] == Float(kind), maps[kind](), place)
    return place
