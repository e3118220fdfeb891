"""Leaving a surface.

A point that was hit lies off its surface by rounding, and the ray that leaves it, for the next bounce or for a light,
must not find that surface again. Here a ray carries the convex shape that it left, and on which side, and nothing is
moved; a ray that leaves a mesh starts off its triangle by what rounding can be. So nothing depends on the scale of a
scene. The cases have sizes from 1e-4 to 1e6 and middles up to 1000 sizes from the world's origin, and half of all
directions are within 1e-3 of the surface.
"""

from functools import lru_cache

import numpy as np

from tests.stability import probe, stage
from tests.stability.case import ULP, Case
from tests.support.soups import ball

RAYS = 3000  # for each kind and place
UNIT = {
    "sphere": {"center": [0, 0, 0], "radius": 0.7},
    "cylinder": {"center": [0, 0, 0], "axis": stage.TURN[0], "radius": 0.4, "height": 0.6},
    "box": {"min": [-0.6, -0.5, -0.7], "max": [0.5, 0.8, 0.4]},
    "convex": {"vertices": [[0, 0.8, 0.1], [0.7, -0.4, 0.4], [-0.7, -0.5, 0.4], [0.1, -0.4, -0.8]]},
    "plane": {"point": [0, 0, 0], "normal": stage.TURN[2]},
    "disk": {"center": [0, 0, 0], "normal": stage.TURN[2], "radius": 1},
    "rectangle": {"center": [0, 0, 0], "u": 2 * stage.TURN[0], "v": stage.TURN[1] + 0.3 * stage.TURN[0]},
    "triangle": dict(zip(("v0", "v1", "v2"), ([-1, -0.7], [1.1, -0.5], [-0.1, 1.2]) @ stage.TURN[:2])),
}
SOLIDS = [kind for kind in UNIT if stage.KINDS[kind].solid]
SHEETS = [kind for kind in UNIT if kind not in SOLIDS]
TINY_COSINE = 0.02  # rays to the far side make at least this with the surface that they leave


def arrivals(place, rng, count, middle=0.0, flat=False):
    """Return float32 rays (N, 3) at points around a middle; of sheets in their plane, from both of its sides."""
    scale, sizes = stage.PLACES[place]
    at = rng.uniform(-0.15, 0.15, (count, 3 - flat)) @ stage.TURN[: 3 - flat] + middle
    from_ = probe.unit(rng.normal(size=at.shape)).astype(float)
    if flat:
        from_ += 0.2 * np.sign(from_ @ stage.TURN[2])[:, None] * stage.TURN[2]
    middle = scale * sizes * np.array([0.9, -0.7, 1.0])
    o = np.float32(scale * (at + 3 * from_) + middle)
    return o, probe.unit(scale * at + middle - o)


@lru_cache(maxsize=8)
def met(kind, place):
    """Return a shape, rays (o, d) at it, and what they meet; of a kind, or of a closed mesh `ball`."""
    rng = np.random.default_rng(17)
    o, d = arrivals(place, rng, RAYS, flat=kind in SHEETS)
    if kind == "ball":
        scale, sizes = stage.PLACES[place]
        v, faces = ball(20)
        shape = np.float32(scale * v + scale * sizes * np.array([0.9, -0.7, 1.0]))[faces]
        geometry = stage.mesh(shape)
    else:
        shape = stage.placed(kind, place, **UNIT[kind])
        geometry = stage.scene(shape)
        shape = (shape,)
    return shape, geometry, (o, d), *stage.seen(geometry, o, d)


def outwards(surface, d, rng):
    """Return directions from surfaces to the side that rays with directions d came from."""
    n = np.broadcast_to(surface.n_geo.numpy().T, d.shape)
    return stage.hemisphere(-n * np.sign((n * d).sum(1, keepdims=True)), rng)


def again(kinds, rays):
    """Return which rays that leave meet the shape again, or had not met it at all."""
    wrong = []
    for kind in kinds:
        for place in stage.PLACES:
            _, geometry, (_, d), hit, surface = met(kind, place)
            out = outwards(surface, d, np.random.default_rng(5))
            wrong.append(stage.meets(geometry, rays(hit, surface, out))[0] | ~hit.valid.numpy())
    return np.concatenate(wrong)


def again_mitsuba(kinds):
    """Return the same of Mitsuba."""
    wrong = []
    for kind in kinds:
        for place in stage.PLACES:
            shape, _, (o, d), _, surface = met(kind, place)
            scene, found = stage.theirs(shape, o, d)
            out = stage.vector(stage.mitsuba(), outwards(surface, d, np.random.default_rng(5)))
            wrong.append(scene.ray_test(found.spawn_ray(out)).numpy() | ~found.is_valid().numpy())
    return np.concatenate(wrong)


# Inwards: the far side, at its distance


def far_side(shape, o, d):
    """Return where lines (N, 3) leave a solid, and the cosine with the surface there, in double precision."""
    o, d = o.astype(probe.EXACT), d.astype(probe.EXACT)
    d = d / np.sqrt(probe.dot(d, d))[:, None]
    if shape.type == "sphere":
        f = o - np.array(shape.center)
        b = probe.dot(f, d)
        t = -b + np.sqrt(np.maximum(b * b - probe.dot(f, f) + shape.radius**2, 0))
        return t, probe.dot(f + t[:, None] * d, d) / shape.radius
    planes, t, cosine = [], np.full(len(o), np.inf), np.zeros(len(o))
    if shape.type == "cylinder":
        axis = np.array(shape.axis) / np.linalg.norm(shape.axis)
        f = o - np.array(shape.center)
        f, across = f - (f @ axis)[:, None] * axis, d - (d @ axis)[:, None] * axis
        a, b = probe.dot(across, across), probe.dot(f, across)
        t = (-b + np.sqrt(np.maximum(b * b - a * (probe.dot(f, f) - shape.radius**2), 0))) / a
        cosine = probe.dot(f + t[:, None] * across, d) / shape.radius
        planes = [(sign * axis, sign * axis @ shape.center + shape.height) for sign in (1, -1)]
    elif shape.type == "box":
        planes = [*zip(np.eye(3), shape.max), *zip(-np.eye(3), np.negative(shape.min))]
    else:
        hull = stage.hull(shape)
        planes = [*zip(hull[:, :3], -hull[:, 3])]
    for n, offset in planes:
        rate = d @ n
        end = np.where(rate > 0, (offset - o @ n) / np.where(rate > 0, rate, 1), np.inf)
        t, cosine = np.where(end < t, end, t), np.where(end < t, rate, cosine)
    return t, cosine


def inwards(surface, d, rng):
    """Return directions into solids, at least TINY_COSINE steep."""
    inside = -stage.hemisphere(surface.n_geo.numpy().T, rng).astype(float)
    return probe.unit(inside - 2 * TINY_COSINE * surface.n_geo.numpy().T)


def beyond(shape, place, o, d, valid, t):
    """Return errors of distances to the far side, in roundoffs of origin and size over its cosine; a miss is 0 far."""
    exact, cosine = far_side(shape, o, d)
    size = np.abs(o).max(1) + stage.PLACES[place][0]
    return (np.abs(np.where(valid, t, 0) - exact) * np.maximum(cosine, 1e-3) / (ULP * size)).astype(float)


def through(rays):
    """Return the errors of rays through solids."""
    errors = []
    for kind in SOLIDS:
        for place in stage.PLACES:
            (shape,), geometry, (_, d), hit, surface = met(kind, place)
            ray = rays(hit, surface, inwards(surface, d, np.random.default_rng(6)))
            way = probe.doubles(ray.o).T, probe.doubles(ray.d).T
            errors.append(beyond(shape, place, *way, *stage.meets(geometry, ray)))
    return np.concatenate(errors)


def through_mitsuba():
    """Return the same of Mitsuba, from where its rays start."""
    errors = []
    for kind in SOLIDS:
        for place in stage.PLACES:
            shape, _, (o, d), _, surface = met(kind, place)
            scene, found = stage.theirs(shape, o, d)
            into = stage.vector(stage.mitsuba(), inwards(surface, d, np.random.default_rng(6)))
            ray = found.spawn_ray(into)
            end = scene.ray_intersect(ray)
            args = probe.doubles(ray.o).T, probe.doubles(ray.d).T, end.is_valid().numpy(), probe.doubles(end.t)
            errors.append(beyond(shape[0], place, *args))
    return np.concatenate(errors)


def _outwards(name, kinds, because, remark=""):
    """Return the case of shapes that must not be met again."""
    return Case(name, "share", 0, because, lambda: again(kinds, stage.ours), lambda: again(kinds, stage.by_epsilon),
                "start 1e-4 along the way", lambda: again_mitsuba(kinds), remark)


CASES = (
    _outwards("solids left outwards are not met again", SOLIDS,
              "convex: whoever leaves them outwards cannot meet them, and the ray knows whom it left"),
    _outwards("sheets left on the side that was seen are not met again", SHEETS,
              "flat: no ray meets the sheet that it left"),
    _outwards("a closed mesh left outwards is not met again", ["ball"],
              "rays start off their triangle by the bound of the point's rounding and of the neighbours' corners'"),
    Case("solids left inwards end at their far side", "roundoffs", 8,
         "of origin and size, over the cosine at the exit: a difference from the middle, its product with the direction"
         " (3), the square of the distance (half of 5), root and sum; a miss counts as a way of 0",
         lambda: through(stage.ours), lambda: through(stage.by_epsilon), "start 1e-4 along the way", through_mitsuba),
)
