"""Seams: sheets that go on in one plane.

A point on a quad's one triangle lies off the other's plane by rounding, on either side, and a ray that leaves it at a
grazing angle meets that plane far away. Here a ray does not meet a sheet that it starts closer to than rounding can
tell: 2 roundoffs of the origin's coordinates, and 10 of what the sheet's extent has along its normal
(`renderer/shapes/base.py`). Meshes have no such test; there the ray starts off its triangle. The points are within 1e-4
of a size of the seam, turned and along axes, from 1e-4 to 1e6 across and up to 1000 sizes from the world's origin.
"""

from functools import lru_cache

import numpy as np

from tests.stability import probe, stage
from tests.stability.case import ULP, Case

SEAM_RAYS = 20_000
QUAD = np.array([[-1, -1], [1, -0.9], [1.1, 1], [-0.7, 0.9]])
FRAMES = {"turned": stage.TURN, "along axes": np.eye(3)[[2, 0, 1]]}
BAND = 1e-4  # of a size, or 100 roundoffs of coordinates: how close to the seam points are


@lru_cache(maxsize=64)
def neighbours(what, frame, place):
    """Return shapes or corners of two neighbours, their Geometry, rays that meet them near their seam, and the hits."""
    axes, (scale, sizes) = FRAMES[frame], stage.PLACES[place]
    middle = scale * sizes * np.array([0.9, -0.7, 1.0])
    quad = QUAD @ axes[:2]
    halves = [dict(zip(("v0", "v1", "v2"), quad[order])) for order in ([0, 1, 2], [0, 2, 3])]
    if what == "tiles":
        u, v = 0.9 * axes[0], 1.7 * axes[1]
        shapes = tuple(stage.placed("rectangle", place, center=k * u / 2, u=u, v=v) for k in (-1, 1))
        ends = -v / 2, v / 2
    else:
        shapes = tuple(stage.placed("triangle", place, **half) for half in halves)
        ends = quad[0], quad[2]
    corners = np.array([[shape.v0, shape.v1, shape.v2] for shape in shapes]) if what == "mesh" else None
    geometry = stage.scene(*shapes) if corners is None else stage.mesh(corners)
    rng = np.random.default_rng(23)
    along, beside = rng.uniform(0.1, 0.9, (SEAM_RAYS, 1)), rng.uniform(-1, 1, (SEAM_RAYS, 1))
    beside *= max(BAND, 100 * ULP * sizes)
    aim = ends[0] + along * (ends[1] - ends[0]) + beside * np.cross(axes[2], ends[1] - ends[0])
    o = np.float32(scale * (aim + 3 * axes[2] + rng.normal(size=aim.shape)) + middle)
    d = probe.unit(scale * aim + middle - o)
    return shapes if corners is None else corners, geometry, (o, d), *stage.seen(geometry, o, d), axes[2]


def every_seam():
    """Return the arguments of `neighbours`."""
    kinds = "triangles", "tiles", "mesh"
    return [(kind, frame, place) for kind in kinds for frame in FRAMES for place in stage.PLACES]


def at_seams(rays):
    """Return which rays that leave one of two neighbours meet the other."""
    wrong = []
    for seam in every_seam():
        _, geometry, _, hit, surface, n = neighbours(*seam)
        out = stage.hemisphere(np.tile(n, (SEAM_RAYS, 1)), np.random.default_rng(8))
        wrong.append(stage.meets(geometry, rays(hit, surface, out))[0] & hit.valid.numpy())
    return np.concatenate(wrong)


def at_seams_mitsuba():
    """Return the same of Mitsuba."""
    wrong = []
    for seam in every_seam():
        shapes, _, (o, d), _, _, n = neighbours(*seam)
        scene, found = stage.theirs(shapes, o, d)
        out = stage.vector(stage.mitsuba(), stage.hemisphere(np.tile(n, (SEAM_RAYS, 1)), np.random.default_rng(8)))
        wrong.append(scene.ray_test(found.spawn_ray(out)).numpy() & found.is_valid().numpy())
    return np.concatenate(wrong)


CASES = (
    Case("a sheet's or triangle's neighbour is not met at their seam", "share", 0,
         "closer to its plane than the bound of both roundings, a sheet is not met",
         lambda: at_seams(stage.ours), lambda: at_seams(stage.by_epsilon), "start 1e-4 along the way",
         at_seams_mitsuba),
)
