"""What a light kind provides, and the registry that finds it by its name in the scene file.

Lights of the file register as LightKind. Modules of shapes that shine in path-traced scenes have
`pack(shape, twosided)`, `features(records)`, `estimate(shape, twosided, luminance)` and
`sample(row, p, u, u2, has) -> DirectSample`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.numeric import EPSILON, TINY, greater, largest
from renderer.core.registry import Registry

# Roundoffs of coordinates by which a point of a lamp, and where a ray is found to meet it, lie off its surface.
LAMP_ULPS = 8.0
# At smaller cosines at a lamp densities stop to grow, so that they stay finite; a lamp seen so flat sends no light.
LEAST_COSINE = 1e-5


@dataclass
class LightSample:
    """Light that may reach a point: test the segment for shadow, then use `radiance`."""

    wo: Vector3f  # unit direction from the point to the light
    distance: Float  # scene units
    radiance: Vector3f  # what arrives without falling off, as phong mode wants it


@dataclass
class DirectSample:
    """A direction from which light arrives in path-traced scenes, and with which density it was chosen."""

    wo: Vector3f  # unit direction from the point to the light
    distance: Float  # scene units, short of the light by its rounding; FAR for what is infinitely far away
    radiance: Vector3f  # towards the point; of a point light intensity / distance^2; 0 where the light does not shine
    pdf_sa: Float  # per steradian; 1 for lights that rays cannot hit
    delta: Bool  # whether rays cannot hit it


@dataclass(frozen=True)
class LightKind:
    """`pack(light)` returns its record on the host; `sample(row, p)` returns a LightSample for points in lanes, and
    `sample(row, p, u2)` one of a random point of the light if it is `extended`.

    `direct(row, p, u, u2, has)` returns a DirectSample; None for lights that path-traced scenes see as shapes.
    `estimate(light, luminance)` returns the values of its choice.Estimate on the host.
    """

    name: str
    pack: Callable
    sample: Callable
    direct: Callable | None = None
    estimate: Callable | None = None
    extended: bool = False  # whether it is larger than a point


KINDS = Registry()
register = KINDS.register


def direction_to(q, p):
    """Return the unit direction from p to q (0 where they are one) and the distance."""
    offset = q - p
    distance = dr.norm(offset)
    return offset * dr.rcp(greater(distance, TINY)), distance


def fallen_off(light):
    """Return the DirectSample of a LightSample of a point: what arrives falls with the square of the distance."""
    falloff = dr.rcp(greater(dr.square(light.distance), TINY))
    return DirectSample(light.wo, light.distance, light.radiance * falloff, Float(1), Bool(True))


def short_of(distance, p, cosine):
    """Return where a shadow ray from p ends before a lamp that it meets at an angle with this cosine (not 0).

    Rounding moves the lamp's point, and what a ray that is aimed at it meets, off its surface by some roundoffs of the
    coordinates; along the ray this grows with 1 / cosine.
    """
    size = distance + largest(p)
    return distance - size * (LAMP_ULPS * EPSILON) / cosine


def area_pdf_sa(distance, cosine, inverse_area):
    """Return the density per steradian of points that lie evenly on a surface, seen at a distance and angle."""
    return dr.square(distance) * inverse_area / greater(cosine, Float(LEAST_COSINE))


def towards(q, normal, p, radiance, inverse_area, both):
    """Return the DirectSample of a point q with a unit normal, one of many that lie evenly over an area.

    `both` tells whether its back shines too.
    """
    wo, distance = direction_to(q, p)
    cosine = -dr.dot(normal, wo)
    cosine = dr.select(both, abs(cosine), cosine)
    shines = cosine > LEAST_COSINE
    cosine = dr.select(shines, cosine, 1)
    pdf_sa = dr.select(distance > TINY, area_pdf_sa(distance, cosine, inverse_area), 1)
    return DirectSample(
        wo, short_of(distance, p, cosine), dr.select(shines, radiance, Vector3f(0)), pdf_sa, Bool(False)
    )
