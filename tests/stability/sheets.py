"""Planes, disks and rectangles.

At grazing angles the distance to a plane is n.(c - o) over a product that nearly vanishes, and rounding of the normal
alone moves it far; so errors are those of the found point, from the plane. Far from the origin n.c - n.o cancels.
Neighbouring rectangles are to let no ray through where their edges meet.
"""

import numpy as np

from renderer.scene import schema
from tests.stability import probe
from tests.stability.case import ULP, Case
from tests.stability.probe import EXACT, Found, dot, ours, theirs

COUNT = 20_000
TILTS = (1.0, 1e-2, 1e-4, 1e-5)  # heights above the plane, over the width of the region where rays come from
OBLIQUE = (0.2, 3, -0.4)
MIDDLE, OUTSIDE = (0.1, -0.3, 0.2), (1e3, 1e6, 3e5)


def plane(point):
    """Return an oblique plane with float32 numbers."""
    return schema.Plane(point=probe.singles(point), normal=probe.singles(OBLIQUE))


def disk(center, radius):
    """Return an oblique disk with float32 numbers."""
    return schema.Disk(center=probe.singles(center), normal=probe.singles(OBLIQUE), radius=probe.single(radius))


def rectangle(center, size):
    """Return an oblique rectangle of this length and two thirds of it, with float32 numbers."""
    return schema.Rectangle(center=probe.singles(center), u=probe.singles(size * np.array([1.2, 0.3, -0.4])),
                            v=probe.singles(size * np.array([0.3, -0.8, 0.3])))  # fmt: skip


def spanned(shape):
    """Return the middle, the exact unit normal, and two edges of a sheet."""
    if shape.type == "rectangle":
        u, v = np.array(shape.u, EXACT), np.array(shape.v, EXACT)
        n = np.cross(u, v)
        return np.array(shape.center), n / np.sqrt(n @ n), u, v
    n = np.array(shape.normal, EXACT)
    n = n / np.sqrt(n @ n)
    u = np.cross(n, [0.3, 0.5, 0.8])
    u = u / np.sqrt(u @ u)
    return np.array(shape.point if shape.type == "plane" else shape.center), n, u, np.cross(n, u)


def grazing(shape, size, seed):
    """Return rays from heights of TILTS over a region of a sheet to others well inside of it, `size` in half."""
    rng = np.random.default_rng(seed)
    c, n, u, v = spanned(shape)
    u, v = (u / 2, v / 2) if shape.type == "rectangle" else (size * u, size * v)
    starts, ends = (x * u + y * v for x, y in rng.uniform(-1, 1, (2, 2, COUNT, 1)))
    o = (c + starts + rng.choice(TILTS, (COUNT, 1)) * size * n).astype(np.float32)
    d = probe.unit(c + 0.6 * ends - o)
    t = distance(shape, o, d)  # rounding of the origin may have put it below, or the point elsewhere
    p = probe.at(o, d, t) - c
    above = dot(o - c.astype(EXACT), n) > min(TILTS) / 2 * size
    meets = above & (t > 0) & (np.abs(dot(p, u)) < 0.9 * dot(u, u)) & (np.abs(dot(p, v)) < 0.9 * dot(v, v))
    return o[meets], d[meets]


def distance(shape, o, d):
    """Return the exact distance to the sheet's plane, NaN along it."""
    c, n, *_ = spanned(shape)
    falls = dot(d, n)
    return dot(c - o.astype(EXACT), n) / np.where(falls == 0, np.nan, falls)


def met(*inputs):
    """Return a measure: distances of o + t d from the plane, in roundoffs of the ways from middle and origin."""
    def errors(find):
        found = []
        for shape, o, d in inputs:
            c, n, *_ = spanned(shape)
            t = find(shape, o, d).t
            way = np.sqrt(dot(c - o.astype(EXACT), c - o.astype(EXACT))) + t
            found.append(np.abs(dot(probe.at(o, d, t) - c, n)) / (way * ULP))
        return np.concatenate(found)
    return errors


def settled(*inputs):
    """Return a measure: how far the found points are from the plane, in roundoffs of the largest coordinate."""
    def errors(find):
        found = []
        for shape, o, d in inputs:
            c, n, *_ = spanned(shape)
            p = find(shape, o, d).p
            found.append(np.abs(dot(p - c.astype(EXACT), n)) / (np.maximum(np.abs(p).max(-1), np.abs(c).max()) * ULP))
        return np.concatenate(found)
    return errors


def textbook(shape, o, d):
    """Return what textbooks find in float32: (k - n.o) / n.d with k = n.c, then whether the point is inside."""
    c, n, u, v = (np.asarray(part, np.float64).astype(np.float32) for part in spanned(shape))
    with np.errstate(all="ignore"):
        t = (n @ c - o @ n) / (d @ n)
    p = o + t[:, None] * d
    q = p - c
    if shape.type == "disk":
        inside = np.sqrt((q * q).sum(-1)) <= np.float32(shape.radius)
    elif shape.type == "rectangle":
        inside = (np.abs(q @ u) <= u @ u / 2) & (np.abs(q @ v) <= v @ v / 2)
    else:
        inside = np.full(len(o), True)
    t = np.where(inside & (t > 0), t, np.inf)
    return Found(t.astype(float), np.where(np.isfinite(t)[:, None], p, np.nan).astype(float), None)


def at_rim(shape, way, seed):
    """Return rays from `way` radii towards a disk's rim, within 1e-9 to 1e-3 of the radius beside it."""
    rng = np.random.default_rng(seed)
    c, n, u, v = spanned(shape)
    phi, beside = rng.uniform(0, 2 * np.pi, (COUNT, 1)), 10 ** rng.uniform(-9, -3, (COUNT, 1))
    rim = (np.cos(phi) * u + np.sin(phi) * v) * shape.radius * (1 + beside * rng.choice([-1, 1], (COUNT, 1)))
    from_here = probe.unit(rng.normal(size=(COUNT, 3)))
    from_here = np.where(np.abs(dot(from_here, n))[:, None] > 0.2, from_here, np.asarray(n, np.float32))
    o = (c + rim + way * shape.radius * from_here).astype(np.float32)
    return o, probe.unit(c + rim - o)


def decided(*inputs):
    """Return a measure: how far beside the rim rays pass that are wrongly said to hit or miss, in roundoffs."""
    def errors(find):
        found = []
        for shape, o, d in inputs:
            c, n, *_ = spanned(shape)
            q = probe.at(o, d, distance(shape, o, d)) - c
            apart, way = np.sqrt(dot(q, q)) - shape.radius, np.sqrt(dot(c - o.astype(EXACT), c - o.astype(EXACT)))
            wrong = find(shape, o, d).hit != (apart <= 0)
            found.append(np.where(wrong, np.abs(apart) * np.abs(dot(d, n)) / ((way + shape.radius) * ULP), 0))
        return np.concatenate(found)
    return errors


def neighbours():
    """Return two oblique rectangles of float32 numbers that share an edge exactly, and that edge's ends."""
    u, v = np.array([1.25, 0.3125, -0.4375]), np.array([0.3125, -0.8125, 0.34375])  # sums and halves are float32 too
    low, high = np.array([0.125, -0.25, 0.1875]) - u / 2, np.array([0.125, -0.25, 0.1875]) + u / 2
    first, second = (schema.Rectangle(center=tuple(middle), u=tuple(u), v=tuple(v)) for middle in (low, high))
    return (first, second), (low + u / 2 - v / 2, low + u / 2 + v / 2)


def at_edge():
    """Return rays to points of the edge, from all sides."""
    rng = np.random.default_rng(47)
    _, (start, end) = neighbours()
    target = start + rng.uniform(0.001, 0.999, (COUNT, 1)) * (end - start)
    o = (target + rng.uniform(0.5, 5, (COUNT, 1)) * probe.unit(rng.normal(size=(COUNT, 3)))).astype(np.float32)
    d = probe.unit(target - o)
    steep = np.abs(dot(d, spanned(neighbours()[0][0])[1])) > 0.05
    return o[steep], d[steep]


def slipped(find):
    """Return which rays pass between two rectangles."""
    return ~find(neighbours()[0], *at_edge()).hit


def textbook_of_both(shapes, o, d):
    """Return the nearer of what the textbook finds of two rectangles, by coordinates from dual edges."""
    found = []
    for shape in shapes:
        c, n, u, v = (np.asarray(part, np.float64) for part in spanned(shape))
        normal = np.cross(u, v)
        duals = [np.float32(part / (normal @ normal)) for part in (np.cross(v, normal), np.cross(normal, u))]
        n, c = np.float32(n), np.float32(c)
        t = ((c - o) @ n) / (d @ n)
        q = o + t[:, None] * d - c
        inside = np.all([np.abs(q @ dual) <= np.float32(0.5) for dual in duals], axis=0)
        found.append(np.where(inside & (t > 0), t, np.inf))
    return Found(np.min(found, axis=0), None, None)


def three(measure, naive=textbook):
    """Return the arguments of a Case that measures all sides in one way."""
    return {"ours": lambda: measure(ours), "naive": lambda: measure(naive), "mitsuba": lambda: measure(theirs)}


PLANES = tuple((plane(point), *grazing(plane(point), 1.0, 41)) for point in (MIDDLE, OUTSIDE))
DISKS = tuple((disk(*which), *grazing(disk(*which), which[1] / 2, 42))
              for which in ((MIDDLE, 0.8), (MIDDLE, 1e-4), (MIDDLE, 1e6), (OUTSIDE, 1e3)))
RECTANGLES = tuple((rectangle(*which), *grazing(rectangle(*which), which[1], 43))
                   for which in ((MIDDLE, 1.0), (MIDDLE, 1e-4), (MIDDLE, 1e6), (OUTSIDE, 1e3)))
RIMS = tuple((disk(*which), *at_rim(disk(*which), way, 44))
             for which, way in (((MIDDLE, 0.8), 3), ((MIDDLE, 1e-4), 1e4), ((OUTSIDE, 1e3), 1)))
WAYS, LARGEST = "roundoffs of the ways from middle and origin", "roundoffs of the largest coordinate"
QUOTIENT = "three roundings each of two products, one each of c - o, normal and quotient"
PROJECTED = "one rounding of each coordinate, and one of the normal"
OFFSET = "(n.c - n.o) / n.d, and o + t d"
TRANSFORMED = "it moves rays into the shape's own coordinates, whose matrix is rounded"
CASES = (
    Case("planes seen at down to 1e-5 radians, one 1e6 from the origin: distance", WAYS, 6.0, QUOTIENT,
         naive_name=OFFSET, remark=TRANSFORMED, **three(met(*PLANES))),
    Case("planes: points on them", LARGEST, 3.0, PROJECTED, naive_name=OFFSET, **three(settled(*PLANES))),
    Case("disks of 1e-4 to 1e6 at grazing angles: distance", WAYS, 6.0, QUOTIENT,
         naive_name=OFFSET, remark=TRANSFORMED, **three(met(*DISKS))),
    Case("disks: points on them", LARGEST, 3.0, PROJECTED, naive_name=OFFSET, **three(settled(*DISKS))),
    Case("disks: hit or miss at the rim", WAYS, 6.0, QUOTIENT, naive_name=OFFSET, **three(decided(*RIMS))),
    Case("rectangles of 1e-4 to 1e6 at grazing angles: distance", WAYS, 6.0, QUOTIENT,
         naive_name=OFFSET, remark=TRANSFORMED, **three(met(*RECTANGLES))),
    Case("rectangles: points on them", LARGEST, 3.0, PROJECTED, naive_name=OFFSET, **three(settled(*RECTANGLES))),
    Case("rectangles side by side: rays at the edge that they share", "share", 0.0,
         "they overlap by 16 roundoffs of their size", naive_name="the same coordinates without an overlap",
         **three(slipped, textbook_of_both)),
)
