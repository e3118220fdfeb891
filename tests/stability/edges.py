"""Edges and corners that triangles share.

Fans of twelve triangles around a corner, folded up and down, seen along rays at that corner and at points of the edges
that meet there: half of them along an axis, so that they meet corner or edge exactly, the others as nearly as float32
can aim. Integers of any length decide exactly, from the float32 numbers, that a ray meets one of the twelve. Who then
finds none has left a gap. Limit: `triangle` shapes overlap by 16 roundoffs of their own size, so that from 100 sizes
away a ray aimed at an edge may pass between two with different first corners; triangles of meshes leave no gap.
"""

from fractions import Fraction
from functools import lru_cache

import numpy as np

from tests.stability import probe, stage
from tests.stability.case import Case

FANS, BLADES, RAYS = 25, 12, 600  # rays are those of each fan
LOOSE = 4  # fans of `triangle` shapes, which are compiled in
BITS = 12  # coordinates are multiples of 2^-12
APART = 8.0


@lru_cache(maxsize=1)
def fans():
    """Return the middles (F, 3) and rims (F, 12, 3) of fans, and float32 rays (F, RAYS, 3) each, in float64."""
    rng = np.random.default_rng(47)
    place = APART * np.stack([np.arange(FANS) % 8, np.arange(FANS) // 8, np.zeros(FANS)], 1)
    angle = 2 * np.pi * (np.arange(BLADES) + 0.35 * rng.uniform(-1, 1, (FANS, BLADES))) / BLADES
    radius = rng.uniform(0.4, 1.2, (FANS, BLADES))
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), rng.uniform(-0.25, 0.25, (FANS, BLADES))], -1)
    middle, rim = (np.round(v * 2**BITS) / 2**BITS for v in (place, rim + place[:, None]))

    fan, blade = np.arange(FANS)[:, None], rng.integers(BLADES, size=(FANS, RAYS))
    share = rng.choice([0, 0.25, 0.5, 0.75], (FANS, RAYS, 1))
    target = middle[:, None] * (1 - share) + rim[fan, blade] * share
    along_axis = rng.random((FANS, RAYS, 1)) < 0.5
    from_ = rng.normal(size=target.shape) * [0.3, 0.3, 0] + [0, 0, 3]
    from_ = np.where(along_axis, [0, 0, 3], np.round(from_ * 2**BITS) / 2**BITS)
    o = np.float32(target + from_)
    d = probe.unit((target - o).reshape(-1, 3)).reshape(o.shape)
    assert (o == target + from_).all()
    return middle, rim, o.astype(float), d.astype(float)


def corners(count):
    """Return the triangles of the first fans, (count * 12, 3, 3)."""
    middle, rim, _, _ = fans()
    middle = np.repeat(middle[:count, None], BLADES, 1)
    return np.stack([middle, rim[:count], np.roll(rim[:count], -1, 1)], 2).reshape(-1, 3, 3)


def _integers(values, bits):
    """Return float32 numbers times 2^bits as Python's integers, exactly."""
    scaled = [Fraction(value) * 2**bits for value in values.ravel().tolist()]
    assert all(value.denominator == 1 for value in scaled)
    return np.array([value.numerator for value in scaled], object).reshape(values.shape)


@lru_cache(maxsize=1)
def truly_met():
    """Return which rays (F, RAYS) meet a triangle of their fan, edges and corners included, by exact arithmetic."""
    return exactly_met(*fans())


def exactly_met(middle, rim, o, d):
    """Return the same of any fans and rays, (F, 3), (F, 12, 3) and (F, RAYS, 3) each, multiples of 2^-40."""
    d = _integers(d, 80)
    axis = [d[..., k, None] for k in range(3)]

    def volume(a, b):
        return (axis[0] * (a[1] * b[2] - a[2] * b[1]) + axis[1] * (a[2] * b[0] - a[0] * b[2])
                + axis[2] * (a[0] * b[1] - a[1] * b[0]))  # fmt: skip

    to_rim = _integers(rim[:, None] - o[:, :, None], 40)
    to_middle = _integers(middle[:, None, None] - o[:, :, None], 40)
    a, c = [to_rim[..., k] for k in range(3)], [to_middle[..., k] for k in range(3)]
    b = [np.roll(part, -1, -1) for part in a]
    spokes = volume(c, a)
    sides = np.stack([spokes, volume(a, b), -np.roll(spokes, -1, -1)], -1)
    return ((sides >= 0).all(-1) | (sides <= 0).all(-1)).any(-1)


def gaps(found):
    """Return which of the rays that truly meet a fan, (F, RAYS), are found to meet none."""
    return ~found[truly_met()[: len(found)]]


def rays(count):
    """Return the rays of the first fans, (count * RAYS, 3)."""
    return tuple(part[:count].reshape(-1, 3) for part in fans()[2:])


def of_mesh():
    """Return the gaps of a mesh in a hierarchy."""
    found = stage.seen(stage.mesh(corners(FANS)), *rays(FANS))[0].valid.numpy()
    return gaps(found.reshape(FANS, RAYS))


def of_shapes():
    """Return the gaps of `triangle` shapes, a scene for each fan."""
    found = []
    triangles = corners(LOOSE).reshape(LOOSE, BLADES, 3, 3)
    o, d = (part.reshape(LOOSE, RAYS, 3) for part in rays(LOOSE))
    for k in range(LOOSE):
        blades = [dict(zip(("v0", "v1", "v2"), blade)) for blade in triangles[k]]
        scene = stage.scene(*(stage.placed("triangle", "plain", **blade) for blade in blades))
        found.append(stage.seen(scene, o[k], d[k])[0].valid.numpy())
    return gaps(np.array(found))


def of_textbook(count):
    """Return the gaps of Moeller and Trumbore's test, in single precision."""
    triangles = np.float32(corners(count).reshape(count, 1, BLADES, 3, 3))
    o, d = (np.float32(part.reshape(count, RAYS, 1, 3)) for part in rays(count))
    v0, v1, v2 = (triangles[..., k, :] for k in range(3))
    e1, e2, to = v1 - v0, v2 - v0, o - v0
    p, q = np.cross(d, e2), np.cross(to, e1)
    with np.errstate(all="ignore"):
        inverse = 1 / (e1 * p).sum(-1)
        u, v = (to * p).sum(-1) * inverse, (d * q).sum(-1) * inverse
        met = (u >= 0) & (v >= 0) & (u + v <= 1)
    return gaps(met.any(-1))


def of_mitsuba(count):
    """Return the gaps of Mitsuba's mesh."""
    _, found = stage.theirs(corners(count), *rays(count))
    return gaps(found.is_valid().numpy().reshape(count, RAYS))


CASES = (
    Case("corners and edges of a mesh, met exactly", "share", 0,
         "corners are projected alike for all triangles, and signs of edge functions are exact",
         of_mesh, lambda: of_textbook(FANS), "Moeller and Trumbore", lambda: of_mitsuba(FANS)),
    Case("corners and edges of triangle shapes, met exactly", "share", 0,
         "neighbours overlap by 16 roundoffs",
         of_shapes, lambda: of_textbook(LOOSE), "Moeller and Trumbore", lambda: of_mitsuba(LOOSE)),
)
