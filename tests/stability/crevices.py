"""Light in a crevice.

Between two walls at an angle 2a, one long and open above, a point of a wall sees the sky over the other's rim: of the
sky's irradiance the share (1 - (q - p).w / |q - p|) / 2, for its own wall's direction w and the rim q. The mean of that
over the wall is sin a exactly. Rays that start off their surface by a fixed length start outside of the narrowest part,
or behind the other wall, and find too much light there; in a scene ten times as small it is ten times as much. This is
why the mean of Mitsuba's pictures of meshes is some 1e-4 off ours. The walls are a mesh, of size 1, 1000 and 1/1000;
2^18 points spread evenly over one look in directions of a cosine's density, each of which meets the other wall or does
not. The mean is held to that of these answers, so that it has no noise.
"""

from functools import lru_cache

import numpy as np

from tests.stability import probe, stage
from tests.stability.case import Case

RAYS = 2**18
ENDS = 0.5 * 1.3 ** np.arange(30.0)  # where walls are divided, in sizes: what is seen past them is 1e-6 of the sky
HALF_ANGLES = np.radians([10, 40])
SCALES = 1.0, 1e3, 1e-3
TURN = stage.TURN


@lru_cache(maxsize=1)
def numbers():
    """Return (RAYS, 3) evenly spread numbers in [0, 1): multiples of powers of the root of x^4 = x + 1."""
    root = 1.2207440846057596
    return (0.5 + np.arange(1, RAYS + 1)[:, None] * root ** -np.arange(1.0, 4.0)) % 1


@lru_cache(maxsize=16)
def crevice(half, scale):
    """Return the walls' corners, their Geometry, rays at points of a wall, hits and surfaces, and directions."""
    along, up, across = TURN
    walls = [np.cos(half) * up + side * np.sin(half) * across for side in (1, -1)]
    ends = np.concatenate([-ENDS[::-1], ENDS])[:, None] * along
    quads = [[a, a + w, b + w, b] for w in walls for a, b in zip(ends, ends[1:])]
    corners = scale * np.array([np.array(quad)[order] for quad in quads for order in ([0, 1, 2], [0, 2, 3])])
    n = np.cross(walls[0], along)
    n *= np.sign(n @ walls[1])
    u = numbers()
    at = u[:, :1] * walls[0]
    # from within the crevice, so that no wall is in the way
    o = np.float32(scale * (at + 0.2 * np.sin(half) * u[:, :1] * n))
    d = probe.unit(scale * at - o)
    geometry = stage.mesh(corners)
    radius, angle = np.sqrt(u[:, 1:2]), 2 * np.pi * u[:, 2:]
    out = radius * (np.cos(angle) * along + np.sin(angle) * walls[0]) + np.sqrt(1 - u[:, 1:2]) * n
    return corners, geometry, (o, d), *stage.seen(geometry, o, d), probe.unit(out)


def sky(half, scale):
    """Return from which points and in which directions the sky is seen, in double precision; walls without ends."""
    *_, surface, out = crevice(half, scale)
    _, up, across = TURN
    p, d = probe.doubles(surface.p).T / scale, out.astype(float)
    other = np.cos(half) * up - np.sin(half) * across
    normal = np.cos(half) * across + np.sin(half) * up  # of the other wall, towards this one
    with np.errstate(divide="ignore"):
        t = -(p @ normal) / (d @ normal)
    return (t <= 0) | ((p + t[:, None] * d) @ other > 1)


def settings():
    """Return the arguments of `crevice`."""
    return [(half, scale) for half in HALF_ANGLES for scale in SCALES]


def errors(rays):
    """Return relative errors of the sky's mean share."""
    found = []
    for half, scale in settings():
        _, geometry, _, hit, surface, out = crevice(half, scale)
        dark = stage.meets(geometry, rays(hit, surface, out))[0]
        found.append(((~dark).mean() - sky(half, scale).mean()) / np.sin(half))
    return np.array(found)


def errors_mitsuba():
    """Return the same of Mitsuba."""
    found, mi = [], stage.mitsuba()
    for half, scale in settings():
        corners, _, (o, d), _, _, out = crevice(half, scale)
        scene, met = stage.theirs(corners, o, d)
        dark = scene.ray_test(met.spawn_ray(stage.vector(mi, out))).numpy()
        found.append(((~dark).mean() - sky(half, scale).mean()) / np.sin(half))
    return np.array(found)


CASES = (
    Case("sky seen from a crevice of a mesh, at three scales", "relative", 5e-5,
         "two of 2^18 rays at the narrowest, where one is expected within 30 roundoffs of the bottom or the rim",
         lambda: errors(stage.ours), lambda: errors(stage.by_epsilon), "start 1e-4 along the way", errors_mitsuba),
)
