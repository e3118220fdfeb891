"""Which glass lies in which: the renderer's answer against the converters' closed forms, which share no code."""

import numpy as np
import pytest

from converters import nesting
from renderer.scene import schema
from renderer.scene.media import exterior_index

pytestmark = pytest.mark.oracle

KINDS = ("sphere", "cylinder", "box", "convex")
PAIRS = 150


def random_shape(kind, size, rng):
    """Return a glass shape of the kind, of about the size, near the origin."""
    material = schema.Material(isrefractive=True, refractiveindex=float(rng.uniform(1.1, 2.0)))
    centre = rng.uniform(-0.25, 0.25, 3)
    length = size * rng.uniform(0.7, 1.0, 3)
    if kind == "sphere":
        return schema.Sphere(center=tuple(centre), radius=length[0], material=material)
    if kind == "cylinder":
        return schema.Cylinder(center=tuple(centre), axis=tuple(rng.normal(size=3)), radius=length[0], height=length[1],
                               material=material)
    if kind == "box":
        return schema.Box(min=tuple(centre - length), max=tuple(centre + length), material=material)
    points = rng.normal(size=(12, 3))
    points *= 1.5 * size / np.linalg.norm(points, axis=1, keepdims=True)
    return schema.Convex(vertices=tuple(map(tuple, centre + points)), material=material)


@pytest.mark.parametrize("inner", KINDS)
@pytest.mark.parametrize("outer", KINDS)
def test_nested_media_of_random_pairs(outer, inner):
    """Shapes that just fit, and just do not fit, into each other get the same index outside."""
    rng = np.random.default_rng([KINDS.index(outer), KINDS.index(inner)])
    contained = 0
    for _ in range(PAIRS):
        shapes = [random_shape(outer, 1.0, rng), random_shape(inner, rng.uniform(0.2, 0.8), rng)]
        expected = nesting.outside_indices(shapes)
        contained += expected[1] != 1.0
        assert [exterior_index(s, shapes) for s in shapes] == expected, shapes
    assert 0.1 * PAIRS < contained < 0.95 * PAIRS, "pairs must be mixed to say something"
