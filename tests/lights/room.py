"""Lights without a picture: the Lighting of a small scene, its geometry, and what is measured of them at one point."""

import math

import drjit as dr
import numpy as np
import pytest
from scipy import stats

from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.records import Ray
from renderer.scene.arrange import arrange
from renderer.scene.geometry import Geometry
from renderer.scene.lamps import with_lamps
from renderer.scene.light_sources import emitters_of
from renderer.scene.lighting import Lighting
from tests.support.scenes import loaded

SAMPLES = 2**20
CELLS = (12, 24)  # of directions, in height and longitude
SIGNIFICANCE = 1e-4  # of a right light to be refused


class Room:
    """The lights and shapes of a scene."""

    def __init__(self, folder, shapes=(), lights=(), **keys):
        keys = {"rendermode": "pathtracer", "backgroundcolor": [0, 0, 0]} | keys
        scene = with_lamps(loaded(folder, shapes, lights, **keys))
        ordered, geometry = arrange(scene, "auto")
        emitters = emitters_of(scene.description.scene, ordered, geometry["triangles"])
        self.lighting = Lighting.of(scene, ordered, geometry["triangles"], emitters)
        self.geometry = Geometry(**geometry)

    def sample(self, p, count=SAMPLES, seed=1):
        """Return a DirectSample in lanes for a point [x, y, z], or for points in lanes."""
        p = points(p, count)
        rng = np.random.default_rng(seed)
        u, x, y = (Float(rng.random(count, np.float32)) for _ in range(3))
        found = self.lighting.sample(p, u, Vector2f(x, y))
        zero = dr.zeros(Float, count)
        found.wo, found.radiance, found.pdf_sa = found.wo + zero, found.radiance + zero, found.pdf_sa + zero
        found.distance, found.delta = found.distance + zero, found.delta | (zero > 0)
        dr.eval(found)
        return found

    def seen(self, p, wo):
        """Return the radiance (3, N) that comes from directions in lanes, and the density of `sample` for them (N,)."""
        count = dr.width(wo)
        p = points(p, count)
        ray = Ray(p, wo)
        hit = self.geometry.intersect(ray)
        surface, shape = self.geometry.surface(ray, hit, False), self.geometry.shape_of(hit)
        radiance, pdf_sa = self.lighting.background(p, wo)
        if self.lighting.has_emitters:
            emitted, emitted_pdf_sa = self.lighting.emitted(p, wo, hit, shape, surface, hit.valid)
            radiance, pdf_sa = dr.select(hit.valid, emitted, radiance), dr.select(hit.valid, emitted_pdf_sa, pdf_sa)
        radiance, pdf_sa = radiance + dr.zeros(Vector3f, count), pdf_sa + dr.zeros(Float, count)
        return radiance.numpy().astype(float), pdf_sa.numpy().astype(float)

    def irradiance(self, p, n, count=SAMPLES):
        """Return mean and standard error (3,) of the irradiance at p of a surface with the normal n, by `sample`."""
        found = self.sample(p, count)
        cosine = np.maximum(np.asarray(n, float) @ found.wo.numpy(), 0)
        values = found.radiance.numpy() * (cosine / found.pdf_sa.numpy())
        return values.mean(axis=1), values.std(axis=1) / math.sqrt(count)


def points(p, count):
    """Return a point as `count` lanes; points in lanes as they are."""
    return p if isinstance(p, Vector3f) else Vector3f(*(dr.full(Float, x, count) for x in p))


def uniform_directions(count, seed=7):
    """Return directions spread evenly over the sphere."""
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(-1, 1, count), rng.uniform(0, 2 * math.pi, count)
    s = np.sqrt(1 - z**2)
    return Vector3f(*(Float(axis.astype(np.float32)) for axis in (s * np.cos(phi), s * np.sin(phi), z)))


def cell_of(w):
    """Return the number of the cell of directions that each lane's lies in."""
    x, y, z = w.numpy()
    rows, columns = CELLS
    row = np.minimum((z + 1) / 2 * rows, rows - 1).astype(int)
    column = ((np.arctan2(y, x) / (2 * math.pi) % 1) * columns).astype(int) % columns
    return row * columns + column


def p_value(wo, pdf_sa, even, shines):
    """Return how likely directions `wo` with the densities pdf_sa (N,) are what they claim: a chi-square test.

    Within each cell the mean of 1 / density is the solid angle from which light comes, and so is 4 pi times the share
    of even directions for which it `shines` (M,).
    """
    count, cells = len(pdf_sa), CELLS[0] * CELLS[1]
    own = _sums(cell_of(wo), 1 / pdf_sa, cells, count)
    other = _sums(cell_of(even), 4 * math.pi * shines, cells, len(shines))
    used = (own[1] > 0) & (other[1] > 0) & (np.bincount(cell_of(even), shines, cells) > 50)
    z2 = (own[0] - other[0])[used] ** 2 / (own[1] + other[1])[used]
    assert used.sum() > 0
    return stats.chi2.sf(z2.sum(), used.sum())


def _sums(cell, values, cells, count):
    """Return for each cell the mean of values over all directions, and the variance of that mean."""
    mean = np.bincount(cell, values, cells) / count
    return mean, (np.bincount(cell, values**2, cells) / count - mean**2) / count


def environment_file(folder, pixels, **keys):
    """Write (H, W, 3) linear colours as an EXR, and return the light that names it."""
    OpenEXR = pytest.importorskip("OpenEXR")
    channels = {name: np.ascontiguousarray(pixels[..., k], np.float32) for k, name in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(folder / "sky.exr"))
    return {"type": "environment", "filename": "sky.exr"} | keys
