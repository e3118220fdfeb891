"""The scene format's cameras as Mitsuba's sensors."""

from __future__ import annotations

import math

import numpy as np

from converters.geometry import matrix, unit

NEAR, FAR = 1e-3, 1e7  # scene units


def camera_matrix(camera, scale=1.0):
    """Return Mitsuba's camera-to-world matrix: its +x is the picture's left, so the frame is left-handed.

    `scale` stretches the picture's axes, by which Mitsuba is told the size of an orthographic picture.
    """
    forward = unit(np.subtract(camera.lookAt, camera.position))
    right = unit(np.cross(camera.upVector, forward))
    return matrix(-scale * right, scale * np.cross(forward, right), forward, camera.position)


def sensor(camera, with_lens=True):
    """Return the name of Mitsuba's plugin and its parameters; without its lens, a thin lens is a pinhole."""
    common = {"near_clip": NEAR, "far_clip": FAR}
    if camera.type == "orthographic":
        # Mitsuba's picture is 2 units wide.
        half_width = view_height(camera) * camera.width / camera.height / 2
        return "orthographic", {**common, "to_world": camera_matrix(camera, half_width)}
    common |= {"fov": float(camera.fov), "fov_axis": "y", "to_world": camera_matrix(camera)}
    if camera.type == "pinhole" or camera.apertureRadius == 0 or not with_lens:
        return "perspective", common
    focus = camera.focusDistance or _distance(camera)
    return "thinlens", {**common, "aperture_radius": float(camera.apertureRadius), "focus_distance": float(focus)}


def view_height(camera):
    """Return the height of an orthographic picture, in scene units."""
    return camera.viewHeight or 2 * math.tan(math.radians(camera.fov) / 2) * _distance(camera)


def _distance(camera):
    """Return how far away is what the camera looks at."""
    return math.dist(camera.lookAt, camera.position)
