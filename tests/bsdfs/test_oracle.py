"""Values, densities and samples against Mitsuba's, kind by kind (level 1: single BSDFs, no pictures)."""

import importlib

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import Vector3f
from tests.bsdfs.settings import SETTINGS, array, directions, each, numbers

mi = pytest.importorskip("mitsuba")
pytestmark = pytest.mark.oracle

COUNT = 100_000
KNOWN = [setting for setting in SETTINGS if setting.mitsuba is not None]
# Both round differences of directions, near critical angles and against narrow lobes: few pairs are further off.
RTOL, SHARE = 2e-4, 0.997


@pytest.fixture(scope="module", autouse=True)
def variant():
    """Mitsuba in the arithmetic that the renderer has, with the plugin of the coursework's material."""
    mi.set_variant("llvm_ad_rgb")
    importlib.import_module("converters.coursework_bsdf")


def interaction(wi):
    """Return Mitsuba's surface interaction at z = normal."""
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi = mi.Vector3f(*(mi.Float(part) for part in np.ascontiguousarray(wi.T.astype(np.float32))))
    si.sh_frame.n = mi.Normal3f(0, 0, 1)
    si.sh_frame.s, si.sh_frame.t = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    return si


def close_to(ours, theirs, rtol):
    """Return whether numbers agree, relative to their greatest component, or are negligible beside all."""
    theirs = theirs.reshape(ours.shape)
    scale = np.maximum(abs(theirs), abs(ours))
    return abs(ours - theirs) <= rtol * scale + 1e-6 * np.median(theirs[theirs > 0]) if theirs.any() else ours == 0


def tolerance(setting):
    """Return the relative tolerance: half vectors are rounded by 1e-7, a multiple of which counts over the width."""
    return RTOL + 3e-6 / setting.width


@each(KNOWN)
def test_value_and_density_agree(setting):
    """Value and density are Mitsuba's at random pairs of directions, half of them around the mirror direction."""
    wi, a = directions(COUNT, 21, setting.kind.transmits)
    wo, b = directions(COUNT, 22, setting.kind.transmits)
    found = setting.sample(wi, *numbers(COUNT, 23))
    b[::2] = array(found.wo, COUNT)[::2]
    wo = Vector3f(*np.ascontiguousarray(b.T.astype(np.float32)))
    value, pdf_sa = (array(part, COUNT) for part in setting.evaluate(wi, wo))
    bsdf, si = two_sided(setting), interaction(a)
    theirs, their_pdf = bsdf.eval_pdf(mi.BSDFContext(), si, mi.Vector3f(*(mi.Float(part) for part in wo.numpy())))
    theirs, their_pdf = np.asarray(theirs.numpy(), float).T, np.asarray(their_pdf.numpy(), float)
    if theirs.shape != value.shape or their_pdf.shape != pdf_sa.shape:  # literals
        theirs, their_pdf = np.broadcast_to(theirs, value.shape), np.broadcast_to(their_pdf, pdf_sa.shape)
    assert close_to(value, theirs, tolerance(setting)).mean() > SHARE
    if same_density(setting):
        assert close_to(pdf_sa, their_pdf, tolerance(setting)).mean() > SHARE
    assert value.any() == setting.smooth == bool(theirs.any())


def same_density(setting):
    """Return whether the plugin picks its lobes as ours does.

    The one of the coursework's material does not, nor that of plastic, whose base is given another reflectance.
    """
    return setting.mitsuba["type"] not in ("coursework", "plastic")


def two_sided(setting):
    """Return the loaded plugin."""
    as_it_is = setting.mitsuba["type"].endswith("dielectric") or setting.mitsuba["type"] == "coursework"
    return mi.load_dict(setting.mitsuba if as_it_is else {"type": "twosided", "bsdf": setting.mitsuba})


@each(KNOWN)
@pytest.mark.parametrize("cos", [0.2, 0.7, -0.5])
def test_samples_have_the_same_mean(setting, cos):
    """Weights, directions and changes of index have Mitsuba's means, from either side of what transmits."""
    if cos < 0 and not setting.kind.transmits:
        pytest.skip("one-sided by contract: the caller turns the frame")
    sin = (1 - cos * cos) ** 0.5
    w = np.broadcast_to(np.array([0.6 * sin, 0.8 * sin, cos]), (COUNT, 3))
    u, u2 = numbers(COUNT, 24)
    found = setting.sample(Vector3f(*np.ascontiguousarray(w.T.astype(np.float32))), u, u2)
    ours = moments(array(found.weight, COUNT), array(found.wo, COUNT), array(found.eta, COUNT))
    u, u2 = numbers(COUNT, 25)
    u, u2 = mi.Float(u.numpy()), mi.Point2f(u2.numpy())
    bs, weight = two_sided(setting).sample(mi.BSDFContext(), interaction(w), u, u2)
    theirs = moments(*(np.broadcast_to(np.asarray(part.numpy(), float).T, shape) for part, shape in
                       ((weight, (COUNT, 3)), (bs.wo, (COUNT, 3)), (bs.eta, (COUNT,)))))  # fmt: skip
    error = np.sqrt((ours[1] + theirs[1]) / COUNT)
    z = abs(ours[0] - theirs[0]) / (error + 1e-5 + 1e-4 * abs(theirs[0]))
    assert z[:CARRIED if not same_density(setting) else None].max() < 5, (ours[0], theirs[0])


CARRIED = 12  # moments of what samples carry; then those that depend on how directions are picked


def moments(weight, wo, eta):
    """Return mean and variance of what samples carry; eta of failed ones is of no account."""
    alive = (weight.max(1) > 0)[:, None]
    carried = np.concatenate([weight, *(weight * wo[:, k:k + 1] for k in range(3)), alive, eta[:, None] * alive], 1)
    return carried.mean(0), carried.var(0)
