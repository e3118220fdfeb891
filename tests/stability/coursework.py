"""Shadows in the coursework's scene.

Its floor is a sphere of radius 25.1 of which only the top is seen, so that points on it have the rounding of 25 where
they are some 0.1 to 2 from the world's origin, and a cylinder stands on it. First hits of 1200 x 800 camera rays, every
fifth in both directions, look at both lights, in the scene as it is, and 1024 times as small and as large. A
double-precision twin says from where these are seen; hits count where it says the same from points 1e-5 aside along
each axis, so that edges of shadows do not.
"""


from functools import lru_cache
from pathlib import Path

import numpy as np

from renderer.core.backend import Bool, Float
from renderer.scene.loader import load
from tests.stability import probe, stage
from tests.stability.case import Case
from tests.support.twin import MISS, Twin

FILE = Path(__file__).resolve().parent.parent.parent / "scenes" / "scene.json"
STEP = 5  # pixels
SCALES = 1.0, 2.0**-10, 2.0**10
ASIDE = 1e-5  # scene units
LEAST_COSINE = 1e-3  # flatter light counts as seen from behind


def scaled(shape, scale):
    """Return a shape of another size, without its material; powers of two round nothing."""
    names = [name for name in stage.POINTS | stage.LENGTHS if hasattr(shape, name)]
    values = {name: (scale * np.array(getattr(shape, name))).tolist() for name in names}
    values = {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}
    return type(shape)(**values, **({"axis": shape.axis} if hasattr(shape, "axis") else {}))


@lru_cache(maxsize=4)
def first_hits(scale):
    """Return the shapes, their Geometry, camera rays, hits, surfaces, and for each light what follows.

    Its place, directions and distances, from where it is seen, and where that is known.
    """
    loaded = load(str(FILE))
    shapes, twin = tuple(scaled(shape, scale) for _, shape in loaded.shapes), Twin(loaded)
    geometry = stage.scene(*shapes)
    camera = loaded.description.camera
    o, d = (part.reshape(camera.height, camera.width, 3)[::STEP, ::STEP].reshape(-1, 3) for part in twin.camera_rays())
    o, d = np.float32(scale * o), probe.unit(d)
    hit, surface = stage.seen(geometry, o, d)
    p, n = probe.doubles(surface.p).T / scale, probe.doubles(surface.n_geo).T
    n = -n * np.sign((n * d).sum(1, keepdims=True))
    aside = [np.zeros(3), *(ASIDE * np.eye(3)), *(-ASIDE * np.eye(3))]
    lights = []
    for light in loaded.description.scene.lightsources:
        way = np.array(light.position) - p
        distance = np.linalg.norm(way, axis=1)
        facing = hit.valid.numpy() & ((way * n).sum(1) > LEAST_COSINE * distance)
        seen = [_sees(twin, p + ASIDE * n + offset, way, distance) for offset in aside]
        known = facing & np.all([one == seen[0] for one in seen], axis=0)
        place = scale * np.array(light.position)
        lights.append((place, probe.unit(way), np.float32(scale * distance), seen[0], known))
    return shapes, geometry, (o, d), hit, surface, lights


def _sees(twin, p, way, distance):
    """Return from which points nothing lies on the way to a light, in double precision."""
    t, index, _, _ = twin.intersect(p, way / distance[:, None])
    return (index == MISS) | (t >= distance)


def wrong(rays):
    """Return from which points a light is wrongly seen or not seen."""
    found = []
    for scale in SCALES:
        _, geometry, _, hit, surface, lights = first_hits(scale)
        for _, d, distance, seen, known in lights:
            blocked = geometry.occluded(rays(hit, surface, d), Float(distance), Bool(True)).numpy()
            found.append((blocked == seen)[known])
    return np.concatenate(found)


def wrong_by_textbook():
    """Return from where light is lost by roots of b^2 - 4ac of the spheres, in single precision, beyond 1e-4."""
    found = []
    for scale in SCALES:
        shapes, _, _, _, surface, lights = first_hits(scale)
        p = surface.p.numpy().T
        for _, d, distance, seen, known in lights:
            blocked = np.zeros(len(p), bool)
            for ball in (shape for shape in shapes if shape.type == "sphere"):
                near, far, real = _textbook_roots(p - np.float32(ball.center), d, np.float32(ball.radius))
                for t in (near, far):
                    blocked |= real & (t > stage.EPSILON) & (t < distance)
            found.append((blocked & seen)[known])
    return np.concatenate(found)


def _textbook_roots(f, d, radius):
    """Return both roots of the textbook's quadratic, and whether there are any."""
    a, b, c = (d * d).sum(1), 2 * (f * d).sum(1), (f * f).sum(1) - radius**2
    square = b * b - 4 * a * c
    root = np.sqrt(np.maximum(square, 0))
    return (-b - root) / (2 * a), (-b + root) / (2 * a), square >= 0


def wrong_mitsuba():
    """Return the same as of ours of Mitsuba."""
    mi, found = stage.mitsuba(), []
    for scale in SCALES:
        shapes, _, (o, d), _, _, lights = first_hits(scale)
        scene, met = stage.theirs(shapes, o, d)
        for place, _, _, seen, known in lights:
            blocked = scene.ray_test(met.spawn_ray_to(mi.Point3f(*place.tolist()))).numpy()
            found.append((blocked == seen)[known])
    return np.concatenate(found)


CASES = (
    Case("shadows at first hits of the coursework's scene, at three scales", "share", 0,
         "where the twin is sure, whoever knows the shape that was left is sure too",
         lambda: wrong(stage.ours), wrong_by_textbook,
         "roots of b^2 - 4ac of the spheres beyond 1e-4; only light that is lost counts", wrong_mitsuba),
)
