"""The converters' own geometry: hulls, facets, meshes and which shape lies in which."""

import dataclasses

import numpy as np
import pytest

from converters import geometry, nesting
from renderer.scene import schema
from tests.support.documents import GLASS, SHAPES
from tests.support.twin import Twin

CUBE = [[1, 0, 0, 1], [-1, 0, 0, 1], [0, 1, 0, 1], [0, -1, 0, 1], [0, 0, 1, 1], [0, 0, -2, 2]]
BUILD = {"sphere": schema.Sphere, "cylinder": schema.Cylinder, "box": schema.Box, "convex": schema.Convex}


def glass(kind, **keys):
    """Return a refractive shape of the description."""
    return BUILD[kind](material=schema.Material(**{**GLASS, "refractiveindex": 1.5}), **keys)


def test_halfspaces_of_a_cube_have_its_corners():
    """Six half-spaces, of any length, meet in the eight corners of the cube."""
    cube = geometry.intersection(CUBE)
    assert sorted(map(tuple, np.round(cube.corners, 9) + 0.0)) == sorted(
        (x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0))
    assert not cube.clipped


def test_redundant_halfspaces_are_dropped():
    """A plane that only touches an edge, and one far outside, have no facet."""
    cube = geometry.intersection([*CUBE, [1, 1, 0, 2], [1, 0, 0, 7]])
    assert len(cube.normals) == 6


def test_unbounded_volume_is_clipped():
    """Five sides of a cube are closed by the clip distance."""
    open_box = geometry.intersection(CUBE[1:])
    assert open_box.clipped
    assert open_box.corners[:, 0].max() == pytest.approx(geometry.CLIP_DISTANCE)


def test_empty_intersection_is_told():
    """Half-spaces without common interior, and flat hulls, raise EmptyVolume."""
    with pytest.raises(geometry.EmptyVolume):
        geometry.intersection([[1, 0, 0, -1], [-1, 0, 0, -1]])
    with pytest.raises(geometry.EmptyVolume):
        geometry.hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])


@pytest.mark.parametrize("volume", [geometry.intersection(CUBE), geometry.hull(SHAPES["convex_vertices"]["vertices"]),
                                    geometry.intersection(SHAPES["convex_halfspaces"]["halfspaces"])])
def test_mesh_is_closed_and_faces_outwards(volume):
    """The signed volume of the mesh, summed over its triangles, is that of the hull of its corners."""
    from scipy.spatial import ConvexHull

    mesh = geometry.convex_mesh(volume)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(ConvexHull(volume.corners).volume)


def test_box_has_upright_faces():
    """On every side of the box the top row of the texture is up, and each face has the whole of it."""
    mesh = geometry.box_mesh((0, 0, 0), (1, 2, 3))
    assert mesh.vertices.shape == (24, 3)
    for face in range(6):
        corners, uv = mesh.vertices[4 * face:4 * face + 4], mesh.uv[4 * face:4 * face + 4]
        assert {tuple(v) for v in uv} == {(0, 0), (0, 1), (1, 0), (1, 1)}
        if np.ptp(corners[:, 1]):
            assert (uv[corners[:, 1] == 2][:, 1] == 0).all()


def test_frame_is_right_handed_and_follows_the_convention():
    """t = cross(n, y) but for steep normals, t = cross(n, z); b = cross(n, t)."""
    for normal, tangent in (((0, 0, 1), (-1, 0, 0)), ((0, 1, 0), (1, 0, 0)), ((1, 0, 0), (0, 0, 1))):
        t, b = geometry.frame(np.array(normal, float))
        assert np.allclose(t, tangent)
        assert np.allclose(np.cross(t, b), normal)


BALL = glass("sphere", center=(0, 0, 0), radius=1.0)
INSIDE = [
    (BALL, glass("sphere", center=(0.3, 0.4, 0), radius=0.499)),
    (BALL, glass("cylinder", center=(0, 0, 0), axis=(1, 2, 3), radius=0.599, height=0.8)),
    (BALL, glass("box", min=(-0.57, -0.57, -0.57), max=(0.57, 0.57, 0.57))),
    (glass("cylinder", center=(0, 0, 0), axis=(0, 0, 2), radius=1.001, height=0.501),
     glass("cylinder", center=(0, 0, 0), axis=(1, 0, 0), radius=0.5, height=0.866)),
    (glass("box", min=(-1, -1, -1), max=(1, 1, 1)), BALL),
    (glass("convex", halfspaces=tuple(map(tuple, CUBE))), BALL),
    (glass("convex", halfspaces=((1, 1, 1, 1.7321),)), BALL),
]
OUTSIDE = [
    (BALL, glass("sphere", center=(0.3, 0.4, 0), radius=0.501)),
    (BALL, glass("cylinder", center=(0, 0, 0), axis=(1, 2, 3), radius=0.601, height=0.8)),
    (BALL, glass("box", min=(-0.57, -0.57, -0.57), max=(0.6, 0.58, 0.58))),
    (glass("cylinder", center=(0, 0, 0), axis=(0, 0, 2), radius=0.999, height=0.501),
     glass("cylinder", center=(0, 0, 0), axis=(1, 0, 0), radius=0.5, height=0.867)),
    (glass("convex", halfspaces=((1, 1, 1, 1.7319),)), BALL),
    (BALL, glass("box", min=(-1, -1, -1), max=(1, 1, 1))),
]


@pytest.mark.parametrize(("pairs", "expected"), [(INSIDE, True), (OUTSIDE, False)])
def test_containment_to_a_thousandth(pairs, expected):
    """Pairs that just fit and just do not fit into each other are told apart."""
    assert [nesting.contains(outer, inner) for outer, inner in pairs] == [expected] * len(pairs)


def test_smallest_container_counts():
    """Of nested shapes each lies in the next larger one; matt and open shapes and crossings count for nothing."""
    material = {r: schema.Material(isrefractive=True, refractiveindex=1 + r) for r in (0.5, 2.0, 1.0)}
    sizes = [schema.Sphere(center=(0, 0, 0), radius=r, material=m) for r, m in material.items()]
    matt = schema.Sphere(center=(0, 0, 0), radius=1.5)
    crossing = glass("sphere", center=(2.0, 0, 0), radius=0.4)
    assert nesting.outside_indices([*sizes, matt, crossing]) == [2.0, 1.0, 3.0, 1.0, 1.0]


def test_equal_shapes_do_not_surround_each_other():
    """Two equal glass shapes in one place are each surrounded by air."""
    assert nesting.outside_indices([BALL, dataclasses.replace(BALL)]) == [1.0, 1.0]


def test_containment_agrees_with_points_on_the_surface():
    """Random pairs: what is called inside has all its surface points inside, by an independent test."""
    from tests.support import twin

    rng, points = np.random.default_rng(2), Twin._surface_points
    found = 0
    for _ in range(60):
        inner = glass("cylinder", center=tuple(rng.uniform(-0.4, 0.4, 3)), axis=tuple(rng.normal(size=3)),
                      radius=float(rng.uniform(0.1, 0.6)), height=float(rng.uniform(0.1, 0.6)))
        for outer in (BALL, glass("cylinder", center=(0, 0, 0), axis=(1, 1, 0), radius=0.9, height=0.9)):
            brute = bool(twin._contains(outer, points(None, inner)).all())
            assert nesting.contains(outer, inner) == brute
            found += brute
    assert 20 < found < 100
