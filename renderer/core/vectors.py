"""Vectors on the host: lists of three floats, in double precision, for building."""

import math
import struct


def single(number):
    """Return a number rounded to float32."""
    return struct.unpack("f", struct.pack("f", number))[0]


def length(vector):
    """Return the Euclidean length."""
    return math.hypot(*vector)


def unit(vector):
    """Return the vector scaled to length 1."""
    size = length(vector)
    return [component / size for component in vector]


def cross(a, b):
    """Return the cross product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    """Return the dot product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def subtract(a, b):
    """Return a - b."""
    return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]


def disk_reach(normal, radius):
    """Return how far a disk with this unit normal reaches along each axis: r sqrt(1 - n^2) for the cosine n to it."""
    return [radius * math.sqrt(max(0.0, 1 - n * n)) for n in normal]


def box_around(middle, reach):
    """Return the lowest and the highest corner of a box that reaches so far from its middle along each axis."""
    return [c - r for c, r in zip(middle, reach)], [c + r for c, r in zip(middle, reach)]


def frame(normal):
    """Return the tangents (t, b) of a unit normal that texture coordinates are measured along.

    t = unit(n x y), or unit(n x z) where n is within acos 0.9 of the y axis; b = n x t. Seen from where n points,
    through this renderer's camera, t runs to the right and b down, so that images are upright and not mirrored.
    """
    t = unit(cross(normal, [0.0, 1.0, 0.0] if abs(normal[1]) < 0.9 else [0.0, 0.0, 1.0]))
    return t, cross(normal, t)
