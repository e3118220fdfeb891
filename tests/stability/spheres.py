"""Spheres.

The textbook's b^2 - 4ac loses what is small beside the square of the distance: spheres far away, and rays that graze.
Where rounding of the input alone moves the answer far, errors are counted backwards: how far the sphere would have to
be moved so that the answer is exact, in roundoffs (2^-24) of |f| + r, of the way from the centre to the ray's origin
and the radius. A root near 0, of a ray that starts on its sphere, is noise in any formula; the renderer does not ask
for it, because its rays know what they left.
"""

from functools import lru_cache

import drjit as dr
import numpy as np

from renderer.core.records import Ray
from renderer.scene.geometry import leave
from tests.stability import probe
from tests.stability.case import ULP, Case, mitsuba, ulps
from tests.stability.probe import EXACT, Found, dot, ours, theirs

COUNT = 20_000
MIDDLE = (0.3, -0.2, 0.1)
PLAIN = probe.sphere(MIDDLE, 0.7)
TINY = probe.sphere(MIDDLE, 1e-4)
HUGE = probe.sphere(MIDDLE, 1e6)
DISTANT = probe.sphere((1e3, 1e6, 3e5), 1.0)
GROUND = probe.sphere((0, -25, 0), 25.1)  # the coursework's, under a scene of size 1


def rays(sphere, radii, spread, seed):
    """Return rays from `radii` away that pass the centre at up to `spread` radii."""
    rng = np.random.default_rng(seed)
    centre, r = np.array(sphere.center), sphere.radius
    o = (centre + radii * r * probe.unit(rng.normal(size=(COUNT, 3)))).astype(np.float32)
    beside = probe.unit(np.cross(rng.normal(size=(COUNT, 3)), o - centre))
    return o, probe.unit(centre + beside * (spread * r * rng.uniform(-1, 1, (COUNT, 1))) - o)


def grazing(sphere, radii, seed):
    """Return rays that pass the centre at nearly a radius, from 1e-6 to 0.1 of it inside and outside."""
    rng = np.random.default_rng(seed)
    o, _ = rays(sphere, radii, 0, seed)
    centre, depth = np.array(sphere.center), 10 ** rng.uniform(-6, -1, (COUNT, 1)) * rng.choice([-1, 1], (COUNT, 1))
    beside = probe.unit(np.cross(rng.normal(size=(COUNT, 3)), o - centre)).astype(EXACT)
    reach = np.sqrt(1 - 1 / radii**2)  # a tangent touches the sphere before its middle
    return o, probe.unit(centre + beside * (sphere.radius * (1 - depth) / reach) - o)


def over_ground():
    """Return rays from above the coursework's ground that meet it, steeply and along it."""
    rng = np.random.default_rng(5)
    o = (np.array([0, 0.75, -0.25]) + rng.normal(size=(COUNT, 3)) * [1, 0.05, 1]).astype(np.float32)
    d = probe.unit(rng.normal(size=(COUNT, 3)) * [1, 0.2, 1] - [0, 0.1, 0])
    meets = np.isfinite(first(GROUND, o, d))
    return o[meets], d[meets]


def roots(sphere, o, d):
    """Return near and far (NaN where the line misses), its distance from the centre, and |f|, all exact."""
    f, d = np.asarray(o, EXACT) - sphere.center, np.asarray(d, EXACT)
    middle = -dot(f, d) / dot(d, d)
    passing = f + middle[:, None] * d
    with np.errstate(invalid="ignore"):
        half = np.sqrt((EXACT(sphere.radius) ** 2 - dot(passing, passing)) / dot(d, d))
    return middle - half, middle + half, np.sqrt(dot(passing, passing)), np.sqrt(dot(f, f))


def textbook(sphere, o, d):
    """Return both roots of the quadratic equation in float32."""
    f = o - np.float32(sphere.center)
    a, b = (d * d).sum(-1), 2 * (f * d).sum(-1)
    c = (f * f).sum(-1) - np.float32(sphere.radius) ** 2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - 4 * a * c)
    return (-b - root) / (2 * a), (-b + root) / (2 * a)


def naive(sphere, o, d):
    """Return what the textbook finds: the first root beyond 0, and the point there as it is."""
    near, far = textbook(sphere, o, d)
    t = np.where(near > 0, near, far)
    p = o + t[:, None] * d
    t = np.where(t > 0, t, np.inf).astype(float)
    return Found(t, p.astype(float), ((p - np.float32(sphere.center)) / np.float32(sphere.radius)).astype(float))


def both_roots(sphere, o, d):
    """Return both roots of the renderer's interval."""
    (group,) = probe.geometry(sphere).shapes
    _, near, far = group.kind.interval(group.rows[0], Ray(probe.vectors(o), probe.vectors(d)))
    dr.eval(near, far)
    return probe.doubles(near), probe.doubles(far)


def first(sphere, o, d):
    """Return the exact distance to the first hit, infinity for none."""
    near, far, *_ = roots(sphere, o, d)
    t = np.where(near > 0, near, far)
    return np.where(t > 0, t, np.inf)


def scale(sphere, o):
    """Return |f| + r of each ray: what roundoffs are of."""
    f = np.asarray(o, EXACT) - sphere.center
    return (np.sqrt(dot(f, f)) + sphere.radius) * ULP


def off(sphere, p):
    """Return the distances of points from the sphere."""
    q = np.asarray(p, EXACT) - sphere.center
    return np.abs(np.sqrt(dot(q, q)) - sphere.radius)


def decided(sphere, o, d):
    """Return a measure: by how many roundoffs rays pass the rim that are wrongly said to hit or miss."""
    *_, passing, _ = roots(sphere, o, d)
    wanted = np.isfinite(first(sphere, o, d))
    beside = np.abs(passing - sphere.radius) / scale(sphere, o)
    return lambda find: np.where(find(sphere, o, d).hit == wanted, 0, beside)


def reached(sphere, o, d):
    """Return a measure: errors of t in ulp."""
    exact = first(sphere, o, d)
    return lambda find: ulps(find(sphere, o, d).t, exact)


def settled(*inputs):
    """Return a measure: how far the found points are from their spheres, in roundoffs of centre and radius."""
    def errors(find):
        return np.concatenate([
            off(sphere, find(sphere, o, d).p) / ((np.abs(sphere.center).max() + sphere.radius) * ULP)
            for sphere, o, d in inputs
        ])  # fmt: skip
    return errors


def turned(sphere, o, d):
    """Return a measure: errors of the normal, in roundoffs of |f| over r."""
    p = o + np.asarray(d, EXACT) * first(sphere, o, d)[:, None] - sphere.center
    exact = p / np.sqrt(dot(p, p))[:, None]

    def errors(find):
        apart = find(sphere, o, d).n - exact
        return np.sqrt(dot(apart, apart)) / (scale(sphere, o) / sphere.radius)
    return errors


def roots_off(sphere, o, d):
    """Return a measure: errors of both roots, in roundoffs of the sphere's size that would explain them."""
    near, far, passing, _ = roots(sphere, o, d)
    kept = np.isfinite(near) & (sphere.radius - passing > 4 * scale(sphere, o))
    to_backward = np.sqrt(sphere.radius**2 - passing[kept] ** 2) / sphere.radius / scale(sphere, o)[kept]

    def errors(solve):
        return np.array([np.abs(found[kept] - exact[kept]) * to_backward
                         for found, exact in zip(solve(sphere, o, d), (near, far))], np.float64)
    return errors


@lru_cache
def inwards():
    """Return points where rays met the plain sphere, and directions from there into it, many of them shallow."""
    rng = np.random.default_rng(7)
    p = ours(PLAIN, *rays(PLAIN, 3, 0.99, 8)).p.astype(np.float32)
    d = probe.unit(rng.normal(size=p.shape))
    n = (p - np.array(PLAIN.center)) / PLAIN.radius
    across = probe.unit(d - dot(d, n)[:, None] * n)
    steep = 10 ** rng.uniform(-2, 0, (len(p), 1))
    return p, probe.unit(np.sqrt(1 - steep**2) * across - steep * n)


def chord(find):
    """Return the errors of chords from a sphere's own points, in roundoffs of its size that would explain them."""
    o, d = inwards()
    _, far, passing, _ = roots(PLAIN, o, d)
    steep = np.sqrt(PLAIN.radius**2 - passing**2) / PLAIN.radius
    return np.abs(find(PLAIN, o, d).t - far) * steep / scale(PLAIN, o)


def leaving(sphere, o, d):
    """Return a measure: how far from the sphere rays start that leave it, in roundoffs of centre and radius."""
    return lambda start: off(sphere, start(sphere, o, d)) / ((np.abs(sphere.center).max() + sphere.radius) * ULP)


def our_start(sphere, o, d):
    """Return where the renderer's rays start that leave a sphere."""
    geometry = probe.geometry(sphere)
    ray = Ray(probe.vectors(o), probe.vectors(d))
    hit = geometry.intersect(ray)
    surface = geometry.surface(ray, hit, with_uv=False)
    return probe.doubles(leave(surface, hit.index, surface.n_geo).o).T


def moved_start(sphere, o, d):
    """Return the usual: points moved by 1e-4 along the normal."""
    found = naive(sphere, o, d)
    return (found.p + 1e-4 * found.n).astype(np.float32)


def mitsuba_start(sphere, o, d):
    """Return where Mitsuba's rays start."""
    mi = mitsuba()
    found = probe.stage(sphere).ray_intersect(mi.Ray3f(mi.Point3f(*probe.columns(o)), mi.Vector3f(*probe.columns(d))))
    return probe.doubles(found.spawn_ray(found.n).o).T


def three(measure, naive=naive, ours=ours, theirs=theirs):
    """Return the arguments of a Case that measures all sides in one way."""
    return {"ours": lambda: measure(ours), "naive": lambda: measure(naive),
            "mitsuba": theirs and (lambda: measure(theirs))}  # fmt: skip


QUADRATIC = "b^2 - 4ac of the quadratic equation, and o + t d"
AGAIN = ("it solves once more from the middle of the line, though not for shadow rays; here that halved these errors, "
         "which are a few roundoffs, and took 3 to 5 % of the speed of the coursework's scene")
ALONG = "three roundings of f.d, two of the length of d, and one each of f, of the root and of the difference"
CASES = (
    Case("sphere of 1e-4 from 1e6 radii: hit or miss", "roundoffs of the way", 3.0,
         "one rounding of f, and two of the radius", naive_name=QUADRATIC, remark=AGAIN,
         **three(decided(TINY, *rays(TINY, 1e6, 1.2, 1)))),
    Case("sphere from 1e3 radii, grazing: hit or miss", "roundoffs of the way", 3.0,
         "one rounding of f, and two of the radius", naive_name=QUADRATIC, remark=AGAIN,
         **three(decided(PLAIN, *grazing(PLAIN, 1e3, 3)))),
    Case("sphere of 1e-4 from 1e3 radii: shadow or none", "roundoffs of the way", 3.0,
         "one rounding of f, and two of the radius", naive_name=QUADRATIC,
         **three(decided(TINY, *rays(TINY, 1e3, 1.2, 6)), ours=probe.our_shadows, theirs=probe.mitsuba_shadows)),
    Case("sphere of 1e-4 from 1e6 radii: distance", "ulp", 8.0, ALONG, naive_name=QUADRATIC, remark=AGAIN,
         **three(reached(TINY, *rays(TINY, 1e6, 0.9, 2)))),
    Case("sphere of 1e-4 from 1e3 radii: distance", "ulp", 8.0, ALONG, naive_name=QUADRATIC,
         **three(reached(TINY, *rays(TINY, 1e3, 0.9, 2)))),
    Case("sphere from 30 radii: distance", "ulp", 8.0, ALONG, naive_name=QUADRATIC, remark=AGAIN,
         **three(reached(PLAIN, *rays(PLAIN, 30, 0.9, 2)))),
    Case("sphere of 1e-4 from 1e3 radii: normal", "roundoffs of the way over the radius", 10.0,
         "what the distance has, across a surface seen at up to 64 degrees, and a rounding of each coordinate",
         naive_name=QUADRATIC, **three(turned(TINY, *rays(TINY, 1e3, 0.9, 2)))),
    Case("spheres of 1e-4 to 1e6, some far from the origin: points on them", "roundoffs of centre and radius", 5.0,
         "three roundings of the normal's length, one of each coordinate", naive_name=QUADRATIC,
         **three(settled(*((one, *rays(one, radii, 0.9, 2)) for one, radii in
                           ((TINY, 100), (PLAIN, 1.5), (PLAIN, 100), (HUGE, 0.1), (DISTANT, 100)))))),
    Case("quadratic, b^2 close to 4ac: both roots, grazing from 3 radii", "roundoffs of the way", 6.0,
         "one rounding of f, two of the radius, and half of what the distance has", naive_name=QUADRATIC,
         remark="it tells one root", **three(roots_off(PLAIN, *grazing(PLAIN, 3, 4)), textbook, both_roots, None)),
    Case("quadratic, b^2 close to 4ac: both roots, grazing from 1e3 radii", "roundoffs of the way", 6.0,
         "one rounding of f, two of the radius, and half of what the distance has", naive_name=QUADRATIC,
         remark="it tells one root", **three(roots_off(PLAIN, *grazing(PLAIN, 1e3, 4)), textbook, both_roots, None)),
    Case("quadratic, c close to 0: chords from a sphere's own points", "roundoffs of the way", 8.0, ALONG,
         naive_name="the first root beyond 0", remark="its rays start elsewhere, off the surface",
         **three(chord, ours=lambda *ray: ours(*ray, left_inwards=True), theirs=None)),
    Case("ground of radius 25.1 in a scene of size 1: where rays leave it", "roundoffs of centre and radius", 3.0,
         "one rounding of the normal's length, one of each coordinate",
         naive_name="an offset of 1e-4 along the normal",
         **three(leaving(GROUND, *over_ground()), moved_start, our_start, mitsuba_start)),
)
