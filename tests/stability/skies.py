"""Images of the sky.

An image 4096 rows high has its first rows within 1e-3 radians of the pole, where an arc cosine of the height knows the
angle to 1e-4. Rows are told by an image whose texels hold the numbers of their rows, for directions down to 1e-6
radians from either pole. The density that comes with a chosen direction is held against the one told for that
direction, by both of which multiple importance sampling weighs; random numbers are 100,000 pairs, their ends among
them.
"""

import functools

import drjit as dr
import numpy as np

from renderer.core.backend import Vector2f, Vector3f
from renderer.lights.environment import Environment
from tests.stability.case import ULP, Case, mitsuba, relative

HEIGHT, WIDTH = 4096, 8
COUNT = 100_000


@functools.cache
def numbered():
    """Return the image (H, W, 3) of the numbers of its rows."""
    return np.broadcast_to(np.arange(HEIGHT, dtype=np.float32)[:, None, None], (HEIGHT, WIDTH, 3)).copy()


def directions():
    """Return unit directions (3, N) float32, most of them near a pole, and the exact rows that they lie at."""
    rng = np.random.default_rng(1)
    angle = np.concatenate([10.0 ** rng.uniform(-6, -1, COUNT // 2), rng.uniform(0, np.pi, COUNT // 2)])
    turn = rng.uniform(0, 2 * np.pi, COUNT)
    x, y, z = np.sin(angle) * np.cos(turn), np.cos(angle) * rng.choice([-1, 1], COUNT), np.sin(angle) * np.sin(turn)
    d = np.stack([x, y, z]).astype(np.float32)
    exact = d.astype(float)
    return d, np.arctan2(np.hypot(exact[0], exact[2]), exact[1]) / np.pi * (HEIGHT - 1)


def rows(seen):
    """Return a callable: errors of the rows that a function sees."""

    def measure():
        d, exact = directions()
        return seen(d) - exact

    return measure


def ours(d):
    """Return the renderer's rows."""
    return Environment(numbered(), (1.0, 1.0, 1.0), 0.0, sampled=False).radiance(Vector3f(*d))[0].x.numpy()


def naive(d):
    """Return the textbook's rows."""
    return np.arccos(np.clip(d[1], -1, 1)) * np.float32(1 / np.pi) * np.float32(HEIGHT - 1)


def mitsubas(d):
    """Return Mitsuba's rows."""
    mi = mitsuba()
    sky = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(numbered()), "scale": 1.0})
    si = dr.zeros(mi.SurfaceInteraction3f, d.shape[1])
    si.wi = -mi.Vector3f(*d)
    return sky.eval(si).x.numpy()


@functools.cache
def cloudy():
    """Return an image (64, 128, 3) of even noise."""
    return np.random.default_rng(2).uniform(0.5, 1.0, (64, 128, 1)).astype(np.float32).repeat(3, axis=2)


def pairs():
    """Return pairs of random numbers (2, N) float32: half of the second near the ends, some of the first at them."""
    rng = np.random.default_rng(3)
    u = rng.integers(0, 2**24, (2, COUNT)) / 2**24
    near = (10.0 ** rng.uniform(-7, -2, COUNT // 4) * 2**24).round() / 2**24
    u[1, : COUNT // 2] = np.concatenate([near, 1 - 2.0**-24 - near])
    u[0, :200] = rng.choice([0, 2.0**-24, 0.5, 1 - 2.0**-24], 200)
    return u.astype(np.float32)


def sky():
    """Return the renderer's Environment of the noise."""
    return Environment(cloudy(), (1.0, 1.0, 1.0), 0.0)


def densities(told):
    """Return a callable: relative differences of the densities (2, N) that a function tells."""

    def measure():
        chosen, looked_up = told()
        return relative(looked_up, chosen)

    return measure


def ours_told():
    """Return the densities that the renderer tells of directions it chose, and when it is asked for them."""
    environment = sky()
    found = environment.sample(Vector2f(pairs()))
    return found.pdf_sa.numpy(), environment.radiance(found.wo)[1].numpy()


def naive_told():
    """Return the renderer's, and the textbook's density for the same directions."""
    found = sky().sample(Vector2f(pairs()))
    d = found.wo.numpy()
    height, width = cloudy().shape[:2]
    sine = np.sin(np.pi / (height - 1) * np.clip(np.arange(height), 0.25, height - 1.25))
    weight = cloudy()[..., 0].astype(float) * sine[:, None]
    weight = np.concatenate([weight, weight[:, :1]], axis=1)
    patches = weight[1:] + weight[:-1]
    weight *= width * (height - 1) / (0.25 * (patches[:, 1:] + patches[:, :-1]).sum() * 2 * np.pi**2)
    x = np.arctan2(-d[0], -d[2]) * np.float32(0.5 / np.pi) * np.float32(width) - np.float32(0.5)
    x %= np.float32(width)
    y = np.arccos(d[1]) * np.float32((height - 1) / np.pi)
    column, row = np.minimum(x.astype(int), width - 1), np.minimum(y.astype(int), height - 2)
    x, y = x - column, y - row
    above, below = ((1 - x) * weight[row + k, column] + x * weight[row + k, column + 1] for k in (0, 1))
    with np.errstate(divide="ignore"):
        return found.pdf_sa.numpy(), ((1 - y) * above + y * below) / np.sqrt(1 - d[1] * d[1])


def mitsubas_told():
    """Return Mitsuba's densities, of directions that it chose."""
    mi = mitsuba()
    sky = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(cloudy()), "scale": 1.0})
    si = dr.zeros(mi.SurfaceInteraction3f, COUNT)
    ds, _ = sky.sample_direction(si, mi.Point2f(pairs()))
    return ds.pdf.numpy(), sky.pdf_direction(si, ds).numpy()


CASES = (
    Case("rows of an image of the sky", "rows", HEIGHT * (3e-7 + 3 * ULP),
         "the angle is good to 3e-7 of it, and pi, the product and the row itself are rounded", rows(ours), rows(naive),
         "arc cosine of the height", rows(mitsubas)),
    Case("densities told of directions in the sky", "relative", 1e-4,
         "measured x 2, next to the poles, where a rounding of the row is most of its sine", densities(ours_told),
         densities(naive_told), "arc cosine, and sqrt(1 - height^2)", densities(mitsubas_told)),
)  # fmt: skip
