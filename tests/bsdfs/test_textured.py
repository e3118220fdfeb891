"""Parameters that arrive in lanes, as from textures, bring what the same constants bring."""

from dataclasses import replace

import numpy as np
import pytest

from renderer.core.backend import Float, Vector3f
from tests.bsdfs.settings import SETTINGS, Setting, array, directions, numbers

COUNT = 20_000
FILE = "texture.png"
SMOOTH_BY_ZERO = [setting.name for setting in SETTINGS if getattr(setting.record, "alpha", None) == 0]
CASES = [(setting, key) for setting in SETTINGS for key in setting.kind.textured or ()
         if not (key == "alpha" and setting.name in SMOOTH_BY_ZERO)]  # fmt: skip


class Laid:
    """A record with a column, or three, replaced by lanes."""

    def __init__(self, row, column, values):
        self._row, self._values = row, dict(enumerate(values, start=column))

    def __getitem__(self, column):
        return self._values[column] if column in self._values else self._row[column]

    def vector(self, column):
        return Vector3f(*(self[column + k] for k in range(3)))


def textured(setting, key):
    """Return the setting with a texture for a parameter, its row with that parameter's value in lanes, and features."""
    value = setting.record.diffusecolor if key == "texture" else getattr(setting.record, key)
    made = Setting(setting.name, replace(setting.record, **{key: FILE}), None)
    column, width = setting.kind.textured[key]
    values = value if width == 3 else (value,)
    row, has = made.lanes()
    return made, Laid(row, column, [Float(np.full(COUNT, part, np.float32)) for part in values]), has


@pytest.mark.parametrize("setting, key", CASES, ids=[f"{setting.name}-{key}" for setting, key in CASES])
def test_texture_of_one_value_is_that_value(setting, key):
    """The value of the BSDF is the constant's, and weights are the value over the density."""
    wi, _ = directions(COUNT, 41, False)
    wo, _ = directions(COUNT, 42, False)
    made, p, has = textured(setting, key)
    assert made.smooth == setting.smooth
    value, _ = made.kind.evaluate(p, wi, wo, has)
    np.testing.assert_allclose(array(value, COUNT), array(setting.evaluate(wi, wo)[0], COUNT), rtol=2e-4, atol=1e-6)
    found = made.kind.sample(p, wi, *numbers(COUNT, 43), has)
    value, pdf_sa = (array(part, COUNT) for part in made.kind.evaluate(p, wi, found.wo, has))
    weight, delta = array(found.weight, COUNT), array(found.delta, COUNT)
    rough = (weight.max(1) > 0) & (delta == 0)
    np.testing.assert_allclose(weight[rough], value[rough] / pdf_sa[rough, None], rtol=2e-4, atol=1e-5)
    constant = setting.sample(wi, *numbers(COUNT, 43))
    if not setting.smooth:
        np.testing.assert_allclose(weight, array(constant.weight, COUNT), rtol=1e-5, atol=1e-7)


def test_bright_texels_are_limited():
    """A texel that would make energy is dimmed as the same constant colour is, and a dark one beside it is not."""
    from renderer.scene import materials as keys

    for colour, other in ((1.0, 0.2), (0.2, 1.0)):
        made = keys.Material(kd=1.0, ks=0.5, diffusecolor=(colour,) * 3)
        setting = Setting("coursework", made, None)
        wi, _ = directions(COUNT, 44, False)
        wo, _ = directions(COUNT, 45, False)
        _, p, has = textured(setting, "texture")
        assert "limited" in has
        value = array(setting.kind.evaluate(p, wi, wo, has)[0], COUNT)
        np.testing.assert_allclose(value, array(setting.evaluate(wi, wo)[0], COUNT), rtol=2e-4, atol=1e-6)


@pytest.mark.parametrize("kind, key", [
    ("RoughConductor", "alpha"), ("RoughDielectric", "alpha"), ("Principled", "roughness"),
])
def test_black_roughness_is_narrow_but_not_smooth(kind, key):
    """A texel of roughness 0 gives the narrowest lobe that there is, with finite numbers."""
    from renderer.scene import materials as keys

    setting = Setting("narrow", getattr(keys, kind)(**{key: FILE}), None)
    wi, _ = directions(COUNT, 46, False)
    p, has = setting.lanes()
    found = setting.kind.sample(Laid(p, setting.kind.textured[key][0], [Float(0)]), wi, *numbers(COUNT, 47), has)
    for part in (found.wo, found.weight, found.pdf_sa):
        assert np.isfinite(array(part, COUNT)).all()
    alive = array(found.pdf_sa, COUNT) > 0
    assert alive.mean() > 0.9 and not array(found.delta, COUNT).any()
