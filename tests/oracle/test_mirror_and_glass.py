"""Reflection and refraction, both branches, to the last bounce, against the exact counterpart in Mitsuba."""

import pytest

from tests.support.documents import GLASS, GROUND, MIRROR, SHAPES, scene, shape

pytestmark = pytest.mark.oracle

RGB = ("rgb",)
# A smooth room around everything: glass magnifies rounding, and each edge seen through it would cost pixels.
BACK = {"type": "sphere", "center": [0.3, 0.2, 0.1], "radius": 8.0, "material": {"texture": "texture.png", "ks": 0.0}}


def sphere(centre, radius, material):
    """Return a sphere's document."""
    return {"type": "sphere", "center": centre, "radius": radius, "material": material}


@pytest.mark.parametrize("name", SHAPES)
def test_reflection_in_shape(agree, name):
    """Every shape is a mirror of the right shape, mixed in by reflectivity."""
    agree(scene(shape(name, MIRROR), sphere([-1.3, 0.1, -0.6], 0.5, {"diffusecolor": [0.2, 0.5, 0.9]}), BACK), RGB)


@pytest.mark.parametrize("nbounces", [0, 1, 2, 3, 8])
def test_reflection_bounces(agree, nbounces):
    """Two facing mirrors show each other as often as nbounces allows, then the background."""
    left, right = sphere([-0.8, 0.1, 0], 0.7, MIRROR), sphere([0.85, 0.1, 0.2], 0.7, {**MIRROR, "reflectivity": 1.0})
    agree(scene(left, right, GROUND, nbounces=nbounces), RGB)


def test_reflectivity_counts_only_when_switched_on(agree):
    """A matt shape with reflectivity 1, as in the originals, stays matt."""
    agree(scene(shape("sphere", {**MIRROR, "isreflective": False, "reflectivity": 1.0}), GROUND), RGB)


@pytest.mark.parametrize("name", SHAPES)
def test_refraction_in_shape(agree, name):
    """Every shape as glass splits light by Fresnel and bends it by Snell, in and out."""
    agree(scene(shape(name, GLASS), BACK), RGB)


@pytest.mark.parametrize("nbounces", [0, 1, 2, 3, 6])
def test_refraction_bounces(agree, nbounces):
    """Both branches are followed to nbounces."""
    agree(scene(shape("sphere", {**GLASS, "reflectivity": 1.0}), GROUND, BACK, nbounces=nbounces), RGB)


@pytest.mark.parametrize("index", [0.8, 1.0, 1.33, 2.4])
def test_refraction_index(agree, index):
    """Indices below, at and above that of the surroundings agree."""
    agree(scene(shape("sphere", {**GLASS, "refractiveindex": index}), GROUND, BACK), RGB)


def test_total_internal_reflection(agree):
    """From inside glass, beyond the critical angle everything is reflected."""
    camera = {"position": [0.1, 0.1, -0.1], "lookAt": [0.7, 0.3, 0.5], "fov": 100.0}
    agree(scene(shape("box", {**GLASS, "reflectivity": 1.0}), GROUND, BACK, camera=camera), RGB)


@pytest.mark.parametrize("inner", ["sphere", "cylinder", "box", "convex_halfspaces", "convex_vertices"])
def test_nested_media(agree, inner):
    """Glass inside water inside a box: each surface separates its index from that of the least shape around it."""
    water = {**GLASS, "refractiveindex": 1.33, "reflectivity": 1.0}
    outer = {"type": "box", "min": [-1.1, -1.2, -1.3], "max": [1.2, 1.3, 1.4],
             "material": {**water, "refractiveindex": 1.2}}
    agree(scene(outer, sphere([0, 0.1, 0], 1.18, water), shape(inner, {**GLASS, "refractiveindex": 1.7}), BACK,
                nbounces=5), RGB)


def test_glass_that_only_overlaps_is_not_nested(agree):
    """Two glass spheres that cross each other are each surrounded by air."""
    other = sphere([0.45, 0.1, 0.1], 0.6, {**GLASS, "refractiveindex": 1.3})
    agree(scene(sphere([-0.3, 0.1, 0], 0.7, GLASS), other, BACK, nbounces=3), RGB)


def test_glass_that_pokes_out_is_not_nested(agree):
    """A sphere that leaves the one around it by a hundredth of its radius, in no special direction, is in air."""
    inner = {**GLASS, "refractiveindex": 1.9}
    agree(scene(sphere([0, 0.1, 0], 0.9, GLASS), sphere([0.24, 0.22, -0.05], 0.639, inner), BACK, nbounces=3), RGB)


def test_mirror_inside_glass(agree):
    """A mirror seen through glass."""
    agree(scene(shape("sphere", {**GLASS, "reflectivity": 1.0}), sphere([0.1, 0.1, 0.1], 0.3, MIRROR), BACK), RGB)
