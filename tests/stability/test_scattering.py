"""What scattering must not do at the ends of its ranges: lose light, make it, or answer with infinity or NaN."""

import itertools

import numpy as np
import pytest

from renderer.core.fresnel import diffuse_reflectance
from renderer.scene.materials import (
    Conductor, Dielectric, Diffuse, Material, Mirror, Plastic, Principled, RoughConductor, RoughDielectric,
)
from tests.stability.case import ULP
from tests.stability.fresnel import exact
from tests.stability.highlights import LOBE
from tests.stability.refraction import (
    BOUNCES, INDICES, KEPT, MATCHED, RADII, beams, corridor, followed, mirrors, shells,
)
from tests.stability.rough import evaluated, sampled

WHITE = (1.0, 1.0, 1.0)
COUNT = 50_000
HEIGHTS = 1.0, 0.7, 0.1, 1e-3, 1e-5, 1e-7, 1e-12, 1e-20, 1e-30, 1e-38, 0.0  # cosines, of either sign
MOST = 2.5  # no weight is greater: of one lobe among three, at angles where Burley's material makes light
ENDS = np.float32([0, 2**-32, 2**-24, 1e-3, 0.5, 1 - 2**-12, 1 - 2**-24])
EXTREMES = {
    "metal": RoughConductor(alpha=1e-4), "metal of alpha 1": RoughConductor(alpha=1.0),
    "Beckmann's metal": RoughConductor(alpha=1e-4, distribution="beckmann"),
    "Beckmann's metal of alpha 1": RoughConductor(alpha=1.0, distribution="beckmann"),
    "glass": RoughDielectric(alpha=1e-4), "glass of index 1 + 1e-6": RoughDielectric(alpha=1e-4, ior=1 + 1e-6),
    "glass of index 1e4": RoughDielectric(alpha=0.5, ior=1e4),
    "glass of index 1e-4": RoughDielectric(alpha=0.5, ior=1e-4),
    "Beckmann's glass": RoughDielectric(alpha=1e-4, distribution="beckmann"),
    "coat": Principled(roughness=0.0, clearcoat=1.0),
    "brushed": Principled(metallic=1.0, anisotropic=1.0, roughness=0.1),
    "lobe": LOBE, "lobe over matt": Material(specularexponent=1e5, ks=0.5),
    "blurred": Material(isreflective=True, roughness=1e-4, reflectivity=0.5),
    "smooth metal": Conductor(), "smooth glass": Dielectric(ior=1 + 1e-6), "plastic": Plastic(ior=1 + 1e-6),
    "hard plastic": Plastic(ior=20.0),
}  # fmt: skip


def directions():
    """Return float32 directions (N, 3) of all HEIGHTS, above and below, at three azimuths."""
    found = [(np.sqrt((1 - z) * (1 + z)) * np.cos(phi), np.sqrt((1 - z) * (1 + z)) * np.sin(phi), sign * z)
             for z, sign, phi in itertools.product(HEIGHTS, (1, -1), (0.0, 0.7, np.pi))]  # fmt: skip
    return np.array(found, np.float32)


@pytest.mark.parametrize("name", EXTREMES)
def test_no_pair_of_directions_brings_infinity(name):
    """Values and densities of all pairs are finite, and none is negative."""
    w = directions()
    i, j = (part.ravel() for part in np.meshgrid(np.arange(len(w)), np.arange(len(w)), indexing="ij"))
    for answers in evaluated(EXTREMES[name], w[i], w[j]):
        assert np.isfinite(answers).all() and (answers >= 0).all()


@pytest.mark.parametrize("name", EXTREMES)
def test_no_number_brings_infinity(name):
    """Samples of all directions by the least and greatest numbers are finite; what counts has unit length."""
    w = directions()
    i, a, b, c = (part.ravel() for part in np.meshgrid(np.arange(len(w)), *[np.arange(len(ENDS))] * 3, indexing="ij"))
    wo, weight, pdf_sa = sampled(EXTREMES[name], w[i], ENDS[a], np.c_[ENDS[b], ENDS[c]])
    for answers in (wo, weight, pdf_sa):
        assert np.isfinite(answers).all()
    assert (weight >= 0).all() and (pdf_sa >= 0).all() and weight.max() < MOST * ior_of(EXTREMES[name]) ** 2
    np.testing.assert_allclose(np.linalg.norm(wo[weight > 0].astype(float), axis=1), 1,
                               atol=2e-6 * ior_of(EXTREMES[name]))


def ior_of(record):
    """Return by which index of refraction radiance may be scaled."""
    if getattr(record, "type", None) not in ("dielectric", "roughdielectric"):
        return 1.0
    return max(record.ior, 1 / record.ior)


@pytest.mark.parametrize("record", [Diffuse(reflectance=WHITE), Mirror(), Conductor(eta=(0, 0, 0), k=(1e4,) * 3)],
                         ids=lambda record: record.type)  # fmt: skip
def test_white_keeps_all_light(record):
    """Weights are 1, exactly, at all angles down to 1e-7."""
    draw = np.random.default_rng(91)
    z = 10 ** draw.uniform(-7, 0, COUNT)
    wi = np.c_[np.sqrt((1 - z) * (1 + z)), 0 * z, z].astype(np.float32)
    _, weight, _ = sampled(record, wi, draw.random(COUNT, np.float32), draw.random((COUNT, 2), np.float32))
    assert (weight == 1).all()


@pytest.mark.parametrize("eta", [1.0, 1 + 1e-9, 1.00009, 1.0001, 1.01, 1.5, 2.4, 20.0, 1e4])
def test_mean_reflectance_is_the_integral(eta):
    """Of Fresnel's factor over all directions, from outside; and from inside what energy leaves."""
    t, weight = np.polynomial.legendre.leggauss(2000)
    cos = ((t + 1) / 2) ** 2  # dense at grazing angles
    e = (eta - 1) * (eta + 1)
    g = np.sqrt(cos**2 + e)
    f = ((e / (cos + g) ** 2) ** 2 + (e * (eta**2 * cos**2 - 1 + cos**2) / (eta**2 * cos + g) ** 2) ** 2) / 2
    outer = 2 * cos * f @ (weight * (t + 1) / 2)
    np.testing.assert_allclose(diffuse_reflectance(eta), outer, atol=1e-7)
    np.testing.assert_allclose(1 - diffuse_reflectance(1 / eta), (1 - outer) / eta**2, atol=1e-7)


@pytest.mark.parametrize("mode", ["phong", "pathtracer"])
def test_mirrors_keep_their_share_for_a_hundred_bounces(mode):
    """0.99^100 within 100 roundings."""
    _, _, worth = followed(mirrors(mode), mode, *corridor(), BOUNCES)
    np.testing.assert_allclose(worth, float(np.float32(KEPT)) ** BOUNCES, rtol=BOUNCES * ULP)


@pytest.mark.parametrize("mode", ["phong", "pathtracer"])
def test_shells_of_index_one_lose_nothing(mode):
    """No reflection splits a ray, and its worth is 1, exactly."""
    _, _, worth = followed(shells(MATCHED, mode), mode, *beams(), 16)
    assert (worth == 1).all()


def test_paths_through_shells_of_glass_keep_their_radiance():
    """Each index that scales radiance on the way in is undone on the way out."""
    _, _, worth = followed(shells(INDICES, "pathtracer"), "pathtracer", *beams(), 16)
    np.testing.assert_allclose(worth, 1, rtol=32 * ULP)


def test_rays_through_the_middle_of_shells_lose_what_fresnel_says():
    """Mode phong: the product of 1 - F over 16 surfaces, at normal incidence."""
    _, _, worth = followed(shells(INDICES, "phong"), "phong", *beams(), 16)
    around = (1.0, *INDICES)
    ratios = np.array([around[k + 1] / around[k] for k in range(len(RADII))])
    passed = 1 - exact(np.ones(16, np.float32), np.concatenate([ratios, 1 / ratios]).astype(np.float32))[0]
    np.testing.assert_allclose(worth[:100], passed.prod(), rtol=64 * ULP)
