"""Surfaces close together and in contact.

What starts 1e-4 off its surface starts behind whatever is closer, and light passes. Two surfaces here are 1e-5 of a
size apart, or 16 roundoffs of where they are if that is more, and must see each other. A box stands on a floor, at the
very height of it: from the floor below it, and from beside it towards a light behind it, no light is seen, as close to
the edge as 1e-5 of a size or 16 roundoffs. The sizes and places are those of the section on leaving a surface.
"""

from functools import lru_cache

import numpy as np

from tests.stability import probe, stage
from tests.stability.case import ULP, Case

RAYS = 4000  # for each pair and place
GAP = 1e-5  # of a size
ROUNDOFFS = 16  # of coordinates: a gap's least width. Rays reach off a surface by less than 6, and corners are rounded
UP = np.array([0.0, 1.0, 0.0])


def gap(place):
    """Return the width of gaps in sizes."""
    return max(GAP, ROUNDOFFS * ULP * stage.PLACES[place][1])


def middle(place):
    """Return the middle of a place."""
    scale, sizes = stage.PLACES[place]
    return scale * sizes * np.array([0.9, -0.7, 1.0])


def around(place, at):
    """Return points given in sizes from the middle, (N, 3), in double precision."""
    return stage.PLACES[place][0] * at + middle(place)


# Two surfaces, one above the other


def _triangle(place, at):
    """Return a triangle along no axis, moved by `at` in its own size."""
    corners = np.array([[-1, -0.7], [1.1, -0.5], [-0.1, 1.2]]) @ stage.TURN[:2] + at
    return stage.placed("triangle", place, **dict(zip(("v0", "v1", "v2"), corners)))


SHEETS = {
    "triangle": _triangle,
    "rectangle": lambda place, at: stage.placed("rectangle", place, center=at, u=1.5 * stage.TURN[0], v=stage.TURN[1]),
    "disk": lambda place, at: stage.placed("disk", place, center=at, normal=stage.TURN[2], radius=1),
    "mesh": _triangle,
}
# of these, a pair: one below the origin and one above, whose surfaces are a gap apart there
SOLIDS = {
    "sphere": lambda place, n, gap: [
        stage.placed("sphere", place, center=side * (1 + gap / 2) * n + gap / 2 * n, radius=1) for side in (-1, 1)],
    "box": lambda place, n, gap: [stage.placed("box", place, min=[-1, -1, -1], max=[1, 0, 1]),
                                  stage.placed("box", place, min=[-1, gap, -1], max=[1, 1, 1])],
}
WIDE = {"sphere": 1e-3}  # how far from the middle points are, in sizes; others 0.2


def axes_of(kind):
    """Return the axes of a pair, of which the last leads from the lower to the upper one."""
    return np.eye(3)[[2, 0, 1]] if kind == "box" else stage.TURN


@lru_cache(maxsize=64)
def pair(kind, place):
    """Return the shapes (lower, upper), their Geometry, and rays at the lower one from below, with what they meet."""
    axes = axes_of(kind)
    normal = axes[2]
    if kind in SOLIDS:
        shapes = tuple(SOLIDS[kind](place, normal, gap(place)))
    else:
        shapes = SHEETS[kind](place, 0 * normal), SHEETS[kind](place, gap(place) * normal)
    if kind == "mesh":
        shapes = np.array([[shape.v0, shape.v1, shape.v2] for shape in shapes])
    geometry = stage.mesh(shapes) if kind == "mesh" else stage.scene(*shapes)
    rng = np.random.default_rng(31)
    at = rng.uniform(-1, 1, (RAYS, 2)) * WIDE.get(kind, 0.2) @ axes[:2]
    o = np.float32(around(place, at - 0.5 * normal + 0.1 * rng.normal(size=at.shape)))
    d = probe.unit(around(place, at) - o)
    return shapes, geometry, (o, d), *stage.seen(geometry, o, d)


def _upwards(kind):
    """Return directions that reach the upper surface within twenty gaps."""
    rng = np.random.default_rng(32)
    n = np.tile(axes_of(kind)[2], (RAYS, 1))
    return probe.unit(stage.hemisphere(n, rng).astype(float) + 0.05 * n)


def pairs():
    """Return the arguments of `pair`."""
    return [(kind, place) for kind in (*SHEETS, *SOLIDS) for place in stage.PLACES]


def unseen(rays):
    """Return from which points of the lower surface the upper one is not met, or does not shade."""
    wrong = []
    for kind, place in pairs():
        _, geometry, _, hit, surface = pair(kind, place)
        lower = hit.index.numpy() == 0
        for found in stage.blocked(geometry, rays(hit, surface, _upwards(kind)), stage.PLACES[place][0]):
            wrong.append(~found | ~lower)
    return np.concatenate(wrong)


def unseen_mitsuba():
    """Return the same of Mitsuba, by its query for shadows."""
    wrong, mi = [], stage.mitsuba()
    for kind, place in pairs():
        shapes, _, (o, d), _, _ = pair(kind, place)
        scene, found = stage.theirs(shapes, o, d)
        ray = found.spawn_ray(stage.vector(mi, _upwards(kind)))
        ray.maxt = mi.Float(stage.PLACES[place][0])
        wrong.append(~scene.ray_test(ray).numpy())
    return np.concatenate(wrong)


# A box on a floor

BOX = {"min": [-0.5, 0, -0.5], "max": [0.5, 0.6, 0.5]}
CORNERS = np.array([[-2, 0, -2], [-2, 0, 2], [2, 0, 2], [2, 0, -2]])


def _floors(place):
    """Return {name: shapes of a floor at height 0}."""
    halves = [dict(zip(("v0", "v1", "v2"), CORNERS[order])) for order in ([0, 1, 2], [2, 3, 0])]
    return {
        "plane": [stage.placed("plane", place, point=[0, 0, 0], normal=UP)],
        "quad": [stage.placed("triangle", place, **half) for half in halves],
        "rectangle": [stage.placed("rectangle", place, center=[0, 0, 0], u=[4, 0, 0], v=[0, 0, -4])],
        "box": [stage.placed("box", place, min=[-2, -0.5, -2], max=[2, 0, 2])],
    }


FLOORS = "plane", "quad", "rectangle", "box", "mesh"


def _faces(box):
    """Return the twelve triangles of a box, (12, 3, 3)."""
    from tests.support.soups import cube

    v, faces = cube()
    low, high = np.array(box.min), np.array(box.max)
    return np.where(v > 0, high, low)[faces]


@lru_cache(maxsize=64)
def contact(kind, place):
    """Return a floor with a box: (shapes of the floor, all shapes), their Geometry, rays at the floor, and the hits.

    The rays are those that would meet the floor without the box, below and beside its edge at x = 0.5.
    """
    box = stage.placed("box", place, **BOX)
    if kind == "mesh":
        floor = np.array([[half.v0, half.v1, half.v2] for half in _floors(place)["quad"]])
        shapes = np.concatenate([floor, _faces(box)])
        bare, geometry = stage.mesh(floor), stage.mesh(shapes)
    else:
        floor = tuple(_floors(place)[kind])
        shapes = *floor, box
        bare, geometry = stage.scene(*floor), stage.scene(*shapes)
    rng = np.random.default_rng(33)
    beside = np.exp(rng.uniform(np.log(gap(place)), np.log(0.3), RAYS))
    at = np.stack([0.5 + np.where(np.arange(RAYS) % 2, beside, -beside), 0 * beside, rng.uniform(-0.3, 0.3, RAYS)], 1)
    o = np.float32(around(place, at + UP))
    d = np.tile(-UP, (RAYS, 1))
    return (floor, shapes), geometry, (o, d), *stage.seen(bare, o, d)


def _to_light():
    """Return directions that pass the box: out of its side from below it, into it from beside it."""
    rng = np.random.default_rng(34)
    slope = rng.uniform(0.1, 1.5, RAYS)
    side = np.where(np.arange(RAYS) % 2, -1.0, 1.0)
    return probe.unit(np.stack([side, np.where(side < 0, 0.3 * slope, slope), rng.uniform(-0.1, 0.1, RAYS)], 1))


def contacts():
    """Return the arguments of `contact`."""
    return [(kind, place) for kind in FLOORS for place in stage.PLACES]


def lit(rays):
    """Return from which points of the floor a light is seen through the box, by a query for shadows or for hits."""
    wrong = []
    for kind, place in contacts():
        _, geometry, _, hit, surface = contact(kind, place)
        valid = hit.valid.numpy()
        for found in stage.blocked(geometry, rays(hit, surface, _to_light()), 5 * stage.PLACES[place][0]):
            wrong.append(~found | ~valid)
    return np.concatenate(wrong)


def lit_mitsuba():
    """Return the same of Mitsuba, by its query for shadows."""
    wrong, mi = [], stage.mitsuba()
    for kind, place in contacts():
        (floor, shapes), _, (o, d), _, _ = contact(kind, place)
        _, found = stage.theirs(floor, o, d)
        ray = found.spawn_ray(stage.vector(mi, _to_light()))
        ray.maxt = mi.Float(5 * stage.PLACES[place][0])
        wrong.append(~stage.mitsuba_scene(shapes).ray_test(ray).numpy())
    return np.concatenate(wrong)


CASES = (
    Case("two surfaces 1e-5 of their size apart see each other", "share", 0,
         "farther than a ray starts off its surface, and than rounding can put it off the other",
         lambda: unseen(stage.ours), lambda: unseen(stage.by_epsilon), "start 1e-4 along the way", unseen_mitsuba),
    Case("no light under a box on a floor, nor through its edge", "share", 0,
         "nothing is moved, so that the way through the box is as long as it is",
         lambda: lit(stage.ours), lambda: lit(stage.by_epsilon), "start 1e-4 along the way", lit_mitsuba),
)
