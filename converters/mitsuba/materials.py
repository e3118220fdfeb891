"""Materials and textures for stock Mitsuba: the nearest counterpart of each, with a remark where it is not exact."""

from __future__ import annotations

import numpy as np

from converters.mitsuba import srgb
from converters.mitsuba.nodes import Colour, Node, Pixels
from converters.solids import OWN_UV

MIRROR_ROUGHNESS = 0.005  # blends of delta lobes lose energy in Mitsuba; a lobe this narrow still looks like a mirror
PLASTIC_INDEX = 1.5
BINARY_RED = Colour((1.0, 0.0, 0.0))

HIGHLIGHT = "Blinn-Phong highlight written as rough plastic of about the same width"
MIXED_MIRROR = "mirror share written as a very smooth rough conductor blended in"
MIXED_GLASS = "glass share written as a very smooth rough dielectric blended in"
TOO_BRIGHT = "reflects more than it receives; clipped to 1"
BAKED = "kd multiplied into the texture's 8-bit values"


def share(material):
    """Return the share of mirror or glass, 0 to 1; reflectivity counts only with one of the two switches."""
    return material.reflectivity if material.isreflective or material.isrefractive else 0.0


def _limited(values, remark):
    """Return the values clipped to 1, with a remark where that changed them."""
    if max(values) > 1:
        remark(TOO_BRIGHT)
    return Colour(min(float(v), 1.0) for v in values)


def to_uv(material, uv_map):
    """Return the 3 x 3 matrix from a primitive's texture coordinates to the texture's."""
    return np.diag([material.scaleU, material.scaleV, 1.0]) @ uv_map


def texture(material, pixels, uv_map=OWN_UV, factor=1.0, remark=lambda text: None, encoded=False):
    """Return the diffuse colour times `factor`: a colour, or a texture node for coordinates mapped by `uv_map`.

    `pixels` is the image file's content where the material names one; `encoded` values are decoded from sRGB.
    """
    if material.texture is None:
        return _limited([factor * c for c in material.diffusecolor], remark)
    placed = to_uv(material, uv_map)
    if not isinstance(material.texture, str):
        board = material.texture
        # Mitsuba's checkerboard has two squares for each unit of uv.
        half = np.diag([board.scale / 2, board.scale / 2, 1.0])
        colours = [_limited([factor * c for c in v], remark) for v in (board.color1, board.color2)]
        return Node("texture", "checkerboard", {"color0": colours[0], "color1": colours[1], "to_uv": half @ placed})
    if factor != 1.0:
        remark(BAKED)
        texels = np.frombuffer(pixels.rgb, np.uint8) / 255
        texels = srgb.encoded(srgb.decoded(texels) * factor) if encoded else texels * factor
        scaled = np.clip(np.rint(255 * texels), 0, 255).astype(np.uint8)
        pixels = Pixels(pixels.name, pixels.width, pixels.height, scaled.tobytes())
    return Node("texture", "bitmap", {"pixels": pixels, "raw": not encoded, "filter_type": material.texturefilter,
                                      "wrap_mode": material.texturewrap, "to_uv": placed})


def two_sided(bsdf):
    """Return the node lit from both sides, as every opaque surface of the scene format is."""
    return Node("bsdf", "twosided", {"bsdf": bsdf})


def matt(colour):
    """Return a two-sided diffuse surface of the colour or texture."""
    return two_sided(Node("bsdf", "diffuse", {"reflectance": colour}))


def _local(material, pixels, uv_map, remark, encoded):
    """Return the one-sided counterpart of the Blinn-Phong part."""
    base = texture(material, pixels, uv_map, material.kd, remark, encoded)
    highlight = [material.ks * c for c in material.specularcolor]
    if max(highlight) == 0:
        return Node("bsdf", "diffuse", {"reflectance": base})
    remark(HIGHLIGHT)
    roughness = float(np.sqrt(2 / (material.specularexponent + 2)))
    return Node("bsdf", "roughplastic", {
        "diffuse_reflectance": base, "specular_reflectance": _limited(highlight, remark), "alpha": roughness,
        "int_ior": PLASTIC_INDEX, "ext_ior": 1.0})


def phong(material, outside, pixels, uv_map, remark, encoded=False):
    """Return the nearest stock counterpart of a coursework material whose surroundings have index `outside`.

    `encoded` textures are decoded from sRGB.
    """
    mixed = share(material)
    if mixed == 0:
        return two_sided(_local(material, pixels, uv_map, remark, encoded))
    if material.isrefractive:
        return _glass(material, outside, pixels, uv_map, remark, encoded)
    mirror = {"material": "none"}
    if mixed == 1:
        return two_sided(Node("bsdf", "conductor", mirror))
    remark(MIXED_MIRROR)
    rough = Node("bsdf", "roughconductor", {**mirror, "alpha": MIRROR_ROUGHNESS})
    local = _local(material, pixels, uv_map, remark, encoded)
    return two_sided(Node("bsdf", "blendbsdf", {"weight": mixed, "first": local, "second": rough}))


def _glass(material, outside, pixels, uv_map, remark, encoded):
    """Return the node of glass, or of a share of it in a local material."""
    mixed, inside = share(material), float(material.refractiveindex)
    indices = {"int_ior": inside, "ext_ior": float(outside)}
    if mixed == 1:
        return Node("bsdf", "null") if inside == outside else Node("bsdf", "dielectric", indices)
    remark(MIXED_GLASS)
    local = two_sided(_local(material, pixels, uv_map, remark, encoded))
    if inside == outside:
        return Node("bsdf", "mask", {"opacity": 1 - mixed, "bsdf": local})
    rough = Node("bsdf", "roughdielectric", {**indices, "alpha": MIRROR_ROUGHNESS})
    return Node("bsdf", "blendbsdf", {"weight": mixed, "first": local, "second": rough})
