"""What a shape kind provides, and the registry that finds it by its name in the scene file.

A kind is a set of stateless functions on lanes; `row` reads the parameters of one instance, or of one instance a
lane, in the columns that `pack` wrote. All vectors are in world space, distances in scene units along unit directions.

- `pack(shape, columns)`: host; the validated description as a list of floats, computed in double precision.
- solids: `interval(row, ray) -> (met, near, far)`, the part of the line inside the convex volume, where `met`.
- sheets: `distance(row, ray) -> (met, t)`, likewise.
- `surface(row, p) -> Surface`: the point moved onto the shape, with the outward unit normal.
- `texture_coordinates(row, surface) -> Vector2f`.
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
from renderer.core.registry import Registry


@dataclass(frozen=True)
class ShapeKind:
    """The functions of one kind of shape; see the module docstring for their contracts."""

    name: str
    pack: Callable
    surface: Callable
    texture_coordinates: Callable
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


KINDS = Registry()
register = KINDS.register


def turn(y, x):
    """Return the angle of (x, y) as a fraction of a full turn in [0, 1)."""
    fraction = dr.atan2(y, x) * (0.5 / math.pi)
    return fraction - dr.floor(fraction)


def lane_frame(normal):
    """Return `frame` for a unit normal in lanes."""
    across_y = Vector3f(-normal.z, 0, normal.x)  # n x y
    across_z = Vector3f(normal.y, -normal.x, 0)  # n x z
    t = dr.normalize(dr.select(abs(normal.y) < Float(0.9), across_y, across_z))
    return t, dr.cross(normal, t)
