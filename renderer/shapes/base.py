"""What a shape kind provides, and the registry that finds it by its name in the scene file.

A kind is a set of stateless functions on lanes; `row` reads the parameters of one instance, or of one instance a
lane, in the columns that `pack` wrote. All vectors are in world space, distances in scene units along unit directions.

- `pack(shape, columns)`: host; the validated description as a list of floats, computed in double precision.
- solids: `interval(row, ray) -> (met, near, far)`, the part of the line inside the convex volume, where `met`.
- sheets: `distance(row, ray) -> (met, t)`, likewise; columns 0 to 6 are SHEET_POINT, SHEET_NORMAL and SHEET_ROUNDING.
- `surface(row, p) -> Surface`: the point moved onto the shape, with the outward unit normal.
- `texture_coordinates(row, surface) -> Vector2f`.
- `tangents(row, surface) -> (dp_du, dp_dv)`: derivatives of the point by these; where one does not exist (poles,
  middles of caps) a short vector along the surface.
- `columns(shapes) -> int`: the record width that these instances need.
- `bounds(shape) -> (lowest, highest)`: host; corners of a box around the shape in double precision, or None.

A distance may be infinite or NaN only where the line misses: it then fails every comparison of the caller.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Float, Vector3f
from renderer.core.numeric import EPSILON, TINY, greater
from renderer.core.records import Surface
from renderer.core.registry import Registry
from renderer.core.vectors import cross, dot


@dataclass(frozen=True)
class ShapeKind:
    """The functions of one kind of shape; see the module docstring for their contracts."""

    name: str
    pack: Callable
    surface: Callable
    texture_coordinates: Callable
    tangents: Callable
    interval: Callable | None = None  # solids
    distance: Callable | None = None  # sheets
    columns: Callable | None = None  # None: every record is as wide as `pack` makes it
    bounds: Callable | None = None  # None: instances have no bounds
    directions: Sequence = ()  # columns of directions: what is along an axis counts as structure, not as a value

    def __post_init__(self):
        assert (self.interval is None) != (self.distance is None), self.name

    @property
    def solid(self):
        """Whether the kind encloses a volume."""
        return self.interval is not None


SHORT = 1e-7  # of a radius: the distance from a pole or from the middle of a cap below which it counts as this far

SHEET_POINT, SHEET_NORMAL, SHEET_ROUNDING = 0, 3, 6  # columns of sheets: a point, the unit normal, and `rounding`
SHEET_ROUNDOFFS = 10.0  # five for the point and five for the ray, see `rounding`

KINDS = Registry()
register = KINDS.register


def rounding(normal, reach):
    """Return twice the square of how far off its plane rounding may put what lies on a sheet. Host.

    `reach` is how far along each axis the sheet reaches from its point c. A point p is projected by n.(p - c), and a
    ray that starts there finds by n.(c - o) how far it is from the plane, of this sheet or of another that goes on in
    that plane, as large. Either is wrong by a roundoff of each term |n_i| |p_i - c_i| for the normal, another for the
    difference, and three for the sum of products. What the rounding of p itself brings, its coordinates tell.
    """
    return 2 * (SHEET_ROUNDOFFS * EPSILON * sum(abs(n) * r for n, r in zip(normal, reach))) ** 2


def to_plane(row, ray):
    """Return the way from a ray's origin to a sheet's point, and the distance along the line to its plane.

    A line within the plane divides by zero: its distance is infinite or NaN.
    """
    n, way = row.vector(SHEET_NORMAL), row.vector(SHEET_POINT) - ray.o
    return way, dr.dot(n, way) / dr.dot(n, ray.d)


def onto_plane(row, p):
    """Return p projected along the normal into a sheet's plane, as `surface` does."""
    n = row.vector(SHEET_NORMAL)
    return Surface(p - n * dr.dot(n, p - row.vector(SHEET_POINT)), n)


def starts_off_sheet(row, ray, rounding):
    """Return whether a ray starts farther from a sheet's plane than can be `rounding` of its origin, and of the sheet.

    Closer to it no side can be told, and a hit there is none, at however grazing an angle and so far away. Squares of
    sums are bounded by twice the sum of squares, which makes leaner kernels than absolute values do.
    """
    height = dr.dot(row.vector(SHEET_NORMAL), row.vector(SHEET_POINT) - ray.o)
    return dr.square(height) > row[SHEET_ROUNDING] + 2 * dr.square(rounding)


def turn(y, x):
    """Return the angle of (x, y) as a fraction of a full turn in [0, 1)."""
    fraction = dr.atan2(y, x) * (0.5 / math.pi)
    return fraction - dr.floor(fraction)


def dual_edges(e1, e2):
    """Return n = e1 x e2, not of unit length, and e2 x n / |n|^2 and n x e1 / |n|^2. Host."""
    n = cross(e1, e2)
    scale = 1 / dot(n, n)
    return n, *([scale * component for component in dual] for dual in (cross(e2, n), cross(n, e1)))


def edges(normal, dual1, dual2):
    """Return the edges of a triangle or parallelogram, of which dual_i . edge_j is 1 for i = j, else 0."""
    e1, e2 = dr.cross(dual2, normal), dr.cross(normal, dual1)
    return e1 / dr.dot(dual1, e1), e2 / dr.dot(dual2, e2)


def derivatives(e1, e2, uv1, uv2):
    """Return dp/du and dp/dv of a triangle with edges e1, e2 along which texture coordinates grow by uv1, uv2.

    Where the corners' coordinates lie on a line, they are the edges.
    """
    determinant = uv1.x * uv2.y - uv1.y * uv2.x
    good = abs(determinant) > TINY
    inverse = dr.rcp(dr.select(good, determinant, 1))
    along_u, along_v = (e1 * uv2.y - e2 * uv1.y) * inverse, (e2 * uv1.x - e1 * uv2.x) * inverse
    return dr.select(good, along_u, e1), dr.select(good, along_v, e2)


def polar_tangents(across, normal, fallback, radius):
    """Return the derivatives of a point of a disk by its angle in turns and by its distance over `radius`.

    `across` leads from the middle to the point; in the middle it counts as short and along `fallback`.
    """
    rho = dr.norm(across)
    outward = dr.select(rho > TINY, across * dr.rcp(greater(rho, Float(TINY))), fallback)
    return dr.cross(outward, normal) * (math.tau * greater(rho, SHORT * radius)), outward * radius


def lane_frame(normal):
    """Return `frame` for a unit normal in lanes."""
    across_y = Vector3f(-normal.z, 0, normal.x)  # n x y
    across_z = Vector3f(normal.y, -normal.x, 0)  # n x z
    t = dr.normalize(dr.select(abs(normal.y) < Float(0.9), across_y, across_z))
    return t, dr.cross(normal, t)
