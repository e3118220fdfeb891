"""Lamps seen in mirrors: where they are seen, how bundles of rays widen, and that no light is lost or counted twice."""

import numpy as np
import pytest

from renderer.core.backend import Float, Vector3f
from renderer.core.rows import Rows
from renderer.engine.render import render
from renderer.scene import mirrors
from renderer.scene.loader import from_dict
from tests.support.documents import CAMERA

rng = np.random.default_rng(20240311)
N = 20_000
CENTRE, RADIUS = np.array([0.3, -0.2, 0.5]), 0.7
SIDE = np.array([0.2, 1.0, -0.4]) / np.linalg.norm([0.2, 1.0, -0.4])
BALL = Rows([[*CENTRE, RADIUS, 0.0, 0.0, 1.0, 1.0, 1.0]])[0]
FLAT = Rows([[*CENTRE, *SIDE, 1.0, 1.0, 1.0]])[0]


def unit(v):
    """Return rows scaled to length 1."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def outside(count):
    """Return points at 0.001 to 100 radii above the ball."""
    return CENTRE + unit(rng.normal(size=(count, 3))) * (RADIUS * (1 + 10 ** rng.uniform(-3, 2, (count, 1))))


def vectors(points):
    """Return points (N, 3) as lanes."""
    return Vector3f(points.T.astype(np.float32))


def host(lanes):
    """Return lanes as (N, 3) or (N,) float64."""
    return lanes.numpy().T.astype(np.float64)


def found(find, row, p, q):
    """Return what `find` tells of the ways from p to q that are possible, with these p and q."""
    wo, x, n, spread, possible = find(row, vectors(p), vectors(q))
    keep = np.broadcast_to(possible.numpy(), len(p))
    section = host(spread.section(Float(np.linalg.norm(q - host(x), axis=1).astype(np.float32))))
    n = np.broadcast_to(host(n), p.shape)
    return [part[keep] for part in (host(wo), host(x), n, section, p, q)], keep


def mirrored(d, n):
    """Return directions reflected at normals."""
    return d - 2 * (d * n).sum(-1, keepdims=True) * n


def test_ball_reflects_at_equal_angles():
    """The direction from p, mirrored at x, leads to q; and x is on the ball."""
    (wo, x, n, _, p, q), keep = found(mirrors.on_ball, BALL, outside(N), outside(N))
    assert 0.3 < keep.mean() < 0.9
    np.testing.assert_allclose(np.linalg.norm(x - CENTRE, axis=1), RADIUS, rtol=1e-6)
    np.testing.assert_allclose(wo, unit(x - p), atol=3e-3)
    off = np.linalg.norm(mirrored(unit(x - p), n) - unit(q - x), axis=1)
    assert np.quantile(off, 0.99) < 1e-4 and off.max() < 1e-2


def test_ball_shows_what_can_be_seen():
    """A way is possible if there is a point of the ball that both see, which a search over the great circle tells."""
    p, q = outside(500), outside(500)
    _, keep = found(mirrors.on_ball, BALL, p, q)
    to_p, to_q = (p - CENTRE) / RADIUS, (q - CENTRE) / RADIUS
    t = np.linspace(0, 1, 2001)[:, None, None]
    n = unit(unit(to_p) * (1 - t) + unit(to_q) * t)
    seen = (np.minimum((n * to_p).sum(-1), (n * to_q).sum(-1)) > 1).any(axis=0)
    assert (keep != seen).mean() < 0.01


def test_nothing_is_shown_inside_of_a_ball():
    """Nor to a point inside."""
    inner = CENTRE + unit(rng.normal(size=(N, 3))) * RADIUS * rng.uniform(0.1, 0.99, (N, 1))
    assert not found(mirrors.on_ball, BALL, inner, outside(N))[1].any()
    assert not found(mirrors.on_ball, BALL, outside(N), inner)[1].any()


def test_flat_mirror_shows_the_image():
    """Where both points are on one side, and only there."""
    p, q = (CENTRE + rng.normal(size=(N, 3)) for _ in range(2))
    (wo, x, n, section, p_seen, q_seen), keep = found(mirrors.on_flat, FLAT, p, q)
    same = ((p - CENTRE) @ SIDE) * ((q - CENTRE) @ SIDE) > 0
    assert (keep != same).mean() < 1e-4
    np.testing.assert_allclose((x - CENTRE) @ SIDE, 0, atol=1e-5)
    far = np.minimum(np.abs((p_seen - CENTRE) @ SIDE), np.abs((q_seen - CENTRE) @ SIDE)) > 1e-2
    np.testing.assert_allclose(mirrored(wo, n)[far], unit(q_seen - x)[far], atol=1e-3)
    whole = np.linalg.norm(x - p_seen, axis=1) + np.linalg.norm(q_seen - x, axis=1)
    np.testing.assert_allclose(section, whole**2, rtol=1e-3)


def area_by_differences(wo, p, q):
    """Return the cross section at q per solid angle, from four rays next to each direction wo, in double precision."""
    t = unit(np.cross(wo, unit(rng.normal(size=wo.shape))))
    b, step, ends = np.cross(wo, t), 1e-6, []
    for offset in (t, b):
        pair = []
        for sign in (-1, 1):
            d = unit(wo + sign * step * offset)
            f = p - CENTRE
            along = -(f * d).sum(-1)
            x = p + (along - np.sqrt(RADIUS**2 - ((f + along[:, None] * d) ** 2).sum(-1)))[:, None] * d
            out = mirrored(d, unit(x - CENTRE))
            pair.append((x, out))
        ends.append(pair)
    x, out = (0.25 * sum(part[k] for pair in ends for part in pair) for k in range(2))
    out = unit(out)
    flow = []
    for (x0, d0), (x1, d1) in ends:
        hits = [xk + (((q - xk) * out).sum(-1) / (dk * out).sum(-1))[:, None] * dk for xk, dk in ((x0, d0), (x1, d1))]
        flow.append((hits[1] - hits[0]) / (2 * step))
    return np.linalg.norm(np.cross(*flow), axis=1)


def test_bundles_widen_as_rays_next_to_each_other_do():
    """Coddington's equations against differences of rays."""
    (wo, x, n, section, p, q), _ = found(mirrors.on_ball, BALL, outside(N), outside(N))
    cosine = -(unit(x - p) * n).sum(-1)
    clear = (cosine > 0.2) & (np.linalg.norm(x - p, axis=1) > 0.05) & (np.linalg.norm(q - x, axis=1) > 0.05)
    exact = area_by_differences(unit(x - p)[clear], p[clear], q[clear])
    off = np.abs(section[clear] / exact - 1)
    assert np.median(off) < 1e-4 and np.quantile(off, 0.99) < 1e-2


MATT = {"bsdf": {"type": "diffuse", "reflectance": [0.7, 0.6, 0.5]}}
SHINING = {"kd": 0.6, "ks": 0.3, "specularexponent": 15.0, "diffusecolor": [0.5, 0.6, 0.7]}
HALF = {**SHINING, "isreflective": True, "reflectivity": 0.6}
MIRROR = {"bsdf": {"type": "mirror", "reflectance": [0.9, 0.8, 0.7]}}
LAMP = {"type": "arealight", "position": [-0.6, 1.6, -0.4], "u": [0.1, 0, 0], "v": [0, 0, 0.1],
        "intensity": [180, 160, 140]}  # fmt: skip
FLOOR = {"type": "rectangle", "center": [0, -0.9, 0], "u": [6, 0, 0], "v": [0, 0, 6], "material": SHINING}
ROUND = {"type": "sphere", "center": [0.4, -0.3, 0.1], "radius": 0.6, "material": MIRROR}
SHEET = {"type": "triangle", "v0": [-1.5, -0.9, 0.8], "v1": [0.4, -0.9, 1.2], "v2": [-0.8, 1.2, 1.0], "material": HALF}
FLOOR_SEEN = {"width": 48, "height": 32, "position": [-0.5, 1.6, -1.6], "lookAt": [-0.6, -0.9, -0.1], "fov": 30}
MIRRORS_FROM = 32  # column of the pictures: left of it there is only floor
SCENES = {
    "ball": ([FLOOR, ROUND], [LAMP]),
    "flat": ([FLOOR, SHEET], [LAMP | {"twosided": False}]),
    "both, two lamps": ([FLOOR, ROUND, SHEET], [LAMP, {"type": "disklight", "position": [1.2, 1.0, -0.5], "normal":
                        [-1, -1, 0.2], "radius": 0.05, "intensity": [160, 320, 160]}]),
    "lamp behind things": ([FLOOR, ROUND, SHEET, {"type": "box", "min": [-0.9, 0.4, -0.7], "max": [-0.3, 1.0, -0.1],
                           "material": MATT}], [LAMP]),
    "mirrors among each other": ([FLOOR | {"material": HALF}, ROUND, SHEET], [LAMP]),
    "camera inside": ([FLOOR, {**ROUND, "center": [0, 0, 0], "radius": 5.5}], [LAMP]),
}  # fmt: skip


def pictures(name, looks, seeds, samples=256, nbounces=4):
    """Return pictures (seeds, H, W, 3) with or without the look into mirrors."""
    shapes, lights = SCENES[name]
    world = {"backgroundcolor": [0.1, 0.1, 0.15], "lightsources": lights, "shapes": shapes}
    loaded = from_dict({"rendermode": "pathtracer", "nbounces": nbounces, "samples": samples, "roulette": False,
                        "mirrorlight": looks, "camera": {**CAMERA, **FLOOR_SEEN}, "scene": world})  # fmt: skip
    rendered = [render(loaded, seed=seed).channels() for seed in seeds]
    return np.array([[picture[c] for c in "RGB"] for picture in rendered], np.float64).transpose(0, 2, 3, 1)


def apart(one, other):
    """Return how many standard errors the mean radiances of two sets of pictures are apart."""
    means = [side.mean((1, 2, 3)) for side in (one, other)]
    return abs(means[0].mean() - means[1].mean()) / np.sqrt(sum(side.var(ddof=1) / len(side) for side in means))


@pytest.mark.parametrize("name", SCENES)
def test_no_light_is_lost_or_counted_twice(name):
    """Pictures have the same mean whether mirrors are looked into or not."""
    looking = pictures(name, True, range(12))
    by_chance = pictures(name, False, range(100, 112))
    assert apart(looking, by_chance) < 4.5


@pytest.mark.parametrize("name", ["ball", "flat"])
def test_the_look_pays(name):
    """A tenth of the floor's variance is left at most, for as many samples."""
    looking, by_chance = (
        pictures(name, looks, range(6), samples=16)[:, :, :MIRRORS_FROM].var(axis=0).mean()
        for looks in (True, False)
    )
    assert looking < by_chance / 10


SABOTAGE = {
    "ball taken for flat": lambda: ("_spread", lambda d1, cosine, curvature: mirrors.Spread(d1, Float(1), Float(1))),
    "no colour": lambda: ("colour_of", lambda shape, right=mirrors.colour_of: right(shape) and (1.0, 1.0, 1.0)),
}  # fmt: skip


@pytest.mark.parametrize("scene, mistake", [("ball", "ball taken for flat"), ("flat", "no colour")])
def test_mistakes_are_noticed(scene, mistake, monkeypatch):
    """A wrong cross section, or a forgotten reflectance, shows."""
    right = pictures(scene, True, range(12))
    monkeypatch.setattr(mirrors, *SABOTAGE[mistake]())
    assert apart(right, pictures(scene, True, range(100, 112))) > 6
