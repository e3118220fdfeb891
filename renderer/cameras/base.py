"""What a camera kind provides, the registry that finds it by its name in the scene file, and what the kinds share.

The picture's x axis is unit(upVector x forward), its y axis runs down; the field of view is vertical. A direction
through the picture is forward + x * step_x + y * step_y, 1 along forward, with x and y in pixels from the middle. Small
parts are summed first, with what forward loses in float32 among them: pixels of narrow views are a few roundings wide.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from renderer.core.registry import Registry
from renderer.core.vectors import cross, single, subtract, unit

POSITION, FORWARD, REST, STEP_X, STEP_Y, MIDDLE = 0, 3, 6, 9, 12, 15  # columns of every record
END = 17  # of the columns above; a kind's own follow


@dataclass(frozen=True)
class CameraKind:
    """`pack(camera)` returns its record on the host; `ray(row, position, u2)` returns origins and unit directions.

    `position` is the point on the picture in pixels, from the top left corner, in lanes. `u2` is a pair of numbers in
    [0, 1) that chooses the point on the lens; absent, it is the lens's middle. Without `has_lens` it is never given.
    """

    name: str
    pack: Callable
    ray: Callable
    has_lens: bool = False


KINDS = Registry()
register = KINDS.register


def axes(camera):
    """Return the unit vectors forward, right and up of the picture."""
    forward = unit(subtract(camera.lookAt, camera.position))
    right = unit(cross(camera.upVector, forward))
    return forward, right, cross(forward, right)


def view_height(camera, distance=1.0):
    """Return how high what the field of view shows is at a distance along forward, scene units."""
    return 2 * math.tan(math.radians(camera.fov) / 2) * distance


def pack_view(camera, height):
    """Return position, unit direction forward and its rest, the steps of one pixel, and the middle in pixels.

    `height` is that of the picture, in scene units.
    """
    forward, right, up = axes(camera)
    rest = [component - single(component) for component in forward]
    step = height / camera.height
    step_x = [step * component for component in right]
    step_y = [-step * component for component in up]
    return [*camera.position, *forward, *rest, *step_x, *step_y, 0.5 * camera.width, 0.5 * camera.height]


def offset(row, position, start=0.0):
    """Return the way from the middle of the picture to `position`, added to the small vector `start`."""
    x, y = position.x - row[MIDDLE], position.y - row[MIDDLE + 1]
    return dr.fma(row.vector(STEP_X), x, dr.fma(row.vector(STEP_Y), y, start))


def direction(row, position):
    """Return the direction through `position`, as long as it takes to be 1 along forward."""
    return row.vector(FORWARD) + offset(row, position, row.vector(REST))
