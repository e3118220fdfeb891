"""Pinhole camera.

The picture's x axis is unit(upVector x forward), its y axis runs down; the field of view is vertical. A ray's
direction is corner + x * step_x + y * step_y, normalised: the three vectors are combined once in double precision.
"""

import math

import drjit as dr

from renderer.cameras.base import CameraKind, register
from renderer.core.vectors import cross, subtract, unit

POSITION, CORNER, STEP_X, STEP_Y = 0, 3, 6, 9


def pack(camera):
    """Return position, direction through the top left corner of the picture, and the steps of one pixel."""
    forward = unit(subtract(camera.lookAt, camera.position))
    right = unit(cross(camera.upVector, forward))
    up = cross(forward, right)
    step = 2 * math.tan(math.radians(camera.fov) / 2) / camera.height
    step_x = [step * component for component in right]
    step_y = [-step * component for component in up]
    corner = [
        f - 0.5 * camera.width * x - 0.5 * camera.height * y for f, x, y in zip(forward, step_x, step_y)
    ]
    return [*camera.position, *corner, *step_x, *step_y]


def ray(row, position):
    """Return the eye and the unit direction through `position`."""
    direction = dr.fma(row.vector(STEP_X), position.x, row.vector(CORNER))
    direction = dr.fma(row.vector(STEP_Y), position.y, direction)
    return row.vector(POSITION), dr.normalize(direction)


register(CameraKind("pinhole", pack, ray))
