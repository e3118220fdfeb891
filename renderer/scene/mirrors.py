"""Lamps seen in mirrors: where on a mirror light from a point of a lamp is reflected to a given point.

Paths that leave a matt surface find a small lamp in a mirror by rare chance, and such light is most of the noise of
scenes with mirrors. A flat mirror shows the point's mirror image. On a ball, seen from outside, the reflection is where
both directions make the same angle with the normal: Alhazen's problem, solved by Newton's method in the plane of the
two points and the middle, between the last places that either point can see.

A bundle of rays of solid angle w from p that meets the mirror after d1, at an angle of cosine c, and goes on for d2,
has the cross section w (d1 + d2 a)(d1 + d2 b), where a = b = 1 for a flat mirror, and on a ball of radius r, in the
plane of reflection and across, a = 1 + 2 d1 / (r c) and b = 1 + 2 d1 c / r, by Coddington's equations
[Born1999, sec. 4.6]. This turns the density of points on the lamp into one of directions at p, by which both ways to
find the light are weighted.

Only flat lamps and few mirrors count, and single reflections; whatever else mirrors show is found by chance.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.colour import luminance
from renderer.core.numeric import TINY, greater, lesser, safe_sqrt
from renderer.core.rows import Rows
from renderer.core.vectors import cross, unit
from renderer.lights import sheet
from renderer.lights.base import LEAST_COSINE, direction_to

MOST_MIRRORS, MOST_LAMPS = 4, 8  # each is in the kernel
NEWTON_STEPS = 4  # leave angles wrong by at most 2e-4 up to a thousandth of a radius from the ball
MOST_STEP = 0.5  # radians; where the curve is flat, steps would lead anywhere
PLACE, NORMAL, RADIUS, COLOUR = 0, 3, 3, 6  # columns: the middle and radius of a ball, or a point and normal


@dataclass
class Spread:
    """How a bundle of rays widens behind a mirror: its cross section after d2 is w (d1 + d2 a)(d1 + d2 b)."""

    d1: Float
    a: Float
    b: Float

    def section(self, d2):
        """Return the cross section per steradian."""
        return dr.fma(d2, self.a, self.d1) * dr.fma(d2, self.b, self.d1)


@dataclass
class Way:
    """How light gets from a point q over a mirror to a point p, if `possible` and if nothing is in the way."""

    wo: Vector3f  # unit direction from p to the mirror
    x: Vector3f  # where that is met
    n: Vector3f  # normal of its shape there
    spread: Spread  # behind it, of rays from p
    colour: Vector3f  # of the mirror
    mirror: UInt32  # index of its shape
    possible: Bool


@dataclass
class Reflection:
    """A Way to a point of a lamp; light takes it if the ray meets the mirror first, and then the lamp."""

    wo: Vector3f  # of the Way
    x: Vector3f
    n: Vector3f
    mirror: UInt32
    to_lamp: Vector3f  # unit direction from the mirror
    lamp: UInt32  # index of its shape
    radiance: Vector3f  # of the lamp, times the mirror's colour; 0 where there is no way
    pdf_sa: Float  # with which the direction at p was chosen


class Mirrors:
    """The mirrors and lamps of a scene."""

    def __init__(self, mirrors, lamps):
        """Hold [(shape number, shape, colour)] and Emitters."""
        balls = [mirror for mirror in mirrors if mirror[1].type == "sphere"]
        flats = [mirror for mirror in mirrors if mirror[1].type in sheet.CODES]
        self._groups = [Group(own, find) for own, find in ((balls, on_ball), (flats, on_flat)) if own]
        self._count = len(mirrors)
        power = [luminance(lamp.shape.emission) * lamp.area for lamp in lamps]
        self._shares = [part / sum(power) for part in power]
        self._lamps = [lamp.shape_index for lamp in lamps]
        records = [sheet.pack(lamp.shape, lamp.twosided) for lamp in lamps]
        self._rows, self._has = Rows(records, directions=sheet.EDGES), sheet.features(records)
        self._densities = Rows([[share / lamp.area / self._count] for share, lamp in zip(self._shares, lamps)])

    @classmethod
    def of(cls, shapes, emitters):
        """Return the Mirrors among shapes in their compiled order, or None where these are of no use."""
        mirrors = [(number, shape, colour_of(shape)) for number, shape in enumerate(shapes) if colour_of(shape)]
        lamps = [emitter for emitter in emitters if emitter.area and emitter.shape.type in sheet.CODES]
        useful = 0 < len(mirrors) <= MOST_MIRRORS and 0 < len(lamps) <= MOST_LAMPS
        return cls(mirrors, lamps) if useful else None

    def sample(self, p, choices, u2):
        """Return a Reflection for each point p: over one of the mirrors, to a random point of one of the lamps."""
        masks = self._lamp_masks(choices.x)
        row = self._rows.chosen(masks)
        q, n = sheet.point(row, u2, self._has)
        way = self._way(UInt32(choices.y * self._count), p, q)
        to_lamp, distance = direction_to(q, way.x)
        cosine = -dr.dot(n, to_lamp)
        cosine = dr.select(row[sheet.ONE_SIDED] == 0, abs(cosine), cosine)
        possible = way.possible & (cosine > LEAST_COSINE)
        pdf_sa = self._densities.chosen(masks)[0] * way.spread.section(distance) / dr.select(possible, cosine, 1)
        radiance = dr.select(possible, row.vector(sheet.RADIANCE) * way.colour, Vector3f(0))
        lamp = _numbered(self._lamps, masks)
        return Reflection(way.wo, way.x, way.n, way.mirror, to_lamp, lamp, radiance, dr.select(possible, pdf_sa, 1))

    def pdf_sa(self, shape_index, cosine, distance, spread):
        """Return the density with which `sample` finds a lamp that was met over a mirror; 0 for what is no lamp."""
        density = Float(0)
        for k, number in enumerate(self._lamps):
            density = dr.select(shape_index == number, self._densities[k][0], density)
        return density * spread.section(distance) / greater(abs(cosine), Float(LEAST_COSINE))

    def spread(self, shape_index, cosine, distance):
        """Return whether a shape that was met is one of the mirrors, balls from outside, and the Spread behind it.

        `cosine` is that of the way back to the outward normal.
        """
        known, curvature = Bool(False), Float(0)
        for group in self._groups:
            for k, number in enumerate(group.shapes):
                here = shape_index == number
                if group.find is on_ball:
                    here = here & (cosine > 0)
                    curvature = dr.select(here, 2 * dr.rcp(group.rows[k][RADIUS]), curvature)
                known = known | here
        return known, _spread(distance, abs(cosine), curvature)

    def _lamp_masks(self, u):
        """Return the masks of the lamps from the second on, of which the last true one is chosen."""
        masks, before = [], 0.0
        for share in self._shares[:-1]:
            before += share
            masks.append(u >= before)
        return masks

    def _way(self, number, p, q):
        """Return the Way over the mirror with a number."""
        way, first = self._groups[0].way(number, p, q), len(self._groups[0].shapes)
        for group in self._groups[1:]:
            way = dr.select(number >= first, group.way(number - first, p, q), way)
        return way


class Group:
    """The mirrors of one form; `find` is `on_ball` or `on_flat`."""

    def __init__(self, mirrors, find):
        self.shapes, self.find = [number for number, _, _ in mirrors], find
        self.rows = Rows([[*form(shape), *colour] for _, shape, colour in mirrors])

    def way(self, number, p, q):
        """Return the Way over the mirror with each lane's number."""
        masks = [number == k for k in range(1, len(self.shapes))]
        row = self.rows.chosen(masks)
        wo, x, n, spread, possible = self.find(row, p, q)
        return Way(wo, x, n, spread, row.vector(COLOUR), _numbered(self.shapes, masks), possible)


def colour_of(shape):
    """Return how much a shape that is a perfect mirror, or in part, reflects; None for others."""
    material = shape.material
    if shape.type != "sphere" and shape.type not in sheet.CODES or material.normalmap or material.bumpmap:
        return None
    if material.bsdf is None:
        mirror = material.isreflective and not material.isrefractive and material.roughness == 0
        return (material.reflectivity,) * 3 if mirror and material.reflectivity > 0 else None
    mirror = material.bsdf.type == "mirror" and isinstance(material.bsdf.reflectance, tuple)
    return material.bsdf.reflectance if mirror and any(material.bsdf.reflectance) else None


def form(shape):
    """Return the columns that tell where a mirror is."""
    if shape.type == "sphere":
        return [*shape.center, shape.radius, 0.0, 0.0]
    corner, u, v = sheet.edges(shape)
    return [*corner, *unit(cross(u, v))]


def on_flat(row, p, q):
    """Return (wo, x, n, Spread, possible) of the way over a plane, on which both points lie on one side."""
    n = row.vector(NORMAL)
    p_height, q_height = dr.dot(n, p - row.vector(PLACE)), dr.dot(n, q - row.vector(PLACE))
    image = q - n * (2 * q_height)
    wo, _ = direction_to(image, p)
    total = p_height + q_height
    share = p_height / dr.select(total == 0, Float(1), total)
    x = dr.lerp(p, image, share)
    possible = p_height * q_height > 0
    return wo, x, n, Spread(dr.norm(x - p), Float(1), Float(1)), possible


def on_ball(row, p, q):
    """Return (wo, x, n, Spread, possible) of the way over a ball, for points outside of it."""
    centre, radius = row.vector(PLACE), row[RADIUS]
    to_p, a = direction_to((p - centre) * dr.rcp(radius), Vector3f(0))
    to_q, b = direction_to((q - centre) * dr.rcp(radius), Vector3f(0))
    cos_phi = dr.dot(to_p, to_q)
    across = to_q - to_p * cos_phi
    sin_phi = dr.norm(across)
    across *= dr.rcp(greater(sin_phi, Float(TINY)))

    c, s = alhazen(a, b, cos_phi, sin_phi)
    n = dr.fma(to_p, c, across * s)
    x = dr.fma(n, radius, centre)
    wo, d1 = direction_to(x, p)
    cosine = -dr.dot(wo, n)
    possible = (a > 1) & (b > 1) & (cosine > LEAST_COSINE) & (dr.dot(q - x, n) > 0)
    return wo, x, n, _spread(d1, cosine, 2 * dr.rcp(radius)), possible


def alhazen(a, b, c0, s0):
    """Return cosine and sine of the angle t from p to the normal of a ball at which p and q see each other.

    In units of its radius, a and b are the distances of p and q from the middle, c0 and s0 cosine and sine of the angle
    phi between them. There a b sin(2 t - phi) - a sin t + b sin(phi - t) = 0: tangents of both angles are equal. Cosine
    and sine of t are followed, not t.
    """
    inverse_a, inverse_b = dr.rcp(a), dr.rcp(b)
    side_a, side_b = safe_sqrt(1 - dr.square(inverse_a)), safe_sqrt(1 - dr.square(inverse_b))
    last_p = inverse_a, side_a  # cosine and sine of the last normal that p can see, and that q can
    last_q = c0 * inverse_b + s0 * side_b, s0 * inverse_b - c0 * side_b

    def between(c, s):
        beyond = c < inverse_a
        c, s = dr.select(beyond, last_p[0], c), dr.select(beyond, last_p[1], s)
        beyond = c0 * c + s0 * s < inverse_b
        return dr.select(beyond, last_q[0], c), dr.select(beyond, last_q[1], s)

    def unit_of(c, s):
        scale = dr.rsqrt(greater(dr.square(c) + dr.square(s), Float(TINY)))
        return c * scale, s * scale

    near_p, near_q = (b - 1) * a, (a - 1) * b  # weights of the two directions to begin with
    c, s = between(*unit_of(dr.fma(near_q, c0, near_p), near_q * s0))
    for _ in range(NEWTON_STEPS):
        c_rest, s_rest = c0 * c + s0 * s, s0 * c - c0 * s  # of phi - t
        value = a * b * (s * c_rest - c * s_rest) - a * s + b * s_rest
        slope = 2 * a * b * (c * c_rest + s * s_rest) - a * c - b * c_rest
        step = value / dr.select(slope == 0, Float(1), slope)
        step = lesser(greater(step, Float(-MOST_STEP)), Float(MOST_STEP))
        c, s = between(*unit_of(dr.fma(s, step, c), dr.fma(-c, step, s)))
    return c, s


def _spread(d1, cosine, curvature):
    """Return the Spread behind a mirror met at a distance and angle; `curvature` is 2 / radius, 0 for a flat one."""
    by_radius = d1 * curvature
    return Spread(d1, 1 + by_radius / greater(cosine, Float(LEAST_COSINE)), dr.fma(by_radius, cosine, 1))


def _numbered(numbers, masks):
    """Return the number that belongs to the last true mask, the first one where none is."""
    result = UInt32(numbers[0])
    for number, mask in zip(numbers[1:], masks):
        result = dr.select(mask, UInt32(number), result)
    return result
