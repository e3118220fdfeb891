"""Cylinders.

Thin ones, flat ones, oblique axes, rays along the axis, and the rims where side and caps meet. A cylinder here is a
tube cut by a slab, so side and cap are two ends of one interval and no ray finds a gap between them; Mitsuba's has no
caps, and two disks close it. Errors are distances of found points from the cylinder, in roundoffs of the largest
coordinate or of the way to it: where rays graze, the distance along the ray says little.
"""

import numpy as np

from renderer.core.vectors import frame
from renderer.core.vectors import unit as unit_of
from renderer.scene import schema
from tests.stability import probe
from tests.stability.case import ULP, Case
from tests.stability.probe import EXACT, Found, dot, ours, theirs

COUNT = 20_000
MIDDLE, OBLIQUE, UPRIGHT = (0.1, 0.2, -0.1), (1, 2, -1), (0, 1, 0)
ONE = np.float32(1)


def cylinder(axis, radius, half):
    """Return a cylinder around MIDDLE with float32 numbers."""
    return schema.Cylinder(center=probe.singles(MIDDLE), axis=probe.singles(axis), radius=probe.single(radius),
                           height=probe.single(half))  # fmt: skip


THIN, FLAT = cylinder(OBLIQUE, 1e-4, 1.0), cylinder(OBLIQUE, 1.0, 1e-4)
PLAIN, TUBE, SPECK = cylinder(OBLIQUE, 0.4, 0.6), cylinder(UPRIGHT, 0.5, 1.0), cylinder(OBLIQUE, 1e-4, 1e-4)


def directions(shape):
    """Return unit axis and two normals of it, exact but for double precision."""
    axis = unit_of(shape.axis)
    return [np.array(vector) for vector in (axis, *frame(axis))]


def around(shape, way, seed):
    """Return rays from `way` away towards points in the cylinder's solid."""
    rng = np.random.default_rng(seed)
    axis, t, b = directions(shape)
    phi, rho = rng.uniform(0, 2 * np.pi, (COUNT, 1)), np.sqrt(rng.uniform(0, 0.9, (COUNT, 1)))
    target = (shape.center + 0.9 * shape.height * rng.uniform(-1, 1, (COUNT, 1)) * axis
              + shape.radius * rho * (np.cos(phi) * t + np.sin(phi) * b))
    o = (np.array(shape.center) + way * probe.unit(rng.normal(size=(COUNT, 3)))).astype(np.float32)
    return o, probe.unit(target - o)


def along(shape, way, tilt, seed, widest=1.5):
    """Return rays from `way` away down the axis, starting up to `widest` radii beside it, tilted by up to `tilt`."""
    rng = np.random.default_rng(seed)
    axis, t, b = directions(shape)
    phi, rho = rng.uniform(0, 2 * np.pi, (COUNT, 1)), shape.radius * rng.uniform(0, widest, (COUNT, 1))
    o = (shape.center + way * axis + rho * (np.cos(phi) * t + np.sin(phi) * b)).astype(np.float32)
    return o, probe.unit(-axis + tilt * (rng.uniform(-1, 1, (COUNT, 1)) * t + rng.uniform(-1, 1, (COUNT, 1)) * b))


def to_rim(shape, seed):
    """Return rays from within the cylinder to points of its rims."""
    rng = np.random.default_rng(seed)
    axis, t, b = directions(shape)
    phi = rng.uniform(0, 2 * np.pi, (COUNT, 1))
    rim = (shape.center + rng.choice([-1, 1], (COUNT, 1)) * shape.height * axis
           + shape.radius * (np.cos(phi) * t + np.sin(phi) * b))
    o = (shape.center + 0.3 * min(shape.radius, shape.height) * rng.uniform(-1, 1, (COUNT, 3))).astype(np.float32)
    return o, probe.unit(rim - o)


def off(shape, p):
    """Return the distances of points from the cylinder's surface."""
    axis = np.array(shape.axis, EXACT)
    axis, q = axis / np.sqrt(dot(axis, axis)), np.asarray(p, EXACT) - shape.center
    height = dot(q, axis)
    across = q - height[:, None] * axis
    beyond, outside = np.abs(height) - shape.height, np.sqrt(dot(across, across)) - shape.radius
    apart = np.hypot(np.maximum(beyond, 0), np.maximum(outside, 0))
    return np.abs(apart + np.minimum(np.maximum(beyond, outside), 0))


def met(shape, o, d, way):
    """Return a measure: how far o + t d is from the surface, in roundoffs of `way`."""
    return lambda find: off(shape, probe.at(o, d, find(shape, o, d).t)) / (way * ULP)


def settled(*inputs):
    """Return a measure: how far the found points are from the surface, in roundoffs of the largest coordinate."""
    def errors(find):
        return np.concatenate([
            off(shape, find(shape, o, d).p) / ((np.abs(shape.center).max() + max(shape.radius, shape.height)) * ULP)
            for shape, o, d in inputs
        ])  # fmt: skip
    return errors


def decided(shape, *inputs):
    """Return a measure: which rays along the axis are wrongly said to hit or miss, well inside or outside the tube."""
    def errors(find):
        wrong = []
        for o, d in inputs:
            f = np.asarray(o, EXACT) - shape.center
            axis = directions(shape)[0]
            across = f - dot(f, axis)[:, None] * axis
            passing = np.sqrt(dot(across, across)) / shape.radius
            clear = np.abs(passing - 1) > 0.01
            wrong.append(find(shape, o, d).hit[clear] != (passing < 1)[clear])
        return np.concatenate(wrong)
    return errors


def along_and_across(shape, o, d):
    """Return radius and height, and what rays are along the axis and across it: of each, the origin's part and the
    direction's; in float32.
    """
    axis, f = np.array(unit_of(shape.axis), np.float32), o - np.array(shape.center, np.float32)
    along = f @ axis, d @ axis
    across = (f - along[0][:, None] * axis, d - along[1][:, None] * axis)
    return np.float32(shape.radius), np.float32(shape.height), along, across


def naive(shape, o, d):
    """Return what textbooks find in float32: the side's quadratic equation, two caps, the nearest that is in range."""
    r, h, (fa, da), (across, speed) = along_and_across(shape, o, d)
    a, b = (speed * speed).sum(-1), 2 * (across * speed).sum(-1)
    c = (across * across).sum(-1) - r * r
    with np.errstate(all="ignore"):
        root = np.sqrt(b * b - 4 * a * c)
        sides = [(-b - root) / (2 * a), (-b + root) / (2 * a)]
        caps = [(-h - fa) / da, (h - fa) / da]
        valid = [np.abs(fa + t * da) <= h for t in sides]
        valid += [((across + t[:, None] * speed) ** 2).sum(-1) <= r * r for t in caps]
        t = np.min([np.where(good & (t > 0), t, np.inf) for good, t in zip(valid, sides + caps)], axis=0)
        return Found(t.astype(float), probe.at(o, d, t).astype(np.float32).astype(float), None)


def naive_interval(shape, o, d):
    """Return the part of a line in tube and slab, in float32, without care for 0 / 0."""
    r, h, (fa, da), (across, speed) = along_and_across(shape, o, d)
    with np.errstate(all="ignore"):
        a, b, c = (speed * speed).sum(-1), (across * speed).sum(-1), (across * across).sum(-1) - r * r
        root, reach = np.sqrt(b * b - a * c), np.abs(h / da)
        near = np.maximum((-b - root) / a, -fa / da - reach)
        far = np.minimum((-b + root) / a, -fa / da + reach)
        t = np.where((near <= far) & (far > 0), np.where(near > 0, near, far), np.inf)
        return Found(t.astype(float), None, None)


def missed(*inputs):
    """Return a measure: which rays from within find no way out."""
    return lambda find: np.concatenate([~find(shape, o, d).hit for shape, o, d in inputs])


def nearly_parallel():
    """Return rays along the axis of TUBE whose tilt is 0, of either sign, or from 1e-38 to 1e-6."""
    rays = [along(TUBE, 3.0, tilt, 11) for tilt in (0, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15, 1e-16, 1e-19, 1e-30, 1e-38)]
    o, d = rays[0]
    return [*rays, (o, np.where(d == 0, np.float32(-0.0), d))]


def three(measure, naive=naive, theirs=theirs):
    """Return the arguments of a Case that measures all sides in one way."""
    return {"ours": lambda: measure(ours), "naive": lambda: measure(naive),
            "mitsuba": theirs and (lambda: measure(theirs))}  # fmt: skip


NEAREST = "the side's quadratic equation and two caps, of all distances within their ranges the least"
AXES = "a rounding of f, three of each product with an axis, one of the axes, and two of quotient and square"
CASES = (
    Case("cylinder of radius 0.4: distance", "roundoffs of the way", 8.0, AXES, naive_name=NEAREST,
         **three(met(PLAIN, *around(PLAIN, 3.0, 1), 3.3))),
    Case("thin cylinder, 1e-4 of its length: distance", "roundoffs of the way", 8.0, AXES, naive_name=NEAREST,
         remark="it misses half", **three(met(THIN, *around(THIN, 3.0, 2), 3.3))),
    Case("cylinders, thin, flat and tiny: points on them", "roundoffs of the largest coordinate", 5.0,
         "three roundings of the way along the axis, one of the axis, and one of each coordinate", naive_name=NEAREST,
         **three(settled(*((one, *around(one, way, 4)) for one, way in
                           ((PLAIN, 3.0), (THIN, 3.0), (FLAT, 3.0), (SPECK, 0.1)))))),
    Case("cylinder: rays along the axis, tilted by 0 to 1e-6", "share", 0.0, "0 / 0 is decided by the distance from it",
         naive_name="tube and slab without care for 0 / 0", **three(decided(TUBE, *nearly_parallel()), naive_interval)),
    Case("cylinders: rays from within that aim at a rim", "share", 0.0, "an interval has two ends",
         naive_name=NEAREST, remark="side and caps are three shapes",
         **three(missed(*((one, *to_rim(one, 5)) for one in (PLAIN, THIN, FLAT, TUBE))))),
)
