"""Camera rays.

A picture of 8000 x 6000 pixels through a field of view of 0.1 degrees has pixels of five roundings of a direction's
components; of 170 degrees, sums that are a tenth of what is added. A view that is nearly parallel to `upVector` loses
the picture's right in a cross product. Errors are angles between directions, in pixels or in radians, against double
precision. Places are the corners of the picture, its middle and 50,000 others.
"""

import dataclasses
import math

import numpy as np

from renderer.core.backend import Vector2f
from renderer.scene.schema import Camera
from renderer.scene.tables import compile_camera
from tests.stability.case import ULP, Case, mitsuba
from tests.stability.maps import MIDDLE, exact_disk

WIDTH, HEIGHT = 8000, 6000
VIEW = Camera(width=WIDTH, height=HEIGHT, position=(1.0, 2.0, -5.0), lookAt=(0.25, 0.5, 1.0),
              upVector=(0.25, 1.0, 0.125))  # fmt: skip
WIDE = dataclasses.replace(VIEW, fov=170.0)
NARROW = [dataclasses.replace(VIEW, fov=0.1, lookAt=tuple(map(float, place)))
          for place in np.random.default_rng(5).normal(size=(12, 3)).astype(np.float32)]  # fmt: skip
LENS = dataclasses.replace(VIEW, type="thinlens", fov=50.0, position=(1e6, -1e6, 1e6),
                           lookAt=(1e6 - 3.0, 4.0 - 1e6, 1e6 + 12.0))  # fmt: skip
LENSES = [dataclasses.replace(LENS, focusDistance=focus, apertureRadius=radius)
          for focus, radius in ((13.0, 1e-6), (13.0, 1.0), (1e6, 1e-6), (1e6, 1.0))]  # fmt: skip
STEEP = [10.0**-k for k in range(3, 8)]  # angles between the view and `upVector`


def steep(angle):
    """Return a view so near to `upVector`, all of its numbers float32."""
    x, y, z = map(float, np.array([0.3, 1.1, 0.7], np.float32))
    up = float(np.float32(x + angle)), y, z
    return dataclasses.replace(VIEW, fov=50.0, position=(0.0, 0.0, 0.0), lookAt=(x, y, z), upVector=up)


def places():
    """Return places in the picture in pixels, (2, N) float32."""
    corners = [[0, 0, WIDTH, WIDTH, WIDTH / 2], [0, HEIGHT, 0, HEIGHT, HEIGHT / 2]]
    inside = np.random.default_rng(1).random((2, 50_000)) * [[WIDTH], [HEIGHT]]
    return np.concatenate([corners, inside], axis=1).astype(np.float32)


def lens_points():
    """Return pairs of numbers in [0, 1) for the lens, (2, N) float32."""
    return np.random.default_rng(2).random(places().shape, np.float32)


def lensed(camera, d, number):
    """Return the lens's offsets (3, N), and directions from there to where those from its middle are in focus."""
    _, right, up = axes(camera, number)
    p = exact_disk(lens_points() + MIDDLE)[0].astype(number) * number(camera.apertureRadius)
    offset = p[1] * up[:, None] - p[0] * right[:, None]
    return offset, d * number(camera.focusDistance) - offset


def axes(camera, number):
    """Return forward, right and up (3,), in the precision `number`."""
    position, look_at, up = (np.array(v, number) for v in (camera.position, camera.lookAt, camera.upVector))
    forward = look_at - position
    forward = forward / np.sqrt((forward * forward).sum())
    right = np.cross(up, forward)
    right = right / np.sqrt((right * right).sum())
    return forward, right, np.cross(forward, right)


def from_corner(camera, xy, number=np.float32):
    """Return the textbook's unit directions: those through the picture's corner, and steps along its axes."""
    forward, right, up = axes(camera, number)
    step = number(2 * math.tan(math.radians(camera.fov) / 2) / HEIGHT)
    corner = forward - number(0.5 * WIDTH) * step * right + number(0.5 * HEIGHT) * step * up
    xy = xy.astype(number)
    d = corner[:, None] + xy[0] * step * right[:, None] - xy[1] * step * up[:, None]
    return d / np.sqrt((d * d).sum(axis=0))


def from_lens(camera, xy):
    """Return the textbook's unit directions, between two points in the world."""
    eye = np.array(camera.position, np.float32)[:, None]
    d = from_corner(camera, xy)
    d = d / (axes(camera, np.float32)[0] @ d)
    offset, _ = lensed(camera, d, np.float32)
    d = (eye + d * np.float32(camera.focusDistance)) - (eye + offset)
    return d / np.sqrt((d * d).sum(axis=0))


def exact(camera, xy):
    """Return the directions in double precision."""
    d = from_corner(camera, xy, float)
    if camera.type == "thinlens":
        _, d = lensed(camera, d / (axes(camera, float)[0] @ d), float)
    return d / np.linalg.norm(d, axis=0)


def ours(camera, xy):
    """Return the renderer's directions."""
    kind, row = compile_camera(camera)
    return kind.ray(row, Vector2f(xy), Vector2f(lens_points()) if kind.has_lens else None)[1].numpy()


def mitsubas(camera, xy):
    """Return Mitsuba's directions; its x runs to the left, so that both its axes are turned about."""
    mi = mitsuba()
    to_world = mi.ScalarTransform4f().look_at(origin=camera.position, target=camera.lookAt, up=camera.upVector)
    settings = {"type": "perspective"}
    if camera.type == "thinlens":
        settings = {"type": "thinlens", "aperture_radius": camera.apertureRadius,
                    "focus_distance": camera.focusDistance}  # fmt: skip
    sensor = mi.load_dict({
        **settings, "fov": camera.fov, "fov_axis": "y", "to_world": to_world, "near_clip": 1e-2, "far_clip": 1e7,
        "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}},
    })  # fmt: skip
    place = mi.Point2f((np.float32(1) - xy[0] / np.float32(WIDTH), xy[1] / np.float32(HEIGHT)))
    ray, _ = sensor.sample_ray(0.0, 0.0, place, mi.Point2f(lens_points()))
    return ray.d.numpy()


def angles(d, wanted):
    """Return the angles between directions (3, N), the second exact and unit."""
    d = np.asarray(d, float)
    return np.arctan2(np.linalg.norm(np.cross(d.T, wanted.T), axis=1), (d * wanted).sum(axis=0))


def errors(cameras, directions, unit=1.0):
    """Return a callable: errors of a function's directions for several cameras, in radians or units of so many."""

    def measure():
        xy = places()
        return np.concatenate([angles(directions(camera, xy), exact(camera, xy)) for camera in cameras]) / unit

    return measure


PIXEL = math.radians(0.1) / HEIGHT
CASES = (
    Case("pixels of a field of view of 0.1 degrees", "pixels", 2 * 3**0.5 * 0.5 * ULP / PIXEL,
         "sum and normalisation round each of three components by half of 2^-24", errors(NARROW, ours, PIXEL),
         errors(NARROW, from_corner, PIXEL), "steps from the picture's corner", errors(NARROW, mitsubas, PIXEL)),
    Case("directions of a field of view of 170 degrees", "radians", 4 * ULP,
         "steps, two products, the sum and normalisation round once each, and not all along one direction",
         errors([WIDE], ours), errors([WIDE], from_corner), "steps from the picture's corner",
         errors([WIDE], mitsubas)),
    Case("views 1e-3 to 1e-7 from straight up", "radians", 3 * ULP, "as other views; axes are made in double precision",
         errors([*map(steep, STEEP)], ours), errors([*map(steep, STEEP)], from_corner), "axes in float32",
         errors([*map(steep, STEEP[:3])], mitsubas), "asked down to 1e-5; nearer, it refuses its own matrix"),
    Case("thin lenses a million units from the origin", "radians", 4 * ULP,
         "as other views, and the lens's offset is subtracted", errors(LENSES, ours), errors(LENSES, from_lens),
         "from a point of the lens to a point in focus", errors(LENSES, mitsubas)),
)  # fmt: skip
