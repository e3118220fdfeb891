"""Samples against densities by Pearson's chi-square test, for all settings whose lobes its histogram can resolve."""

import drjit as dr
import pytest

from renderer.core.backend import Float, Vector2f, Vector3f
from tests.bsdfs.settings import SMOOTH, Setting, each

mi = pytest.importorskip("mitsuba")

SIGNIFICANCE = 0.01  # of all tests together
# Cells of the histogram along z, odd so that no sample is rounded over an edge at the horizon; nodes of the quadrature
# in a cell: narrow lobes, and the cells that the horizon cuts, take many.
CELLS, NODES, FINE = 101, 64, 256
RESOLVED = [setting for setting in SMOOTH if setting.width >= 0.05 and setting.name != "roughdielectric-1.0"]
INCIDENCES = {"upright": (0.0, 0.0, 1.0), "tilted": (0.48, -0.64, 0.6), "grazing": (-0.6, 0.7806, 0.1749)}
POLAR_WIDTH = 0.2  # at the poles cells are wide in angle
TESTS = len(RESOLVED) * len(INCIDENCES)
MANY, FEW = 10_000_000, 1_000_000  # samples; 3 % of a density are noticed by FEW, 1 % by MANY


def accepted(setting, wi, count, nodes=NODES):
    """Return whether the samples of a setting may have its density."""
    from mitsuba.chi2 import ChiSquareTest, SphericalDomain

    mi.set_variant("llvm_ad_rgb")
    wi = Vector3f(*wi)

    def sample(u):
        u = [Float(dr.detach(part)) for part in u]
        found = setting.sample(wi, u[0], Vector2f(u[1], u[2]))
        wo = found.wo + dr.zeros(Vector3f, dr.width(u))
        return mi.Vector3f(*map(mi.Float, wo)), mi.Float(dr.select(found.pdf_sa > 0, Float(1), 0))

    def density(wo):
        _, pdf_sa = setting.evaluate(wi, Vector3f(*(Float(dr.detach(part)) for part in wo)))
        return mi.Float(pdf_sa + dr.zeros(Float, dr.width(wo)))

    test = ChiSquareTest(SphericalDomain(), sample, density, sample_dim=3, sample_count=count, res=CELLS, ires=nodes)
    return test.run(significance_level=SIGNIFICANCE, test_count=TESTS, quiet=True)


@each(RESOLVED)
def test_samples_have_their_density(setting):
    """Directions of a tilted incidence come with the density that `evaluate` tells."""
    assert accepted(setting, INCIDENCES["tilted"], FEW)


@pytest.mark.slow
@each(RESOLVED)
@pytest.mark.parametrize("incidence", INCIDENCES)
def test_many_samples_have_their_density(setting, incidence):
    """The same with more samples, also at upright and grazing incidence; the fit of Beckmann's masking allows FEW."""
    if incidence == "upright" and setting.width <= POLAR_WIDTH:
        pytest.skip("the lobe is narrower than a cell around the pole")
    assert accepted(setting, INCIDENCES[incidence], FEW if "beckmann" in setting.name else MANY, FINE)


@pytest.mark.slow
@each([setting for setting in RESOLVED if setting.kind.transmits])
def test_samples_from_inside_have_their_density(setting):
    """The same for directions of incidence behind the surface, where a kind tells the sides apart."""
    assert accepted(setting, (0.48, -0.64, -0.6), FEW, FINE)


class Inflated(Setting):
    """A deliberately wrong density: 3 % too great."""

    def evaluate(self, wi, wo):
        value, pdf_sa = super().evaluate(wi, wo)
        return value, pdf_sa * 1.03


class Widened(Setting):
    """A deliberately wrong density: that of a neighbouring instance."""

    other: object

    def evaluate(self, wi, wo):
        return self.other.evaluate(wi, wo)


def named(name):
    """Return a setting."""
    return next(setting for setting in SMOOTH if setting.name == name)


@pytest.mark.parametrize("name", ["diffuse", "roughconductor-ggx-0.3", "principled-all", "coursework-matt-and-lobe"])
def test_inflated_density_is_rejected(name):
    """A density that is 3 % too great is noticed by the number of samples that the fast tests take."""
    setting = named(name)
    assert not accepted(Inflated(setting.name, setting.record, None), INCIDENCES["tilted"], FEW)


def test_wrong_exponent_is_rejected():
    """A lobe of exponent 20 does not pass for one of 22, nor an alpha of 0.3 for one of 0.31."""
    from renderer.scene import materials as keys

    lobe = [Setting("lobe", keys.Material(kd=0.0, ks=1.0, specularexponent=float(e)), None) for e in (20, 22)]
    metal = [Setting("metal", keys.RoughConductor(alpha=alpha), None) for alpha in (0.3, 0.31)]
    for right, other in (lobe, metal):
        wrong = Widened(right.name, right.record, None)
        object.__setattr__(wrong, "other", other)
        assert accepted(right, INCIDENCES["tilted"], FEW)
        assert not accepted(wrong, INCIDENCES["tilted"], FEW)
