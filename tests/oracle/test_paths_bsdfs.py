"""Each way of scattering by itself, path traced, against Mitsuba; and a parameter a little wrong on our side."""

import pytest

from tests.support.paths import Case, scene, times

pytestmark = pytest.mark.oracle

GREY = {"bsdf": {"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]}}
FLOOR = {"type": "rectangle", "center": [0, -0.9, 0], "u": [0, 0, 9], "v": [9, 0, 0], "material": GREY}
BLACKISH = [0.02, 0.02, 0.02]
DIM = [0.03, 0.03, 0.03]  # a sky before which highlights show
SKY = [0.5, 0.6, 0.7]
LAMP = {"type": "arealight", "position": [-1.2, 1.5, -2.0], "u": [1.5, 0, 1.2], "v": [0.5, 1.0, -0.6],
        "intensity": [4, 4, 4]}
GOLD = {"eta": [0.143, 0.375, 1.442], "k": [3.983, 2.386, 1.603]}
CLOSE = {"position": [0.2, 0.6, -2.9], "lookAt": [0.0, 0.0, 0.0]}


def ball(material, sky=SKY):
    """Return a scene that a ball of the material fills, over a floor, under a lamp and an even sky."""
    shape = {"type": "sphere", "center": [0, 0, 0], "radius": 0.85, "material": material}
    return scene(shape, FLOOR, lights=[LAMP], background=sky, camera=CLOSE, bounces=5)


def of(kind, key, value, samples=64, sky=SKY, **parameters):
    """Return the Case of a BSDF, one of whose parameters has another value on our side."""
    made = {"bsdf": {"type": kind, **parameters}}
    return Case(ball(made, sky), f"scene.shapes.0.material.bsdf.{key}", value, samples)


def coursework(key, value, samples=64, **parameters):
    """Return the Case of a coursework material."""
    base = {"kd": 0.6, "ks": 0.3, "specularexponent": 20.0, "diffusecolor": [0.7, 0.4, 0.3],
            "specularcolor": [0.9, 1.0, 0.8], **parameters}
    return Case(ball(base), f"scene.shapes.0.material.{key}", value, samples)


CASES = {
    "diffuse": of("diffuse", "reflectance", times(1.01), reflectance=[0.8, 0.5, 0.3]),
    "mirror": of("mirror", "reflectance", times(0.99), reflectance=[0.9, 0.8, 0.7]),
    "conductor": of("conductor", "k", times(1.02), **GOLD),
    "conductor_tinted": of("conductor", "reflectance", times(1.01), reflectance=[0.8, 0.9, 0.7]),
    "roughconductor": of("roughconductor", "reflectance", times(0.99), reflectance=[0.9, 0.8, 0.7], alpha=0.2, **GOLD),
    "roughconductor_alpha": of("roughconductor", "alpha", times(1.03), alpha=0.3, **GOLD),
    "roughconductor_beckmann": of("roughconductor", "alpha", times(1.05), 256, alpha=0.3, distribution="beckmann"),
    "roughconductor_distribution": of("roughconductor", "distribution", "beckmann", alpha=0.3),
    "roughconductor_narrow": of("roughconductor", "reflectance", times(0.99), alpha=0.01, reflectance=[0.9, 0.8, 0.7]),
    "roughconductor_wide": of("roughconductor", "alpha", times(0.97), alpha=1.0),
    "roughconductor_smooth": of("roughconductor", "reflectance", times(0.99), alpha=0.0, reflectance=[0.9, 0.8, 0.7]),
    "dielectric": of("dielectric", "ior", times(1.01), 256, ior=1.5),
    "dielectric_tinted": of("dielectric", "transmittance", times(0.99), 256, transmittance=[0.7, 0.9, 0.8],
                            reflectance=[0.8, 0.7, 0.9]),
    "dielectric_bubble": of("dielectric", "ior", times(1.01), 256, ior=0.75),
    "dielectric_same": of("dielectric", "ior", 1.01, ior=1.0),
    "dielectric_dense": of("dielectric", "ior", times(1.01), 256, ior=2.4),
    "roughdielectric": of("roughdielectric", "ior", times(1.01), 256, ior=1.5, alpha=0.2),
    "roughdielectric_alpha": of("roughdielectric", "alpha", times(1.04), 256, alpha=0.4),
    "roughdielectric_beckmann": of("roughdielectric", "alpha", times(1.04), 256, alpha=0.3, distribution="beckmann"),
    "roughdielectric_tinted": of("roughdielectric", "transmittance", times(0.99), 256, transmittance=[0.7, 0.9, 0.8],
                                 reflectance=[0.8, 0.7, 0.9], alpha=0.1),
    "roughdielectric_smooth": of("roughdielectric", "ior", times(1.01), 256, ior=1.5, alpha=0.0),
    "plastic": of("plastic", "reflectance", times(1.01), reflectance=[0.6, 0.3, 0.2]),
    "plastic_ior": of("plastic", "ior", times(1.02), 256, ior=1.7),
    "principled": of("principled", "basecolor", times(1.01), basecolor=[0.7, 0.4, 0.3]),
    "principled_roughness": of("principled", "roughness", times(1.05), 256, DIM, roughness=0.3, metallic=1.0),
    "principled_metallic": of("principled", "metallic", times(1.05), 256, metallic=0.6, roughness=0.4),
    "principled_specular": of("principled", "specular", times(1.05), 256, basecolor=BLACKISH, specular=0.8,
                             roughness=0.3),
    "principled_speculartint": of("principled", "speculartint", 0.9, speculartint=1.0, specular=1.0, roughness=0.4,
                                  basecolor=[0.9, 0.3, 0.2]),
    "principled_anisotropic": of("principled", "anisotropic", times(0.9), 256, anisotropic=0.9, metallic=1.0,
                                 roughness=0.5),
    "principled_sheen": of("principled", "sheen", times(0.9), 256, basecolor=BLACKISH, specular=0.0, sheen=1.0),
    "principled_sheentint": of("principled", "sheentint", 0.5, 256, basecolor=[0.05, 0.03, 0.02], specular=0.0,
                               sheen=1.0, sheentint=1.0),
    "principled_clearcoat": of("principled", "clearcoat", times(0.95), 256, basecolor=BLACKISH, specular=0.0,
                               clearcoat=1.0),
    "principled_clearcoatgloss": of("principled", "clearcoatgloss", 0.8, 256, DIM, clearcoat=1.0, clearcoatgloss=0.3,
                                    basecolor=BLACKISH, specular=0.0),
    "principled_all": of("principled", "basecolor", times(1.01), basecolor=[0.7, 0.4, 0.3], roughness=0.35,
                         metallic=0.3, specular=0.7, speculartint=0.4, anisotropic=0.5, sheen=0.6, sheentint=0.5,
                         clearcoat=0.8, clearcoatgloss=0.6),
    "coursework": coursework("kd", times(1.01)),
    "coursework_matt": coursework("diffusecolor", times(1.01), ks=0.0),
    "coursework_highlight": coursework("ks", times(1.02), ks=0.5, kd=0.2),
    "coursework_exponent": coursework("specularexponent", times(1.1), 256, ks=0.7, kd=0.1, specularexponent=60.0),
    "coursework_constant": coursework("ks", times(1.02), specularexponent=0.0, ks=0.3),
    "coursework_bright": coursework("ks", times(1.03), 256, kd=0.9, ks=0.8, diffusecolor=[0.9, 0.5, 0.4]),
    "coursework_mirror": coursework("reflectivity", times(1.02), 256, isreflective=True, reflectivity=0.6),
    "coursework_blurred": coursework("reflectivity", times(1.02), 256, isreflective=True, reflectivity=0.6,
                                     roughness=0.3),
    "coursework_roughness": coursework("roughness", times(1.03), isreflective=True, reflectivity=1.0, roughness=0.3),
    "coursework_glass": coursework("reflectivity", times(1.01), 256, isrefractive=True, refractiveindex=1.5,
                                   reflectivity=0.6),
    "coursework_pure_glass": coursework("refractiveindex", times(1.01), 256, isrefractive=True, refractiveindex=1.5),
}


@pytest.mark.parametrize("name", CASES)
def test_bsdf(judge, name):
    """Our picture has Mitsuba's expectation, and a material that is a little wrong does not."""
    judge.decide(CASES[name])
