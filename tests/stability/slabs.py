"""Boxes and other convex volumes.

Rays along the axes meet 0 / 0 and 0 * infinity, also with components of -0 and of numbers whose reciprocals overflow;
origins lie exactly on faces, and rays within the plane of one. There both answers are right, but between neighbours
that share the face nothing may slip through. Long boxes and flat wedges lose their ends if they are kept as a middle
and half a length, or tested with a tolerance.
"""

import numpy as np
from scipy.spatial import ConvexHull

from renderer.scene import schema
from tests.stability import probe
from tests.stability.case import ULP, Case
from tests.stability.probe import EXACT, Found, dot, ours, theirs

COUNT = 20_000
ZEROS = (0.0, -0.0, 1e-45, -1e-45, 1e-38, -1e-38, 1e-30, -1e-30, 1e-20, -1e-20)  # components across the ray
WEDGE = 1e-4  # radians between two faces


def box(low, high):
    """Return a box with float32 corners."""
    return schema.Box(min=probe.singles(low), max=probe.singles(high))


PLAIN = box((-0.5, -0.4, -0.3), (0.6, 0.7, 0.2))
LONG = box((1e-3, -1, -1), (1e6, 1, 1))
SHEET = box((-1, 0.1, -1), (1, 0.10001, 1))
FAR = box((1e6, 1e6, 1e6), (1e6 + 1, 1e6 + 1, 1e6 + 1))
SPECK = box((-1e-4, -1e-4, -1e-4), (1e-4, 2e-4, 1e-4))


def around(shape, way, seed):
    """Return rays from `way` times its size away towards points in a box."""
    rng = np.random.default_rng(seed)
    low, high = np.array(shape.min), np.array(shape.max)
    o = (low + high) / 2 + way * (high - low).max() / 2 * probe.unit(rng.normal(size=(COUNT, 3)))
    o = o.astype(np.float32)
    return o, probe.unit(low + (high - low) * rng.uniform(0.01, 0.99, (COUNT, 3)) - o)


def at_end(seed):
    """Return rays that meet the near end of the long box head on, from up to its width away."""
    rng = np.random.default_rng(seed)
    o = np.column_stack([-rng.uniform(0.01, 1, COUNT), *rng.uniform(-0.5, 0.5, (2, COUNT))]).astype(np.float32)
    target = np.column_stack([np.full(COUNT, 1e-3), *rng.uniform(-0.9, 0.9, (2, COUNT))])
    return o, probe.unit(target - o)


def parallel(shape, seed, on_face=False):
    """Return rays along an axis whose other components are ZEROS, from before a box; `on_face`: in a face's plane."""
    rng = np.random.default_rng(seed)
    lanes, axis, sign = np.arange(COUNT), rng.integers(0, 3, COUNT), rng.choice([-1, 1], COUNT)
    corners = np.array([shape.min, shape.max], np.float32)
    o = rng.uniform(-1, 1, (COUNT, 3)).astype(np.float32)
    o[lanes, axis] = -3 * sign
    if on_face:
        across = (axis + 1) % 3
        o[lanes, across] = corners[rng.integers(0, 2, COUNT), across]
    d = rng.choice(np.array(ZEROS, np.float32), (COUNT, 3))
    d[lanes, axis] = sign
    return o, d


def exact(shape, o, d):
    """Return where lines enter and leave a box, whose faces belong to it: exact; NaN where they miss."""
    near, far = np.full(len(o), -np.inf, EXACT), np.full(len(o), np.inf, EXACT)
    for axis in range(3):
        start, step = o[:, axis].astype(EXACT), d[:, axis].astype(EXACT)
        low, high = shape.min[axis] - start, shape.max[axis] - start
        moves = np.where(step == 0, 1, step)
        first, second = np.minimum(low / moves, high / moves), np.maximum(low / moves, high / moves)
        within = (low <= 0) & (high >= 0)
        near = np.maximum(near, np.where(step == 0, np.where(within, -np.inf, np.inf), first))
        far = np.minimum(far, np.where(step == 0, np.where(within, np.inf, -np.inf), second))
    misses = (near > far) | (far <= 0)
    return np.where(misses, np.nan, near), np.where(misses, np.nan, far)


def first(shape, o, d):
    """Return the exact distance to the first hit, infinity for none."""
    near, far = exact(shape, o, d)
    return np.where(np.isnan(near), np.inf, np.where(near > 0, near, far))


def off(shape, p):
    """Return the distances of points from a box's surface."""
    low, high = np.array(shape.min, EXACT), np.array(shape.max, EXACT)
    beyond = np.maximum(low - p, p - high)
    apart = np.maximum(beyond, 0)
    return np.abs(np.where((beyond > 0).any(-1), np.sqrt(dot(apart, apart)), beyond.max(-1)))


def textbook(shape, o, d):
    """Return the slab test of textbooks in float32: all six distances by division, the larger and smaller of them."""
    with np.errstate(all="ignore"):
        a, b = (np.float32(shape.min) - o) / d, (np.float32(shape.max) - o) / d
        near, far = np.minimum(a, b).max(-1), np.maximum(a, b).min(-1)
        t = np.where(near > 0, near, far)
        t = np.where((near <= far) & (t > 0), t, np.inf)
    return Found(t.astype(float), probe.at(o, d, t).astype(np.float32).astype(float), None)


def halved(shape, o, d):
    """Return the slab test from a middle and half a length in float32."""
    low, high = np.array(shape.min), np.array(shape.max)
    middle, half = np.float32((low + high) / 2), np.float32((high - low) / 2)
    with np.errstate(all="ignore"):
        rate = 1 / d
        to_middle, reach = (middle - o) * rate, half * np.abs(rate)
        near, far = (to_middle - reach).max(-1), (to_middle + reach).min(-1)
        t = np.where(near > 0, near, far)
        t = np.where((near <= far) & (t > 0), t, np.inf)
    return Found(t.astype(float), probe.at(o, d, t).astype(np.float32).astype(float), None)


def relative_to_way(shape, o, d):
    """Return a measure: errors of t over t."""
    wanted = first(shape, o, d)
    return lambda find: (find(shape, o, d).t - wanted) / wanted


def settled(*inputs):
    """Return a measure: how far points of rays through a box are from its surface, in roundoffs of its coordinates."""
    def errors(find):
        return np.concatenate([
            off(shape, find(shape, o, d).p) / (np.abs([shape.min, shape.max]).max() * ULP) for shape, o, d in inputs
        ])  # fmt: skip
    return errors


def decided(shape, o, d):
    """Return a measure: which rays are wrongly said to hit or miss, or meet something elsewhere than they should."""
    wanted = first(shape, o, d)

    def wrong(find):
        t, hits = find(shape, o, d).t, np.isfinite(wanted)
        there = np.where(hits, wanted, 1)
        return (np.isfinite(t) != hits) | (hits & (np.abs(np.where(hits, t, 1) - there) > 16 * ULP * there))
    return wrong


NEIGHBOURS = (box((-1, -0.5, -0.5), (0.25, 0.5, 0.5)), box((0.25, -0.5, -0.5), (1, 0.5, 0.5)))


def between():
    """Return rays within the plane that two boxes share, along an axis, up to ZEROS across it."""
    rng = np.random.default_rng(31)
    lanes, axis, sign = np.arange(COUNT), rng.integers(1, 3, COUNT), rng.choice([-1, 1], COUNT)
    o = rng.uniform(-0.49, 0.49, (COUNT, 3)).astype(np.float32)
    o[:, 0] = NEIGHBOURS[0].max[0]
    o[lanes, axis] = -3 * sign
    d = rng.choice(np.array(ZEROS, np.float32), (COUNT, 3))
    d[lanes, axis] = sign
    return o, d


def slipped(find):
    """Return which rays pass between the two boxes."""
    return ~find(NEIGHBOURS, *between()).hit


def textbook_of_both(shapes, o, d):
    """Return the nearer of what the textbook finds of two boxes."""
    return Found(np.minimum(*(textbook(shape, o, d).t for shape in shapes)), None, None)


def wedge():
    """Return an oblique volume whose two large faces meet at WEDGE."""
    rng = np.random.default_rng(32)
    x, y, z = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    middle = np.array([0.3, -0.2, 0.1])
    faces = ((y, 0.0), (-y + WEDGE * x, 0.0), (-x, 1.0), (z, 1.0), (-z, 1.0))
    return schema.Convex(halfspaces=tuple(probe.singles([*n, d + n @ middle]) for n, d in faces)), (x, y, z), middle


def along_wedge():
    """Return rays to points within the wedge, from a distance of 2, by 1e-5 to 1 radians off its large faces."""
    rng = np.random.default_rng(33)
    _, (x, y, z), middle = wedge()
    place, turn = rng.uniform(-0.9, -0.3, (COUNT, 1)), rng.uniform(0, 2 * np.pi, (COUNT, 1))
    height = place * WEDGE * rng.uniform(0.1, 0.9, (COUNT, 1))
    target = middle + place * x + height * y + rng.uniform(-0.9, 0.9, (COUNT, 1)) * z
    tilt = 10 ** rng.uniform(-5, 0, (COUNT, 1)) * rng.choice([-1, 1], (COUNT, 1))
    o = (target - 2 * probe.unit(np.cos(turn) * x + np.sin(turn) * z + tilt * y)).astype(np.float32)
    return o, probe.unit(target - o)


def planes(shape):
    """Return unit normals and offsets of half-spaces, exact."""
    rows = np.array(shape.halfspaces, EXACT)
    size = np.sqrt(dot(rows[:, :3], rows[:, :3]))
    return rows[:, :3] / size[:, None], rows[:, 3] / size


def wedge_met(find):
    """Return how far o + t d is from the wedge's faces, in roundoffs of the way and the coordinates."""
    shape, (o, d) = wedge()[0], along_wedge()
    normals, offsets = planes(shape)
    p = probe.at(o, d, find(shape, o, d).t)
    return np.abs((p @ normals.T - offsets).max(-1)) / (3 * ULP)


def tolerant(shape, o, d, tolerance=1e-4):
    """Return the clipping of textbooks in float32, where lines within a tolerance of a face's plane are parallel."""
    near, far = np.full(len(o), -np.inf, np.float32), np.full(len(o), np.inf, np.float32)
    for *n, offset in shape.halfspaces:
        n = np.array(n, np.float32)
        rate, room = d @ n, np.float32(offset) - o @ n
        parallel = np.abs(rate) <= tolerance
        t = room / np.where(parallel, 1, rate)
        far = np.where(parallel, np.where(room < 0, -np.inf, far), np.where(rate > 0, np.minimum(far, t), far))
        near = np.where(~parallel & (rate < 0), np.maximum(near, t), near)
    t = np.where((near <= far) & (far > 0), np.where(near > 0, near, far), np.inf)
    return Found(t.astype(float), None, None)


CORNERS = np.array([(0, 0.75, 0), (0.75, -0.5, 0.5), (-0.75, -0.5, 0.5), (0, -0.5, -0.75), (0, -1, 0)])
PLACES = ((1e3, 250, -500), (1e6, -3e5, 7e5))  # the corners there are float32 too, but for the second's fractions


def gem(place):
    """Return a convex volume of size 1 somewhere, its corners of float32 numbers."""
    return schema.Convex(vertices=tuple(map(probe.singles, CORNERS + place)))


def at_gem(place):
    """Return rays from nearby towards points inside."""
    rng = np.random.default_rng(34)
    corners = np.array(gem(place).vertices)
    target = rng.dirichlet(np.ones(len(corners)), COUNT) @ corners
    o = (corners.mean(0) + 3 * probe.unit(rng.normal(size=(COUNT, 3)))).astype(np.float32)
    return o, probe.unit(target - o)


def hull(place):
    """Return normals and offsets of a gem's facets, relative to its middle, exact but for double precision."""
    corners = np.array(gem(place).vertices)
    middle = corners.mean(0)
    equations = ConvexHull(corners - middle).equations
    return middle, equations[:, :3], -equations[:, 3]


def gem_met(find):
    """Return how far o + t d is from gems' facets, in roundoffs of their size and the way from the ray's origin."""
    found = []
    for place in PLACES:
        o, d = at_gem(place)
        middle, normals, offsets = hull(place)
        p = probe.at(o, d, find(gem(place), o, d).t)
        found.append(np.abs(((p - middle) @ normals.T - offsets).max(-1)) / (4 * ULP))
    return np.concatenate(found)


def from_the_origin(shape, o, d):
    """Return the clipping with n.p <= d in float32."""
    corners = np.array(shape.vertices)
    middle = corners.mean(0)
    equations = ConvexHull(corners - middle).equations
    rows = np.column_stack([equations[:, :3], equations[:, :3] @ middle - equations[:, 3]])
    return tolerant(schema.Convex(halfspaces=tuple(map(tuple, rows.tolist()))), o, d, 0.0)


def three(measure, naive, theirs=theirs):
    """Return the arguments of a Case that measures all sides in one way."""
    return {"ours": lambda: measure(ours), "naive": lambda: measure(naive),
            "mitsuba": theirs and (lambda: measure(theirs))}  # fmt: skip


THREE = "one rounding each of the difference, the reciprocal and the product"
HALVED = "a middle and half a length in each axis, times 1 / d"
CASES = (
    Case("box: distance", "relative", 3.01 * ULP, THREE, naive_name=HALVED,
         **three(relative_to_way(PLAIN, *around(PLAIN, 3, 21)), halved)),
    Case("box of 1e-4: distance", "relative", 3.01 * ULP, THREE, naive_name=HALVED,
         **three(relative_to_way(SPECK, *around(SPECK, 3, 22)), halved)),
    Case("box from 1e-3 to 1e6: distance to its near end", "relative", 3.01 * ULP, THREE, naive_name=HALVED,
         **three(relative_to_way(LONG, *at_end(23)), halved)),
    Case("boxes, flat, tiny, long and far away: points on them", "roundoffs of the largest coordinate", 1.0,
         "one coordinate is a face's, and by the others a point is off only beside an edge", naive_name="o + t d",
         **three(settled(*((one, *around(one, 3, 24)) for one in (PLAIN, SHEET, SPECK, FAR))), textbook)),
    Case("box: rays along an axis, other components 0, -0, or down to 1e-45", "share", 0.0,
         "no infinity meets another", naive_name=HALVED, **three(decided(PLAIN, *parallel(PLAIN, 25)), halved)),
    Case("box: origins in a face's plane, components of 0 and 1e-45 to 1e-20", "share of slipped rays", 0.0,
         "0 / TINY is 0, and the face belongs to one of two neighbours", naive_name="all six distances by division",
         remark="two boxes side by side are to stop rays within the face that they share",
         **three(slipped, textbook_of_both)),
    Case("wedge of 1e-4 radians, oblique: distance", "roundoffs of the way", 8.0,
         "three roundings each of two products, one of offset and normal each", naive_name="rays within 1e-4 of a "
         "plane count as parallel", **three(wedge_met, tolerant)),
    Case("convex volumes of size 1, 1e3 and 1e6 from the origin: distance", "roundoffs of the way", 8.0,
         "three roundings each of two products, one of offset and normal each", naive_name="n.p <= d",
         **three(gem_met, from_the_origin)),
)
