"""The vocabulary that shapes, lights and integrators share: rays, hits and surface points, all in lanes."""

from __future__ import annotations

from dataclasses import dataclass

from renderer.core.backend import Bool, Float, UInt32, Vector2f, Vector3f

NO_SHAPE = 0xFFFFFFFF


@dataclass
class Ray:
    """A ray that may have left a shape.

    A convex shape cannot be hit again by a ray that leaves it outwards, and only on its far side by one that
    leaves it inwards. Carrying the shape therefore replaces the usual offset of the origin: nothing is moved,
    and surfaces in contact stay in contact.
    """

    o: Vector3f  # origin, scene units
    d: Vector3f  # unit direction
    left_index: UInt32 | None = None  # the shape that `o` lies on, NO_SHAPE for none; None if no lane left any
    left_inwards: Bool | None = None  # whether `d` points into that shape


@dataclass
class Hit:
    """The closest hit: `index` counts shapes in the compiled order and is NO_SHAPE where nothing was hit."""

    t: Float  # distance along the unit direction; FAR where nothing was hit
    index: UInt32
    record: UInt32 | None = None  # of the structure, that holds the shape if it is inside; None where nobody kept it

    @property
    def valid(self):
        """Whether anything was hit."""
        return self.index != NO_SHAPE


@dataclass
class Surface:
    """A point on a shape."""

    p: Vector3f  # on the surface to within rounding of p
    n_geo: Vector3f  # unit, outwards
    uv: Vector2f | None = None  # None where nobody asked
    n_smooth: Vector3f | None = None  # unit, interpolated over a mesh; None where the scene has none of that
    dp_du: Vector3f | None = None  # derivatives of the point by uv, of any length but along it; None where nobody asked
    dp_dv: Vector3f | None = None
    rounding: Float | None = None  # how far p may lie off a flat surface, scene units; None for 0 everywhere

    @property
    def n_shade(self):
        """The normal to shade with."""
        return self.n_geo if self.n_smooth is None else self.n_smooth
