"""Keys of materials: the coursework's Blinn-Phong material, and the BSDFs of path tracing by the field's names.

Sources of the models are given where lanes evaluate them, in `renderer/bsdfs`.
"""

from __future__ import annotations

from renderer.scene.composed import OneOf, Record, Texturable
from renderer.scene.nodes import Node, key, node
from renderer.scene.quantities import (
    COLOUR, FRACTION, LENGTH, NON_NEGATIVE, POSITIVE, REAL, REFLECTANCE, TEXTURABLE_FRACTION, TEXTURABLE_REFLECTANCE,
    TEXTURE, WHITE, Checkerboard, kind,
)
from renderer.scene.values import FILE_NAME, Choice, Flag, Optional, Vector

GREY = (0.5, 0.5, 0.5)
INDEX = Vector(3, NON_NEGATIVE, "an index [r, g, b]")
DISTRIBUTION = Choice("distribution", ("ggx", "beckmann"))


def alpha():
    """Return the declaration of a roughness."""
    return key(
        TEXTURABLE_FRACTION, "roughness: width of the distribution of normals, 0 for a smooth surface", default=0.1
    )


def distribution():
    """Return the declaration of a microfacet distribution."""
    return key(DISTRIBUTION, "distribution of normals", default="ggx")


def index():
    """Return the declaration of an index of refraction."""
    return key(POSITIVE, "index of refraction inside, relative to vacuum", default=1.5)


@node
class Diffuse(Node):
    """A Lambertian surface."""

    type: str = kind("diffuse")
    reflectance: object = key(TEXTURABLE_REFLECTANCE, "share of light that is reflected", default=GREY)


@node
class Mirror(Node):
    """A perfect mirror."""

    type: str = kind("mirror")
    reflectance: object = key(TEXTURABLE_REFLECTANCE, "share of light that is reflected", default=WHITE)


@node
class Conductor(Node):
    """A smooth metal, by the Fresnel equations of its complex index eta + i k; the defaults are those of copper."""

    type: str = kind("conductor")
    eta: tuple = key(INDEX, "real part of the index of refraction", default=(0.200, 0.924, 1.102))
    k: tuple = key(INDEX, "imaginary part", default=(3.912, 2.452, 2.142))
    reflectance: object = key(TEXTURABLE_REFLECTANCE, "factor of what is reflected", default=WHITE)


@node
class RoughConductor(Conductor):
    """A rough metal: a microfacet surface of `conductor`."""

    type: str = kind("roughconductor")
    alpha: object = alpha()
    distribution: str = distribution()


@node
class Dielectric(Node):
    """Smooth glass."""

    type: str = kind("dielectric")
    ior: float = index()
    reflectance: tuple = key(REFLECTANCE, "factor of what is reflected", default=WHITE)
    transmittance: tuple = key(REFLECTANCE, "factor of what is refracted", default=WHITE)


@node
class RoughDielectric(Dielectric):
    """Rough glass: a microfacet surface of `dielectric`, without light that is scattered twice on it."""

    type: str = kind("roughdielectric")
    alpha: object = alpha()
    distribution: str = distribution()


@node
class Plastic(Node):
    """A smooth dielectric coat over a Lambertian base."""

    type: str = kind("plastic")
    ior: float = index()
    reflectance: object = key(TEXTURABLE_REFLECTANCE, "reflectance of the base", default=GREY)


@node
class Principled(Node):
    """The artists' material of Burley (2012), without transmission."""

    type: str = kind("principled")
    basecolor: object = key(TEXTURABLE_REFLECTANCE, "colour of the base, or of the metal", default=(0.8, 0.8, 0.8))
    roughness: object = key(TEXTURABLE_FRACTION, "roughness; its square is the alpha of the highlight", default=0.5)
    metallic: object = key(TEXTURABLE_FRACTION, "0 for a dielectric, 1 for a metal", default=0.0)
    specular: float = key(FRACTION, "strength of the dielectric's highlight; 0.5 is an index of 1.5", default=0.5)
    speculartint: float = key(FRACTION, "share of the base's hue in that highlight", default=0.0)
    anisotropic: float = key(FRACTION, "how much the highlight is stretched along u", default=0.0)
    sheen: float = key(FRACTION, "light at grazing angles, as of cloth", default=0.0)
    sheentint: float = key(FRACTION, "share of the base's hue in it", default=0.0)
    clearcoat: float = key(FRACTION, "strength of a second, thin coat", default=0.0)
    clearcoatgloss: float = key(FRACTION, "how glossy that is", default=1.0)


BSDF_RECORDS = (Diffuse, Mirror, Conductor, RoughConductor, Dielectric, RoughDielectric, Plastic, Principled)
TEXTURABLE_KEYS = {
    made: [name for name, key in made.keys.items() if isinstance(key.kind, Texturable)] for made in BSDF_RECORDS
}
BSDF = OneOf("bsdf", {made.__name__.lower(): Record(made) for made in BSDF_RECORDS})


@node
class Material(Node):
    """The coursework's Blinn-Phong material, optionally textured; in mode `pathtracer` a `bsdf` can replace it."""

    ks: float = key(NON_NEGATIVE, "weight of the highlight", default=0.1)
    kd: float = key(NON_NEGATIVE, "weight of the diffuse term", default=0.9)
    specularexponent: float = key(NON_NEGATIVE, "exponent of the highlight; 0 gives a constant", default=20.0)
    diffusecolor: tuple = key(COLOUR, "diffuse colour, where there is no texture", default=(0.8, 0.8, 0.8))
    specularcolor: tuple = key(COLOUR, "colour of the highlight", default=WHITE)
    isreflective: bool = key(Flag(), "a mirror's share is mixed in, weighted by `reflectivity`", default=False)
    reflectivity: float = key(
        FRACTION, "share of mirror or glass; counts only with `isreflective` or `isrefractive`", default=1.0
    )
    isrefractive: bool = key(Flag(), "that share is glass: Fresnel reflection and refraction", default=False)
    refractiveindex: float = key(POSITIVE, "index of refraction inside, relative to vacuum", default=1.0)
    roughness: float = key(
        FRACTION, "blurs what a mirror (`isreflective`) shows: the alpha of a GGX distribution of its normals, 0 for "
        "none", default=0.0
    )
    texture: str | Checkerboard | None = key(
        TEXTURE, "image file (PPM, PNG or JPEG; relative to the scene file) or checkerboard: replaces `diffusecolor`",
        default=None,
    )
    texturefilter: str = key(
        Choice("texture filter", ("nearest", "bilinear")), "how texels are combined", default="bilinear"
    )
    texturewrap: str = key(
        Choice("texture wrap", ("repeat", "clamp")), "what lies outside 0 <= u, v <= 1", default="repeat"
    )
    scaleU: float = key(POSITIVE, "repetitions of the texture along u", default=1.0)
    scaleV: float = key(POSITIVE, "repetitions of the texture along v", default=1.0)
    bsdf: Node | None = key(
        Optional(BSDF), "how light is scattered in mode `pathtracer` (see BSDF): replaces all above but the "
        "four that place textures, which count for its own", default=None
    )
    normalmap: str | None = key(
        Optional(FILE_NAME), "image of normals 0.5 + 0.5 n in the frame of the texture coordinates, for mode "
        "`pathtracer`", default=None
    )
    bumpmap: str | None = key(
        Optional(FILE_NAME), "image of heights, 0 to 1 times `bumpscale`, for mode `pathtracer`", default=None
    )
    bumpscale: float = key(REAL, "height of white in `bumpmap`", default=1.0, unit=LENGTH)


MATERIAL = Record(Material, shared=True)
PLAIN = Material()


def textures_of(material, paths):
    """Return [(keys below the material, file name or Checkerboard)] of the textures that count in mode pathtracer, or
    in others (`paths`).
    """
    found = [(("texture",), material.texture)] if not paths or material.bsdf is None else [
        (("bsdf", name), getattr(material.bsdf, name)) for name in TEXTURABLE_KEYS[type(material.bsdf)]
    ]
    if paths:
        found += [((name,), getattr(material, name)) for name in ("normalmap", "bumpmap")]
    return [(path, source) for path, source in found if isinstance(source, (str, Checkerboard))]


def uses_uv(material, paths):
    """Return whether the texture coordinates of a shape count for how it looks; `paths`: mode pathtracer."""
    stretched = paths and getattr(material.bsdf, "anisotropic", 0) > 0
    return stretched or bool(textures_of(material, paths))
