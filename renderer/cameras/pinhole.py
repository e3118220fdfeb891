"""Pinhole camera: all rays start at one point, and everything is sharp."""

import drjit as dr

from renderer.cameras.base import POSITION, CameraKind, direction, pack_view, register, view_height


def ray(row, position, u2=None):
    """Return the eye and the unit direction through `position`."""
    return row.vector(POSITION), dr.normalize(direction(row, position))


register(CameraKind("pinhole", lambda camera: pack_view(camera, view_height(camera)), ray))
