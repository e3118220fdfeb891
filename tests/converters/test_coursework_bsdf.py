"""The plugin for the coursework's material is a BSDF: its samples have its density, and it makes no energy."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from mitsuba.chi2 import ChiSquareTest, SphericalDomain

from converters.mitsuba import as_dict  # noqa: F401 (chooses the variant)
from converters import coursework_bsdf

pytestmark = pytest.mark.oracle

ROUGH = {"type": "roughconductor", "material": "none", "alpha": 0.3, "distribution": "ggx"}
MIRROR = {"type": "conductor", "material": "none"}
GLASS = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
SETTINGS = {"plain": {}, "shiny": {"kd": 0.2, "ks": 0.8, "exponent": 100.0}, "constant": {"exponent": 0.0},
            "blurred": {"share": 0.4, "other": ROUGH}}
COUNT = 1_000_000


def made(**values):
    """Return the plugin's object."""
    parameters = {"kd": 0.6, "ks": 0.3, "exponent": 20.0, "share": 0.0, **values}
    return mi.load_dict({"type": "coursework", "diffusecolor": {"type": "rgb", "value": [0.7, 0.5, 0.3]},
                         "specularcolor": {"type": "rgb", "value": [0.9, 1.0, 0.8]}, **parameters})


def interaction(wi, count):
    """Return lanes of a point with the local direction `wi`."""
    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = mi.Vector3f(*wi) + dr.zeros(mi.Vector3f, count)
    si.wi = dr.normalize(si.wi)
    return si


def accepted(bsdf, wi, wrong=1.0):
    """Return whether samples have the density, which is raised to a power if it shall be `wrong`."""
    context = mi.BSDFContext()

    def sample(u):
        drawn, weight = bsdf.sample(context, interaction(wi, dr.width(u)), u.x, mi.Point2f(u.y, u.z))
        return drawn.wo, dr.select(dr.max(weight) > 0, 1.0, 0.0)

    def pdf(wo):
        return bsdf.pdf(context, interaction(wi, dr.width(wo)), wo) ** wrong

    return ChiSquareTest(SphericalDomain(), sample, pdf, sample_dim=3, sample_count=COUNT, res=101, ires=16).run(
        significance_level=0.01, test_count=8, quiet=True)


@pytest.mark.parametrize("wi", [(0.3, 0.1, 0.8), (0.7, -0.5, -0.4)])
@pytest.mark.parametrize("name", SETTINGS)
def test_samples_have_the_density(name, wi):
    """From both sides, by a chi-square test."""
    assert accepted(made(**SETTINGS[name]), wi)


def test_wrong_density_is_refused():
    """The test above sees a density raised to the power 1.03."""
    assert not accepted(made(), (0.3, 0.1, 0.8), wrong=1.03)


@pytest.mark.parametrize("name", SETTINGS)
def test_weight_is_value_over_density(name):
    """What `sample` returns is what `eval_pdf` returns for its direction."""
    bsdf, context, si = made(**SETTINGS[name]), mi.BSDFContext(), interaction((0.5, 0.2, 0.6), 10_000)
    rng = mi.PCG32(10_000)
    drawn, weight = bsdf.sample(context, si, rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32()))
    value, pdf = bsdf.eval_pdf(context, si, drawn.wo)
    assert np.allclose(np.array(drawn.pdf), np.array(pdf), rtol=1e-5)
    assert np.allclose(np.array(weight) * np.array(pdf), np.array(value), rtol=1e-4, atol=1e-6)


def albedo(bsdf, wi):
    """Return the mean weight of samples, and its standard error."""
    count = COUNT
    rng = mi.PCG32(count)
    _, weight = bsdf.sample(mi.BSDFContext(), interaction(wi, count), rng.next_float32(),
                            mi.Point2f(rng.next_float32(), rng.next_float32()))
    weight = np.array(weight)
    return weight.mean(axis=1), weight.std(axis=1) / np.sqrt(count)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_lambert_and_mirror_share_the_light(share):
    """Without the lobe, (1 - s) kd Cd + s comes back from a white furnace: nothing gets lost between the parts."""
    mixed = made(kd=0.5, ks=0.0, share=share, **({"other": MIRROR} if share else {}))
    mean, error = albedo(mixed, (0.4, 0.1, 0.8))
    assert (np.abs(mean - ((1 - share) * 0.5 * np.array([0.7, 0.5, 0.3]) + share)) < 4 * error + 1e-5).all()


def test_lobe_has_the_albedo_of_its_normalisation():
    """At normal incidence the lobe alone gives back ks Cs."""
    mean, error = albedo(made(kd=0.0, ks=0.5), (0, 0, 1))
    assert (np.abs(mean - 0.5 * np.array([0.9, 1.0, 0.8])) < 4 * error + 1e-5).all()


def test_bright_material_makes_no_energy():
    """kd and ks beyond what there is are brought down to it."""
    for wi in ((0, 0, 1), (0.6, 0, 0.3), (1, 0, 0.05)):
        mean, error = albedo(made(kd=2.0, ks=3.0), wi)
        assert (mean <= 1 + 4 * error).all()


def test_glass_is_seen_from_both_sides():
    """From inside, the glass share refracts outwards: radiance is scaled by the square of the index."""
    bsdf, count = made(kd=0.0, ks=0.0, share=1.0, other=GLASS), 100_000
    rng = mi.PCG32(count)
    for z, scale in ((1.0, 1 / 1.5**2), (-1.0, 1.5**2)):
        drawn, weight = bsdf.sample(mi.BSDFContext(), interaction((0, 0, z), count), rng.next_float32(),
                                    mi.Point2f(rng.next_float32(), rng.next_float32()))
        crossed = np.array(drawn.wo)[2] * z < 0
        assert crossed.mean() == pytest.approx(0.96, abs=0.005)
        assert np.allclose(np.array(weight)[0][crossed], scale, rtol=1e-4)


def test_plugin_is_registered():
    """Importing the module makes `coursework` known."""
    assert isinstance(made(), coursework_bsdf.Coursework)
