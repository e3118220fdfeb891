"""What every BSDF kind must do, for all settings: weights, densities, energy, sides, degenerate directions."""

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import Float, Vector2f, Vector3f
from tests.bsdfs.settings import SETTINGS, SMOOTH, array, directions, each, numbers

COUNT = 100_000
BLACK = "coursework-black", "plastic-black"  # reflect nothing
GRID = 768  # directions each way in integrals over the sphere


def sampled(setting, wi, u, u2):
    """Return (wo, weight, pdf_sa, delta, eta) as arrays, evaluated in one kernel."""
    count = max(dr.width(wi), dr.width(u2))
    found = setting.sample(wi, u, u2)
    return [array(part, count) for part in (found.wo, found.weight, found.pdf_sa, found.delta, found.eta)]


def evaluated(setting, wi, wo):
    """Return (value, pdf_sa) as arrays."""
    count = max(dr.width(wi), dr.width(wo))
    return [array(part, count) for part in setting.evaluate(wi, wo)]


def both_sides(setting):
    """Return whether the setting takes directions from both sides."""
    return setting.kind.transmits


@each(SETTINGS)
def test_weight_is_value_over_density(setting):
    """What `sample` returns is what `evaluate` says of its direction; delta directions have no density."""
    wi, _ = directions(COUNT, 1, both_sides(setting))
    found = setting.sample(wi, *numbers(COUNT, 2))
    value, pdf_sa = setting.evaluate(wi, found.wo)
    wo, weight, pdf, delta = (array(part, COUNT) for part in (found.wo, found.weight, found.pdf_sa, found.delta))
    value, pdf_sa = array(value, COUNT), array(pdf_sa, COUNT)
    alive = weight.max(1) > 0
    if setting.name in BLACK:
        assert not weight.any() and not value.any()
        return
    assert alive.mean() > (0.3 if setting.smooth else 0.999)
    np.testing.assert_allclose(np.linalg.norm(wo[alive], axis=1), 1, atol=4e-6)
    assert not pdf[delta > 0].any()
    if not setting.smooth:
        assert (delta[alive] > 0).all() and not value.any() and not pdf_sa.any()
        return
    rough = alive & (delta == 0)
    np.testing.assert_allclose(weight[rough], value[rough] / pdf_sa[rough, None], rtol=1e-4, atol=1e-5)
    # wo is rounded, which moves the half vector by a few 1e-7 against the width of the lobe
    close = np.isclose(pdf[rough], pdf_sa[rough], rtol=1e-4 + 1e-5 / setting.width)
    assert close.mean() > 0.999


def grid():
    """Return directions over the whole sphere, at even polar angles, and the solid angle of each."""
    theta = (np.arange(GRID) + 0.5) / GRID * np.pi
    phi = (np.arange(GRID) + 0.5) / GRID * 2 * np.pi
    theta, phi = (part.ravel() for part in np.meshgrid(theta, phi, indexing="ij"))
    sin = np.sin(theta)
    w = np.stack([sin * np.cos(phi), sin * np.sin(phi), np.cos(theta)]).astype(np.float32)
    return Vector3f(*w), sin * 2 * (np.pi / GRID) ** 2


# Narrower lobes fall between the directions of the grid; at an index near 1 the refracted one is narrower than alpha.
WIDE = [setting for setting in SMOOTH if setting.width > 0.1 and setting.name != "roughdielectric-1.0"]
# Burley's material is not made to conserve energy: white it would reflect this much at grazing angles.
MADE_BY_PRINCIPLED = 1.25
INCIDENCES = (0.05, 0.4, 1.0)


def incident(cos, sign=1.0):
    """Return one direction of incidence."""
    sin = float(np.sqrt(1 - cos * cos))
    return Vector3f(0.6 * sin, 0.8 * sin, sign * cos)


@each(WIDE)
@pytest.mark.parametrize("cos", INCIDENCES)
def test_density_integrates_to_what_is_sampled(setting, cos):
    """The density integrates to the share of samples that do not fail and are not delta, and so never above 1."""
    wi = incident(cos)
    wo, solid_angle = grid()
    integral = evaluated(setting, wi, wo)[1] @ solid_angle
    _, _, pdf, _, _ = sampled(setting, wi, *numbers(COUNT, 3))
    # 3e-3: the fit of Beckmann's masking
    assert integral == pytest.approx((pdf > 0).mean(), abs=4 * 0.5 / COUNT**0.5 + 3e-3)
    assert integral < 1 + 3e-3


@each(SETTINGS)
@pytest.mark.parametrize("cos", INCIDENCES)
def test_no_energy_is_made(setting, cos):
    """The albedo is at most 1, of lossless settings it is 1; refraction counts without the change of radiance."""
    most = MADE_BY_PRINCIPLED if "principled" in setting.name else 1
    _, weight, _, _, eta = sampled(setting, incident(cos), *numbers(COUNT, 4))
    energy = weight * (eta**2)[:, None]
    mean, deviation = energy.mean(0), energy.std(0) / COUNT**0.5
    assert (mean < most + 4 * deviation + 3e-3).all()
    if setting.lossless:
        np.testing.assert_allclose(mean, 1, atol=(4 * deviation).max() + 2e-5)


@each([setting for setting in SMOOTH if "dielectric" not in setting.name])
def test_reciprocity(setting):
    """f(wi, wo) = f(wo, wi)."""
    wi, a = directions(COUNT, 5, False)
    wo, b = directions(COUNT, 6, False)
    there, back = evaluated(setting, wi, wo)[0] / b[:, 2:], evaluated(setting, wo, wi)[0] / a[:, 2:]
    np.testing.assert_allclose(there, back, rtol=2e-4, atol=1e-5 * there.mean())
    assert there.max() > 0 or setting.name in BLACK


@each([setting for setting in SMOOTH if "roughdielectric" not in setting.name])
def test_nothing_comes_through_what_reflects(setting):
    """Value and density are 0 where the two directions are on different sides, or both behind a one-sided frame."""
    wi, a = directions(COUNT, 7, True)
    wo, b = directions(COUNT, 8, True)
    value, pdf_sa = evaluated(setting, wi, wo)
    wrong = a[:, 2] * b[:, 2] <= 0 if both_sides(setting) else (a[:, 2] <= 0) | (b[:, 2] <= 0)
    assert not value[wrong].any() and not pdf_sa[wrong].any()
    assert pdf_sa[~wrong].any()


DEGENERATE = [(0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 1e-10), (-1, 0, 1e-10), (1, 0, 1e-20), (1, 0, 1e-38),
              (0.6, 0.8, 1e-6), (-0.6, -0.8, 1e-6), (1e-10, 0, 1), (1e-20, 1e-20, 1), (1e-4, 0, 1),
              (0.99999, 0, 0.00447), (0.7071068, 0, 0.7071068)]  # fmt: skip
NUMBERS = [0.0, 2**-32, 2**-24, 1e-4, 0.5, 0.25, 0.75, 1 - 2**-24]


@each(SETTINGS)
def test_degenerate_input_is_harmless(setting):
    """Grazing and upright directions, from both sides, and the least and greatest numbers bring finite results."""
    w = np.array(DEGENERATE + [(x, y, -z) for x, y, z in DEGENERATE], np.float32)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(len(w)), np.arange(len(w)), indexing="ij"))
    for part in evaluated(setting, Vector3f(*w[i].T), Vector3f(*w[j].T)):
        assert np.isfinite(part).all() and (part >= 0).all()
    u = np.array(NUMBERS, np.float32)
    i, a, b, c = (part.ravel().astype(np.float32) for part in np.meshgrid(np.arange(len(w)), u, u, u, indexing="ij"))
    wi = Vector3f(*w[i.astype(int)].T)
    wo, weight, pdf, delta, eta = sampled(setting, wi, Float(a), Vector2f(b, c))
    for part in (wo, weight, pdf, eta):
        assert np.isfinite(part).all()
    assert (weight >= 0).all() and (pdf >= 0).all() and (weight < 10).all()
    failed = weight.max(1) == 0
    np.testing.assert_allclose(np.linalg.norm(wo[~failed], axis=1), 1, atol=1e-5)


@each([setting for setting in SETTINGS if setting.kind.features is not None])
def test_features_of_others_change_nothing(setting):
    """The same instance, in a kernel with the code of all instances of its kind, gives the same."""
    others = [other for other in SETTINGS if other.kind is setting.kind]
    wi, _ = directions(COUNT, 9, both_sides(setting))
    wo, _ = directions(COUNT, 10, both_sides(setting))
    u, u2 = numbers(COUNT, 11)
    p, has = setting.lanes(others)
    mixed, alone = setting.kind.evaluate(p, wi, wo, has), setting.evaluate(wi, wo)
    for one, other in zip(mixed, alone):
        np.testing.assert_allclose(array(one, COUNT), array(other, COUNT), rtol=1e-4, atol=1e-6)
    mixed, alone = setting.kind.sample(p, wi, u, u2, has), setting.sample(wi, u, u2)
    same = [np.isclose(array(getattr(mixed, name), COUNT), array(getattr(alone, name), COUNT), rtol=5e-3, atol=1e-4)
            for name in ("weight", "delta", "eta")]  # fmt: skip
    assert all(part.mean() > 0.9995 for part in same)
