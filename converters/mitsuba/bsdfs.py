"""Materials of mode `pathtracer` as Mitsuba's plugins.

All parameters are written: nothing relies on Mitsuba's defaults. Reflecting kinds are wrapped in `twosided`.
Where only a plugin of our own is exact (`converters.coursework_bsdf`), `exact` decides between it and the nearest
stock counterpart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from converters.mitsuba import materials, srgb
from converters.mitsuba.nodes import Colour, Node, Pixels
from renderer.io.image import read_texture
from renderer.scene.schema import Material

NUMBERS = ("alpha", "roughness", "metallic", "bumpmap")  # parameters of which a texture's red is taken
TRANSMITTING = ("dielectric", "roughdielectric")
AS_IT_IS = {"flip_invalid_normals": False, "use_shadowing_function": False}  # ours does neither


@dataclass(frozen=True)
class Surface:
    """One primitive's material and what is needed to write it."""

    loaded: object
    number: int  # of the shape in the file
    material: Material
    outside: float  # index of refraction around the shape
    uv_map: np.ndarray | None  # (3, 3): the primitive's texture coordinates to ours
    remark: Callable
    exact: bool

    def image(self, filename, key):
        """Return the content of an image file that a key of the material names."""
        width, height, rgb = read_texture(self.loaded.resolve(filename))
        if key in NUMBERS:  # these are red; Mitsuba takes the luminance
            rgb = np.repeat(np.frombuffer(rgb, np.uint8)[::3], 3).tobytes()
        return Pixels(f"shape{self.number}_{key}", width, height, rgb)

    def bitmap(self, pixels, raw, texture_filter=None):
        """Return the texture of an image, placed as the material says; not `raw`: decoded from sRGB."""
        m = self.material
        return Node("texture", "bitmap", {
            "pixels": pixels, "raw": raw, "filter_type": texture_filter or m.texturefilter, "wrap_mode": m.texturewrap,
            "to_uv": materials.to_uv(m, self.uv_map)})

    def value(self, value, key):
        """Return a parameter: a float, a Colour or the texture that the value names."""
        if isinstance(value, str):
            return self.bitmap(self.image(value, key), raw=key in NUMBERS)
        if isinstance(value, tuple):
            return Colour(map(float, value))
        if isinstance(value, (int, float)):
            return float(value)
        colours = [Colour(map(float, v)) for v in (value.color1, value.color2)]
        if key in NUMBERS:
            colours.reverse()  # Mitsuba exchanges the two where a number is asked for
        half = np.diag([value.scale / 2, value.scale / 2, 1.0])  # its board has two squares for each unit of uv
        return Node("texture", "checkerboard", {"color0": colours[0], "color1": colours[1],
                                                "to_uv": half @ materials.to_uv(self.material, self.uv_map)})


def textures(material):
    """Return the keys of a material in mode `pathtracer` that textures stand for."""
    of_bsdf = vars(material.bsdf).items() if material.bsdf else [("texture", material.texture)]
    maps = [(key, getattr(material, key)) for key in ("normalmap", "bumpmap")]
    return [key for key, value in (*of_bsdf, *maps) if key != "type" and key != "distribution"
            and value is not None and not isinstance(value, (bool, int, float, tuple))]


def evened(surface):
    """Return the surface with the means of its textures in their place, for primitives without texture coordinates."""
    material, of_bsdf = surface.material, {}
    for key in textures(material):
        if material.bsdf is not None and key in vars(material.bsdf):
            mean = _mean(surface, getattr(material.bsdf, key), key)
            of_bsdf[key] = float(mean[0]) if key in NUMBERS else tuple(map(float, mean))
    changes = {"normalmap": None, "bumpmap": None}
    if material.bsdf is not None:
        changes["bsdf"] = replace(material.bsdf, **of_bsdf)
    elif material.texture is not None:
        mean = _mean(surface, material.texture, "texture")
        changes |= {"texture": None, "diffusecolor": tuple(map(float, mean))}
    return replace(surface, material=replace(material, **changes))


def _mean(surface, texture, key):
    """Return the mean colour of a texture, (3,); of the red channel where a number is asked for."""
    if not isinstance(texture, str):
        return (np.array(texture.color1) + texture.color2) / 2
    values = np.frombuffer(surface.image(texture, key).rgb, np.uint8).reshape(-1, 3) / 255
    return (values if key in NUMBERS else srgb.decoded(values)).mean(axis=0)


def bsdf(surface):
    """Return the node of a primitive's material."""
    material = surface.material
    made, transmits = _plain(surface) if material.bsdf else _coursework(surface)
    if material.bumpmap is not None:
        made = Node("bsdf", "bumpmap", {
            "texture": surface.bitmap(surface.image(material.bumpmap, "bumpmap"), True, "bilinear"), "bsdf": made,
            "scale": float(material.bumpscale), **AS_IT_IS})
    if material.normalmap is not None:
        made = Node("bsdf", "normalmap", {"normalmap": surface.bitmap(_normals(surface), raw=True), "bsdf": made,
                                          **AS_IT_IS})
    return made if transmits else materials.two_sided(made)


def _normals(surface):
    """Return the normal map for the primitive's own tangents, which may point elsewhere than ours.

    A frame is a tangent along u and its cross product with the normal; ours is turned against the primitive's.
    """
    image = surface.image(surface.material.normalmap, "normalmap")
    a, b = np.sign(np.rint(np.linalg.inv(np.asarray(surface.uv_map)[:2, :2])[:, 0] * 1e6))  # our tangent in theirs
    x, y, z = np.frombuffer(image.rgb, np.uint8).reshape(-1, 3).T / 255 - np.array([[0.5], [0.5], [0.0]])
    texels = np.stack([a * x - b * y + 0.5, b * x + a * y + 0.5, z], axis=1)
    return Pixels(image.name, image.width, image.height, np.uint8(np.rint(255 * texels)).tobytes())


def _plain(surface):
    """Return the node of a BSDF record, and whether it transmits."""
    record = surface.material.bsdf
    made = _KINDS[record.type](surface, record)
    return made, record.type in TRANSMITTING


def _diffuse(surface, record):
    """Return the node of a matt BSDF."""
    return Node("bsdf", "diffuse", {"reflectance": surface.value(record.reflectance, "reflectance")})


def _mirror(surface, record):
    """Return the node of a mirror of one reflectance."""
    return Node("bsdf", "conductor", {
        "material": "none", "specular_reflectance": surface.value(record.reflectance, "reflectance")})


def _metal(surface, record):
    """Return the parameters that smooth and rough metals share."""
    return {"eta": Colour(map(float, record.eta)), "k": Colour(map(float, record.k)),
            "specular_reflectance": surface.value(record.reflectance, "reflectance")}


def _conductor(surface, record):
    """Return the node of a smooth metal."""
    return Node("bsdf", "conductor", _metal(surface, record))


def _rough(surface, record):
    """Return the parameters of a microfacet distribution."""
    return {"alpha": surface.value(record.alpha, "alpha"), "distribution": record.distribution, "sample_visible": True}


def _roughconductor(surface, record):
    """Return the node of a rough metal; of alpha 0, which Mitsuba refuses, of a smooth one."""
    if record.alpha == 0:
        return _conductor(surface, record)
    return Node("bsdf", "roughconductor", {**_metal(surface, record), **_rough(surface, record)})


def _glass(surface, record):
    """Return the parameters that smooth and rough glass share."""
    return {"int_ior": float(record.ior), "ext_ior": float(surface.outside),
            "specular_reflectance": surface.value(record.reflectance, "reflectance"),
            "specular_transmittance": surface.value(record.transmittance, "transmittance")}


def _dielectric(surface, record):
    """Return the node of smooth glass."""
    return Node("bsdf", "dielectric", _glass(surface, record))


def _roughdielectric(surface, record):
    """Return the node of rough glass, or of smooth glass where that is the same."""
    if record.alpha == 0 or record.ior == surface.outside:  # Mitsuba refuses equal indices in the rough one
        return _dielectric(surface, record)
    return Node("bsdf", "roughdielectric", {**_glass(surface, record), **_rough(surface, record)})


def plastic_share(eta):
    """Return by how much the base's reflectance must be multiplied for Mitsuba, whose coat reflects by fits.

    Of eta, the index of the coat relative to the outside, it takes the fit of [Egan1973] or, below 1, of [DEon2011] for
    the mean reflectance from inside. The true one is an integral; 1 is returned where the fit leaves nothing.
    """
    if eta > 1:
        fit = -1.4399 / eta**2 + 0.7099 / eta + 0.6681 + 0.0636 * eta
    else:
        fit = 0.919317 - 3.4793 * eta + 6.75335 * eta**2 - 7.80989 * eta**3 + 4.98554 * eta**4 - 1.36881 * eta**5
    cos, weight = np.polynomial.legendre.leggauss(256)
    cos = (cos + 1) / 2  # outside, where light may go at all angles
    g = np.sqrt(np.maximum(cos**2 + eta**2 - 1, 0))
    reflected = (((cos - g) / (cos + g)) ** 2 + ((eta**2 * cos - g) / (eta**2 * cos + g)) ** 2) / 2
    passed = (1 - reflected) * cos @ weight  # both ways, but for eta^2
    return (1 - fit) * eta**2 / passed if fit < 1 and passed > 0 else 1.0


def _plastic(surface, record):
    """Return the node of a coat over a matt base."""
    reflectance = surface.value(record.reflectance, "reflectance")
    if isinstance(reflectance, Colour):  # textures are left as they are: 0.1 % too bright at index 1.5
        share = plastic_share(record.ior / surface.outside)
        reflectance = Colour(share * part for part in reflectance)
    return Node("bsdf", "plastic", {
        "diffuse_reflectance": reflectance, "int_ior": float(record.ior),
        "ext_ior": float(surface.outside), "nonlinear": False, "specular_reflectance": Colour((1.0, 1.0, 1.0))})


def _principled(surface, record):
    """Return the node of Burley's material, without what transmits."""
    value = surface.value
    return Node("bsdf", "principled", {
        "base_color": value(record.basecolor, "basecolor"), "roughness": value(record.roughness, "roughness"),
        "metallic": value(record.metallic, "metallic"), "specular": float(record.specular),
        "spec_tint": float(record.speculartint), "anisotropic": float(record.anisotropic),
        "sheen": float(record.sheen), "sheen_tint": float(record.sheentint), "clearcoat": float(record.clearcoat),
        "clearcoat_gloss": float(record.clearcoatgloss), "spec_trans": 0.0, "flatness": 0.0})


_KINDS = {"diffuse": _diffuse, "mirror": _mirror, "conductor": _conductor, "roughconductor": _roughconductor,
          "dielectric": _dielectric, "roughdielectric": _roughdielectric, "plastic": _plastic,
          "principled": _principled}


def _coursework(surface):
    """Return the node of the coursework's own material, and whether it transmits."""
    material = surface.material
    share, colour = materials.share(material), _diffuse_colour(surface)
    other = _other(surface) if share > 0 else None
    glass = share > 0 and material.isrefractive
    if share == 1:
        return other, glass
    limit = max(1.0, material.kd * max(material.diffusecolor) + material.ks * max(material.specularcolor))
    lambertian = share == 0 and material.ks * max(material.specularcolor) == 0
    if lambertian and (isinstance(colour, Colour) or material.kd == 1):
        scaled = Colour(material.kd * c / limit for c in colour) if isinstance(colour, Colour) else colour
        return Node("bsdf", "diffuse", {"reflectance": scaled}), False
    if not surface.exact:
        return _stock(surface), glass
    return Node("bsdf", "coursework", {
        "diffusecolor": colour, "specularcolor": Colour(map(float, material.specularcolor)), "kd": float(material.kd),
        "ks": float(material.ks), "exponent": float(material.specularexponent), "share": float(share),
        **({"other": other} if other else {})}), True  # it is two-sided by itself


def _diffuse_colour(surface):
    """Return the diffuse colour or the texture in its place."""
    material = surface.material
    return surface.value(material.diffusecolor if material.texture is None else material.texture, "reflectance")


def _other(surface):
    """Return the mirror or glass of a coursework material."""
    material, white = surface.material, Colour((1.0, 1.0, 1.0))
    if material.isrefractive:
        return Node("bsdf", "dielectric", {
            "int_ior": float(material.refractiveindex), "ext_ior": float(surface.outside),
            "specular_reflectance": white, "specular_transmittance": white})
    mirror = {"material": "none", "specular_reflectance": white}
    if material.roughness == 0:
        return Node("bsdf", "conductor", mirror)
    return Node("bsdf", "roughconductor", {**mirror, "alpha": float(material.roughness), "distribution": "ggx",
                                           "sample_visible": True})


def _stock(surface):
    """Return the nearest stock counterpart of a mixed material; told in a remark."""
    material = surface.material
    pixels = surface.image(material.texture, "texture") if isinstance(material.texture, str) else None
    made = materials.phong(material, surface.outside, pixels, surface.uv_map, surface.remark, encoded=True)
    return made.values["bsdf"] if made.type == "twosided" else made
