"""Which glass is around which: the quick way for many shapes finds what trying all of them finds."""

import random
import time

import pytest

from renderer.scene import materials, media, schema


def glass(kind, centre, size, index, axis=(0.0, 1.0, 0.0)):
    """Return a refractive shape of about the given size."""
    material = schema.Material(isrefractive=True, refractiveindex=index)
    if kind == "sphere":
        return schema.Sphere(center=centre, radius=size, material=material)
    if kind == "cylinder":
        return schema.Cylinder(center=centre, axis=axis, radius=size, height=size, material=material)
    if kind == "box":
        low, high = (tuple(c + sign * size for c in centre) for sign in (-1, 1))
        return schema.Box(min=low, max=high, material=material)
    if kind == "corners":
        ends = [tuple(c + size * (axis == where) * sign for where, c in enumerate(centre))
                for axis in range(3) for sign in (-1, 1)]
        return schema.Convex(vertices=tuple(ends), material=material)
    walls = [(1.0, 0.0, 0.0, centre[0] + size), (-1.0, 0.0, 0.0, size - centre[0]), (0.0, 1.0, 0.0, centre[1] + size)]
    return schema.Convex(halfspaces=tuple(walls), material=material)  # open on three sides


def scene(count, extent, kinds):
    """Return shapes of many sizes at random places, and an opaque one."""
    rng = random.Random(5)
    shapes = []
    for number in range(count):
        centre = tuple(rng.uniform(-extent, extent) for _ in range(3))
        axis = tuple(rng.gauss(0, 1) for _ in range(3))
        shapes.append(glass(rng.choice(kinds), centre, 2 ** rng.uniform(-2, 2), 1.1 + number / 1000, axis))
    return [*shapes, schema.Sphere(center=(0.0, 0.0, 0.0), radius=99.0)]


KINDS = ("sphere", "cylinder", "box", "corners", "walls")


@pytest.mark.parametrize("kinds", [(kind,) for kind in KINDS] + [KINDS], ids=[*KINDS, "all"])
def test_many_shapes_are_as_few(kinds):
    """Bounds leave out nothing that surrounds; the opaque sphere around everything is no medium."""
    count = 2 * media.FEW
    shapes = scene(count, 3.0, kinds)
    expected = [media.exterior_index(shape, shapes) if shape.material.isrefractive else 1.0 for shape in shapes]
    assert media.exterior_indices(shapes) == expected
    if kinds != ("walls",):  # what is open to infinity is in nothing smaller
        assert sum(index != 1.0 for index in expected) > count / 20, "some must be inside of others to say something"


def test_touching_from_inside_is_inside():
    """Equal bounds: the ball is in the cylinder, which is in two equal boxes, of which none is in the other."""
    inner = [glass(kind, (7.0, -3.0, 1e3), 1.0, 1.3) for kind in ("sphere", "box", "cylinder")]
    far = [glass("sphere", (1e4 + 3.0 * i, 0.0, 0.0), 1.0, 1.5) for i in range(media.FEW)]
    around = [glass("box", (7.0, -3.0, 1e3), 1.0, 1.7)]
    found = media.exterior_indices([*inner, *around, *far])
    assert found == [1.3, 1.0, 1.3, 1.0, *[1.0] * media.FEW]


def test_thousands_of_drops_are_settled_at_once():
    """Trying all pairs of these would take minutes."""
    drops = scene(10_000, 300.0, ("sphere", "cylinder"))
    began = time.process_time()
    media.exterior_indices(drops)
    assert time.process_time() - began < 5


@pytest.mark.parametrize(("bsdf", "in_phong", "in_paths"), [
    (None, 1.3, 1.3),
    (materials.Dielectric(type="dielectric", ior=1.7), 1.3, 1.7),
    (materials.RoughDielectric(type="roughdielectric", ior=1.7), 1.3, 1.7),
    (materials.Plastic(type="plastic", ior=1.7), 1.3, 1.0),
    (materials.Diffuse(type="diffuse"), 1.3, 1.0),
])
def test_the_bsdf_says_in_path_traced_scenes_what_refracts(bsdf, in_phong, in_paths):
    """Elsewhere the coursework's keys do; around the outer shape there is nothing."""
    outer = schema.Sphere(center=(0.0, 0.0, 0.0), radius=2.0,
                          material=schema.Material(isrefractive=True, refractiveindex=1.3, bsdf=bsdf))
    inner = glass("sphere", (0.5, 0.0, 0.0), 1.0, 1.5)
    assert media.exterior_indices([outer, inner]) == [1.0, in_phong]
    assert media.exterior_indices([outer, inner], paths=True) == [1.0, in_paths]
