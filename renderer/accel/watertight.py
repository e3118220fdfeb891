"""Pairs of triangles against rays, so that no ray slips through an edge or a corner that triangles share.

After [Woop2013], the corners are projected along the ray, here onto two axes perpendicular to it, and the signs of
three edge functions x_i y_j - x_j y_i decide. A corner is projected alike in every triangle that has it, and a
difference of products computed with Kahan's compensation has the exact sign [Jeannerod2013]: neighbours see the same
planar figure and agree on which side of their edge the ray passes. A zero counts as inside for both. Products must
neither overflow nor vanish, which holds for corners between 1e-15 and 1e15 scene units from the ray.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.accel.records import NO_PRIMITIVE, PRIMITIVE, WORDS
from renderer.core.backend import Float, UInt32, Vector3f

CORNERS, SECOND = 4, 13  # corners of a pair, from word 0 on; the word of the second triangle's number


@dataclass
class Axes:
    """Coordinates along a ray, with its origin at zero and z along it."""

    o: Vector3f
    x: Vector3f
    y: Vector3f
    z: Vector3f

    @classmethod
    def of(cls, ray):
        """Return the axes of rays: an orthonormal basis around their direction [Duff2017]."""
        d = ray.d
        sign = dr.select(d.z >= 0, Float(1), -1)
        a = -dr.rcp(sign + d.z)
        b = d.x * d.y * a
        x = Vector3f(dr.fma(sign * d.x * d.x, a, 1), sign * b, -sign * d.x)
        return cls(ray.o, x, Vector3f(b, dr.fma(d.y * d.y, a, sign), -d.y), d)

    def project(self, corner):
        """Return the coordinates of a point."""
        v = corner - self.o
        return Vector3f(dr.dot(self.x, v), dr.dot(self.y, v), dr.dot(self.z, v))


def edge(a, b):
    """Return a.x b.y - a.y b.x within 1.5 units in the last place, and so with its exact sign."""
    product = a.y * b.x
    return dr.fma(a.x, b.y, -product) + dr.fma(-a.y, b.x, product)


def test(words, axes):
    """Return for both triangles of a pair whether the line meets it, where, and its number.

    The pair's triangles are (0, 1, 2) and (0, 2, 3). Where a triangle is seen edge-on, or has no area, t is NaN.
    """
    v = [Vector3f(*(dr.reinterpret_array(Float, word) for word in words[3 * k : 3 * k + 3])) for k in range(CORNERS)]
    p = [axes.project(corner) for corner in v]
    diagonal = edge(p[2], p[0])
    first = _triangle(p[0], p[1], p[2], edge(p[1], p[2]), diagonal, edge(p[0], p[1]))
    second = _triangle(p[0], p[2], p[3], edge(p[2], p[3]), edge(p[3], p[0]), -diagonal)
    return (*first, words[PRIMITIVE]), (*second, words[SECOND])


def corners(words, number):
    """Return the corners of the triangle of a pair that has this number, if pairs.turn_alike in their input's order."""
    v = [Vector3f(*(dr.reinterpret_array(Float, word) for word in words[3 * k : 3 * k + 3])) for k in range(CORNERS)]
    second = words[SECOND] == number
    return v[0], dr.select(second, v[3], v[2]), dr.select(second, v[2], v[1])


def _triangle(a, b, c, at_a, at_b, at_c):
    """Return whether the ray passes inside, and the depth there; `at_a` is the edge function opposite to a."""
    inside = ((at_a >= 0) & (at_b >= 0) & (at_c >= 0)) | ((at_a <= 0) & (at_b <= 0) & (at_c <= 0))
    return inside, dr.fma(at_a, a.z, dr.fma(at_b, b.z, at_c * c.z)) / (at_a + at_b + at_c)


def barycentric(axes, a, b, c):
    """Return the weights of the corners b and c where the line meets the plane of a triangle that it meets."""
    a, b, c = axes.project(a), axes.project(b), axes.project(c)
    at_a, at_b, at_c = edge(b, c), edge(c, a), edge(a, b)
    area = at_a + at_b + at_c
    return at_b / area, at_c / area


def leaf_words(pairs, first_index):
    """Return the leaf words (UInt32, 16 an item) of `Pairs` of triangles from `first_index` on, but for the tag."""
    count = len(pairs.first)
    words, place = dr.zeros(UInt32, WORDS * count), WORDS * dr.arange(UInt32, count)
    for k, corner in enumerate((pairs.v0, pairs.v1, pairs.v2, pairs.v3)):
        for axis in range(3):
            dr.scatter(words, dr.reinterpret_array(UInt32, corner[axis]), place + (3 * k + axis))
    offset = dr.opaque(UInt32, first_index)
    dr.scatter(words, pairs.first + offset, place + PRIMITIVE)
    dr.scatter(words, dr.select(pairs.second == NO_PRIMITIVE, NO_PRIMITIVE, pairs.second + offset), place + SECOND)
    return words
