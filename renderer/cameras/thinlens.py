"""Thin lens: rays start on a round lens and meet where a pinhole's ray crosses the plane in focus [Potmesil1981].

With d the point on the unit disk, the origin is position + radius (d_y up - d_x right). The plane in focus lies at
`focusDistance` along forward; absent, it goes through lookAt. Limits: no distortion, no vignetting, a round aperture.
"""

import drjit as dr

from renderer.cameras.base import END, POSITION, CameraKind, axes, direction, pack_view, register, view_height
from renderer.core.vectors import length, subtract
from renderer.core.warp import square_to_disk

LENS_X, LENS_Y, SHARPNESS = END, END + 3, END + 6  # offsets at the lens's rim; 1 / focus distance


def pack(camera):
    """Return the view, the offsets of the lens's axes, and the reciprocal of the focus distance."""
    _, right, up = axes(camera)
    lens_x = [-camera.apertureRadius * component for component in right]
    lens_y = [camera.apertureRadius * component for component in up]
    focus = camera.focusDistance or length(subtract(camera.lookAt, camera.position))
    return [*pack_view(camera, view_height(camera)), *lens_x, *lens_y, 1 / focus]


def ray(row, position, u2=None):
    """Return the point on the lens, and the unit direction from there to where `position` is in focus."""
    eye, through = row.vector(POSITION), direction(row, position)
    if u2 is None:
        return eye, dr.normalize(through)
    point = square_to_disk(u2)
    offset = row.vector(LENS_X) * point.x + row.vector(LENS_Y) * point.y
    return eye + offset, dr.normalize(through - offset * row[SHARPNESS])


register(CameraKind("thinlens", pack, ray, has_lens=True))
