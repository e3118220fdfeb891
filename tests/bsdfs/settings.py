"""Settings of all BSDF kinds, ordinary and extreme, with Mitsuba's counterparts, and lanes that ask them."""

from dataclasses import dataclass

import drjit as dr
import numpy as np
import pytest

from converters.mitsuba.bsdfs import plastic_share
from renderer.bsdfs import KINDS
from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.rows import Rows
from renderer.scene import materials as keys

GOLD = {"eta": (0.143, 0.375, 1.442), "k": (3.983, 2.386, 1.603)}
WHITE = (1.0, 1.0, 1.0)
GREEN = (0.2, 0.7, 0.3)


@dataclass(frozen=True)
class Setting:
    """One instance: its kind, the record of the scene file, and the plugin that Mitsuba has for it (None for none)."""

    name: str
    record: object
    mitsuba: dict | None
    lossless: bool = False  # whether it reflects or transmits all light

    @property
    def kind(self):
        """The BsdfKind."""
        return KINDS[getattr(self.record, "type", "coursework")]

    @property
    def smooth(self):
        """Whether it has more than delta parts."""
        return self.kind.smooth(self.record)

    @property
    def width(self):
        """The width of the narrowest lobe that is not delta, in slopes: against it half vectors are rounded."""
        if self.record.__class__ is keys.Principled:
            coat = 0.1 - 0.099 * self.record.clearcoatgloss if self.record.clearcoat else 1.0
            return min(max(1e-3, self.record.roughness**2), coat)
        return getattr(self.record, "alpha", 1.0) or 1.0

    def lanes(self, also=()):
        """Return (p, has) of the instance, in a kernel that has the features of the settings `also` too."""
        has = frozenset(name for setting in (self, *also) for name in setting.kind.features(setting.record))
        return Rows([self.kind.pack(self.record, 1.0)])[0], has

    def sample(self, wi, u, u2):
        """Return the BsdfSample."""
        p, has = self.lanes()
        return self.kind.sample(p, wi, u, u2, has)

    def evaluate(self, wi, wo):
        """Return (value, pdf_sa)."""
        p, has = self.lanes()
        return self.kind.evaluate(p, wi, wo, has)


def rgb(colour):
    """Return Mitsuba's node of a colour."""
    return {"type": "rgb", "value": list(colour)}


def metal(terms):
    """Return Mitsuba's parameters of a metal."""
    return {"eta": rgb(terms["eta"]), "k": rgb(terms["k"])}


def glass(ior):
    """Return Mitsuba's parameters of glass in vacuum."""
    return {"int_ior": ior, "ext_ior": 1.0}


def diffuse():
    """Yield settings of `diffuse`."""
    yield Setting("diffuse", keys.Diffuse(reflectance=GREEN), {"type": "diffuse", "reflectance": rgb(GREEN)})
    white = {"type": "diffuse", "reflectance": rgb(WHITE)}
    yield Setting("diffuse-white", keys.Diffuse(reflectance=WHITE), white, True)


def mirrors():
    """Yield settings of `mirror` and `conductor`."""
    none = {"type": "conductor", "material": "none"}
    yield Setting("mirror", keys.Mirror(), none, True)
    yield Setting("mirror-green", keys.Mirror(reflectance=GREEN), {**none, "specular_reflectance": rgb(GREEN)})
    yield Setting("conductor", keys.Conductor(**GOLD, reflectance=GREEN),
                  {"type": "conductor", **metal(GOLD), "specular_reflectance": rgb(GREEN)})


def rough_metals():
    """Yield settings of `roughconductor`."""
    for distribution in ("ggx", "beckmann"):
        for alpha in (1e-3, 0.05, 0.3, 1.0):
            yield Setting(
                f"roughconductor-{distribution}-{alpha}",
                keys.RoughConductor(**GOLD, alpha=alpha, distribution=distribution),
                {"type": "roughconductor", **metal(GOLD), "alpha": alpha, "distribution": distribution},
            )
    yield Setting("roughconductor-0", keys.RoughConductor(**GOLD, alpha=0.0), {"type": "conductor", **metal(GOLD)})


def dielectrics():
    """Yield settings of `dielectric`."""
    for ior in (1.5, 1 / 1.5, 2.4, 1.0):
        yield Setting(f"dielectric-{ior:.3g}", keys.Dielectric(ior=ior), {"type": "dielectric", **glass(ior)}, True)
    tints = {"specular_reflectance": rgb(GREEN), "specular_transmittance": rgb((0.9, 0.5, 0.4))}
    yield Setting("dielectric-tinted", keys.Dielectric(reflectance=GREEN, transmittance=(0.9, 0.5, 0.4)),
                  {"type": "dielectric", **glass(1.5), **tints})


def rough_dielectrics():
    """Yield settings of `roughdielectric`."""
    for distribution, alpha, ior in (("ggx", 1e-3, 1.5), ("ggx", 0.05, 1.5), ("ggx", 0.3, 1 / 1.5), ("ggx", 1.0, 2.4),
                                     ("beckmann", 0.05, 1.5), ("beckmann", 0.4, 2.4), ("beckmann", 1.0, 1.5)):
        yield Setting(
            f"roughdielectric-{distribution}-{alpha}-{ior:.3g}",
            keys.RoughDielectric(alpha=alpha, ior=ior, distribution=distribution),
            {"type": "roughdielectric", **glass(ior), "alpha": alpha, "distribution": distribution},
        )
    yield Setting("roughdielectric-0", keys.RoughDielectric(alpha=0.0), {"type": "dielectric", **glass(1.5)}, True)
    yield Setting("roughdielectric-1.0", keys.RoughDielectric(alpha=0.3, ior=1.0), None)
    tints = {"specular_reflectance": rgb(GREEN), "specular_transmittance": rgb((0.9, 0.5, 0.4))}
    yield Setting(
        "roughdielectric-tinted",
        keys.RoughDielectric(alpha=0.2, reflectance=GREEN, transmittance=(0.9, 0.5, 0.4)),
        {"type": "roughdielectric", **glass(1.5), "alpha": 0.2, "distribution": "ggx", **tints},
    )


def plastics():
    """Yield settings of `plastic`."""
    for ior in (1.5, 2.4, 1.0, 1 / 1.5):
        scaled = rgb([plastic_share(ior) * part for part in GREEN])
        yield Setting(f"plastic-{ior:.3g}", keys.Plastic(ior=ior, reflectance=GREEN),
                      {"type": "plastic", **glass(ior), "diffuse_reflectance": scaled, "nonlinear": False})
    yield Setting("plastic-black", keys.Plastic(reflectance=(0.0, 0.0, 0.0), ior=1.0), None)
    yield Setting("plastic-white", keys.Plastic(reflectance=WHITE), None)


PRINCIPLED = {
    "plain": {}, "rough": {"roughness": 1.0}, "narrow": {"roughness": 0.1},
    "mirror-like": {"roughness": 0.0, "metallic": 1.0},
    "metal": {"metallic": 1.0, "roughness": 0.4}, "half-metal": {"metallic": 0.5}, "tinted": {"speculartint": 0.7},
    "dull": {"specular": 0.0}, "shiny": {"specular": 1.0}, "sheen": {"sheen": 0.8},
    "sheen-tint": {"sheen": 1.0, "sheentint": 0.6},
    "brushed": {"anisotropic": 0.8, "roughness": 0.4, "metallic": 0.7},
    "coated": {"clearcoat": 1.0, "clearcoatgloss": 0.2},
    "glossy-coat": {"clearcoat": 0.5, "clearcoatgloss": 0.9, "roughness": 0.8},
    "all": {"metallic": 0.3, "roughness": 0.35, "speculartint": 0.5, "anisotropic": 0.5, "sheen": 0.5, "sheentint": 0.5,
            "clearcoat": 0.7, "clearcoatgloss": 0.0, "specular": 0.8},
}  # fmt: skip
PLUGIN_KEYS = {"speculartint": "spec_tint", "sheentint": "sheen_tint", "clearcoatgloss": "clearcoat_gloss"}


def principled():
    """Yield settings of `principled`."""
    for name, given in PRINCIPLED.items():
        record = keys.Principled(basecolor=GREEN, **given)
        theirs = {PLUGIN_KEYS.get(key, key): getattr(record, key) for key in record.keys if key != "type"}
        del theirs["basecolor"]
        yield Setting(f"principled-{name}", record, {"type": "principled", "base_color": rgb(GREEN), **theirs})


def plugin(material):
    """Return the converters' plugin of a coursework material, with the nested one of its share."""
    made = {"type": "coursework", "diffusecolor": rgb(material.diffusecolor),
            "specularcolor": rgb(material.specularcolor), "kd": material.kd, "ks": material.ks,
            "exponent": material.specularexponent, "share": 0.0}  # fmt: skip
    if material.isrefractive:
        other = {"type": "dielectric", **glass(material.refractiveindex)}
        return made | {"share": material.reflectivity, "other": other}
    if material.isreflective and material.reflectivity > 0:
        mirror = {"type": "conductor", "material": "none"}
        if material.roughness > 0:
            mirror |= {"type": "roughconductor", "alpha": material.roughness, "distribution": "ggx"}
        return made | {"share": material.reflectivity, "other": mirror}
    return made


def coursework():
    """Yield settings of the coursework's own material."""
    def mixed(name, **given):
        material = keys.Material(**given)
        return Setting(f"coursework-{name}", material, plugin(material))

    yield mixed("matt-and-lobe", kd=0.6, ks=0.3, diffusecolor=GREEN)
    yield mixed("weak-lobe")
    yield mixed("coloured-lobe", kd=0.3, ks=0.5, specularcolor=GREEN, specularexponent=60.0)
    yield mixed("matt", ks=0.0, kd=1.0, diffusecolor=GREEN)
    for exponent in (0.0, 1.0, 200.0):
        yield mixed(f"lobe-{exponent:.0f}", kd=0.0, ks=1.0, specularexponent=exponent)
    yield mixed("bright", kd=1.0, ks=1.0, diffusecolor=(1.0, 0.7, 0.5))
    yield Setting("coursework-dazzling", keys.Material(kd=1.0, ks=1.0, diffusecolor=(2.0, 1.0, 0.5)), None)
    yield mixed("mirror", isreflective=True, reflectivity=0.4)
    yield mixed("blurred", isreflective=True, reflectivity=0.4, roughness=0.2)
    yield mixed("blurred-strong", isreflective=True, reflectivity=0.4, roughness=0.2, kd=0.2, ks=0.5)
    yield mixed("all-blurred", isreflective=True, roughness=0.3)
    yield mixed("glass", isrefractive=True, reflectivity=0.7, refractiveindex=1.5)
    yield mixed("no-share", isreflective=True, reflectivity=0.0, roughness=0.3)
    none = {"type": "conductor", "material": "none"}
    yield Setting("coursework-all-mirror", keys.Material(isreflective=True), none, True)
    record = keys.Material(isrefractive=True, refractiveindex=1.5)
    yield Setting("coursework-all-glass", record, {"type": "dielectric", **glass(1.5)}, True)
    yield Setting("coursework-black", keys.Material(kd=0.0, ks=0.0), None)


SETTINGS = [*diffuse(), *mirrors(), *rough_metals(), *dielectrics(), *rough_dielectrics(), *plastics(), *principled(),
            *coursework()]  # fmt: skip
SMOOTH = [setting for setting in SETTINGS if setting.smooth]


def each(settings):
    """Return a parametrization by settings."""
    return pytest.mark.parametrize("setting", settings, ids=[setting.name for setting in settings])


def directions(count, seed, both_sides):
    """Return unit directions, uniform over the sphere or the upper half, as lanes and (count, 3) float64."""
    w = np.random.default_rng(seed).normal(size=(count, 3))
    if not both_sides:
        w[:, 2] = abs(w[:, 2])
    w = (w / np.linalg.norm(w, axis=1, keepdims=True)).astype(np.float32)
    return Vector3f(*np.ascontiguousarray(w.T)), w.astype(np.float64)


def numbers(count, seed):
    """Return random numbers u and u2 in lanes."""
    u = np.random.default_rng(seed).random((3, count), np.float32)
    return Float(u[0]), Vector2f(u[1:])


def array(lanes, count):
    """Return lanes of any width as a float64 array, (count,) or (count, 3)."""
    full = lanes + dr.zeros(type(lanes), count) if not dr.is_mask_v(lanes) else lanes | dr.zeros(type(lanes), count)
    found = np.asarray(full.numpy(), np.float64)
    return found.T if found.ndim == 2 else found
