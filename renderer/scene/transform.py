"""The matrix of a list of transformation steps, in pure Python: the description of a scene knows no numpy."""

from __future__ import annotations

import math

IDENTITY = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def matrix(steps):
    """Return the 4x4 matrix (a tuple of rows) that applies the steps in their order to column vectors (x, y, z, 1).

    Steps are records of the description (`schema.Step`), of which exactly one key is not None. Rotations are
    counterclockwise for who looks against their axis, in right-handed coordinates. Its last row is 0 0 0 1.
    """
    made = IDENTITY
    for step in steps:
        made = product(_of(step), made)
    return made


def product(a, b):
    """Return the product of two 4x4 matrices: `b` is applied first."""
    columns = tuple(zip(*b))
    return tuple(tuple(sum(x * y for x, y in zip(row, column)) for column in columns) for row in a)


def determinant(m):
    """Return the determinant of a 4x4 matrix whose last row is 0 0 0 1: the factor of volumes, negative if mirrored."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _), _ = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def _of(step):
    """Return the matrix of one step."""
    if step.translate is not None:
        x, y, z = step.translate
        return (1.0, 0.0, 0.0, x), (0.0, 1.0, 0.0, y), (0.0, 0.0, 1.0, z), IDENTITY[3]
    if step.scale is not None:
        x, y, z = step.scale
        return (x, 0.0, 0.0, 0.0), (0.0, y, 0.0, 0.0), (0.0, 0.0, z, 0.0), IDENTITY[3]
    if step.rotate is not None:
        return _rotation(step.rotate.axis, step.rotate.angle)
    return tuple(tuple(step.matrix[row * 4 : row * 4 + 4]) for row in range(4))


def _rotation(axis, angle):
    """Return the rotation by `angle` degrees around an axis through the origin (Rodrigues' formula)."""
    size = math.hypot(*axis)
    x, y, z = (component / size for component in axis)
    cosine, sine = _cos_sin(angle)
    rest = 1.0 - cosine
    return (
        (cosine + x * x * rest, x * y * rest - z * sine, x * z * rest + y * sine, 0.0),
        (y * x * rest + z * sine, cosine + y * y * rest, y * z * rest - x * sine, 0.0),
        (z * x * rest - y * sine, z * y * rest + x * sine, cosine + z * z * rest, 0.0),
        IDENTITY[3],
    )


def _cos_sin(angle):
    """Return cosine and sine of an angle in degrees, exact at multiples of 90."""
    angle = math.fmod(angle, 360.0)
    quarter = angle / 90.0
    if quarter.is_integer():
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    return math.cos(math.radians(angle)), math.sin(math.radians(angle))
