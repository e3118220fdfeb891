"""Orthographic camera: parallel rays, as in a plan. What is far away is as large as what is near.

Rays start on the plane through `position` and across the view; what is behind it is not seen. The picture is
`viewHeight` high; absent, as high as what `fov` shows at the distance of lookAt.
"""

import drjit as dr

from renderer.cameras.base import FORWARD, POSITION, REST, CameraKind, offset, pack_view, register, view_height
from renderer.core.backend import Vector3f
from renderer.core.numeric import widened
from renderer.core.vectors import length, subtract


def pack(camera):
    """Return the view, its steps in scene units."""
    return pack_view(camera, camera.viewHeight or view_height(camera, length(subtract(camera.lookAt, camera.position))))


def ray(row, position, u2=None):
    """Return the point of the plane that `position` shows, and the direction of view."""
    forward = dr.normalize(row.vector(FORWARD) + row.vector(REST))
    lanes = dr.width(position)
    return row.vector(POSITION) + offset(row, position), Vector3f(*(widened(part, lanes) for part in forward))


register(CameraKind("orthographic", pack, ray))
