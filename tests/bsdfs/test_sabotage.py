"""The contract tests bite: each rejects a kind that is wrong in just what it looks at."""

from dataclasses import replace

import drjit as dr
import pytest

from renderer.core.backend import Vector3f
from tests.bsdfs import test_contract as contract
from tests.bsdfs.settings import SETTINGS, Setting


class Wrong(Setting):
    """A setting whose answers are changed by two functions."""

    of_sample = staticmethod(lambda found: found)
    of_evaluate = staticmethod(lambda value, pdf_sa, wi, wo: (value, pdf_sa))

    def sample(self, wi, u, u2):
        return self.of_sample(super().sample(wi, u, u2))

    def evaluate(self, wi, wo):
        return self.of_evaluate(*super().evaluate(wi, wo), wi, wo)


def wrong(name, sample=None, evaluate=None):
    """Return a setting with wrong answers."""
    setting = next(setting for setting in SETTINGS if setting.name == name)
    made = type("Made", (Wrong,), {
        **({"of_sample": staticmethod(sample)} if sample else {}),
        **({"of_evaluate": staticmethod(evaluate)} if evaluate else {}),
    })  # fmt: skip
    return made(setting.name, setting.record, setting.mitsuba, setting.lossless)


def weighted(factor):
    """Return a change of a sample's weight."""
    def change(found):
        return replace(found, weight=found.weight * factor)
    return change


def test_wrong_weight_is_rejected():
    """A weight 1 % too small."""
    with pytest.raises(AssertionError):
        contract.test_weight_is_value_over_density(wrong("roughconductor-ggx-0.3", weighted(0.99)))


def test_wrong_density_is_rejected():
    """A density 3 % too small."""
    found = wrong("roughconductor-ggx-0.3", evaluate=lambda value, pdf_sa, wi, wo: (value, pdf_sa * 0.97))
    with pytest.raises(AssertionError):
        contract.test_weight_is_value_over_density(found)
    with pytest.raises(AssertionError):
        contract.test_density_integrates_to_what_is_sampled(found, 0.9)


@pytest.mark.parametrize("name, factor", [
    ("mirror", 1.01), ("mirror", 0.99), ("dielectric-1.5", 0.99), ("diffuse-white", 1.02),
])
def test_energy_is_watched(name, factor):
    """Light made, and light lost by what is lossless."""
    with pytest.raises(AssertionError):
        contract.test_no_energy_is_made(wrong(name, weighted(factor)), 0.4)


def test_change_of_radiance_is_watched():
    """Refraction that forgets the inverse square of the index."""
    def forget(found):
        return replace(found, weight=found.weight * dr.square(found.eta))
    with pytest.raises(AssertionError):
        contract.test_no_energy_is_made(wrong("dielectric-1.5", forget), 0.4)


def test_asymmetry_is_rejected():
    """A value that favours one of the two directions by 1 %."""
    def favour(value, pdf_sa, wi, wo):
        return value * (1 + 0.01 * wi.z), pdf_sa
    found = wrong("coursework-matt-and-lobe", evaluate=favour)
    with pytest.raises(AssertionError):
        contract.test_reciprocity(found)


def test_light_through_the_surface_is_rejected():
    """A value behind the surface."""
    found = wrong("plastic-1.5", evaluate=lambda value, pdf_sa, wi, wo: (value + 1e-3, pdf_sa))
    with pytest.raises(AssertionError):
        contract.test_nothing_comes_through_what_reflects(found)


def test_infinity_is_rejected():
    """A division by the cosine."""
    found = wrong("diffuse", evaluate=lambda value, pdf_sa, wi, wo: (value / wo.z, pdf_sa))
    with pytest.raises(AssertionError):
        contract.test_degenerate_input_is_harmless(found)


def test_long_direction_is_rejected():
    """A direction that is not unit."""
    def stretch(found):
        return replace(found, wo=Vector3f(found.wo) * 1.001)
    with pytest.raises(AssertionError):
        contract.test_weight_is_value_over_density(wrong("plastic-1.5", stretch))
