"""The meshes and rays that tracers are compared with are what they are said to be."""

import numpy as np
import pytest

from benchmarks import embree, mesh_rays
from benchmarks.mesh_scenes import KINDS, DiffusePicture, Light, View, bumpy, octahedron, soup


def volume(vertices, faces):
    """Return the signed volume that a mesh encloses."""
    a, b, c = vertices[faces].astype(np.float64).transpose(1, 0, 2)
    return (a * np.cross(b, c)).sum() / 6


@pytest.mark.parametrize("k", [1, 2, 3, 8])
def test_octahedron_is_closed(k):
    """Each edge is passed once in either direction, and the Euler characteristic is a sphere's."""
    vertices, faces = octahedron(k)
    assert faces.shape == (8 * k * k, 3) and len(vertices) == 4 * k * k + 2
    assert len(np.unique(vertices, axis=0)) == len(vertices) and (abs(vertices).sum(axis=1) == k).all()
    edges = np.concatenate([faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert set(map(tuple, edges)) == set(map(tuple, edges[:, ::-1]))
    assert len(vertices) - len(edges) // 2 + len(faces) == 2


def test_octahedron_encloses_its_volume():
    """Windings point outwards everywhere: with corners at distance k the volume is 4/3 k^3, nothing folded over."""
    assert volume(*octahedron(4)) == pytest.approx(4 / 3 * 4**3, rel=1e-12)


@pytest.mark.parametrize("make", KINDS.values())
def test_mesh_fills_the_unit_ball_and_is_the_same_each_time(make):
    """Nothing lies outside, something comes near to its surface, and the number of triangles is as asked."""
    vertices, faces = make(5000)
    distance = np.linalg.norm(vertices, axis=1)
    assert 0.9 < distance.max() <= 1 and abs(len(faces) - 5000) < 150
    assert vertices.dtype == np.float32 and faces.dtype == np.uint32
    assert np.array_equal(make(5000)[0], vertices)


def test_more_triangles_bring_smaller_bumps():
    """Each step of the size adds surface around the same volume; without bumps a sphere's 4.84 would stay."""

    def area_around_unit_volume(vertices, faces):
        a, b, c = vertices[faces].astype(np.float64).transpose(1, 0, 2)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        return area / volume(vertices, faces) ** (2 / 3)

    areas = [area_around_unit_volume(*bumpy(count)) for count in (100, 2000, 40_000)]
    assert areas[0] > 4.84 and areas[1] > 1.1 * areas[0] and areas[2] > 1.1 * areas[1]


def test_soup_shares_no_vertices():
    """Every triangle has three of its own."""
    vertices, faces = soup(500)
    assert np.array_equal(faces.ravel(), np.arange(1500)) and len(vertices) == 1500


@pytest.fixture(scope="module")
def sets():
    """The ray sets of a bumpy mesh by name."""
    return {rays.name: rays for rays in mesh_rays.ray_sets(*bumpy(2000), 60, 40)}


def test_rays_are_unit_and_as_many_as_pixels(sets):
    """All sets are of one size, single precision."""
    for rays in sets.values():
        for host in rays.orders.values():
            assert host.o.shape == host.d.shape == (2400, 3) and host.o.dtype == host.d.dtype == np.float32
            np.testing.assert_allclose(np.linalg.norm(host.d, axis=1), 1, rtol=1e-6)


def test_only_shadow_rays_end_and_only_primary_ones_are_alike(sets):
    """What is asked of a set, and told about it."""
    assert [name for name, rays in sets.items() if rays.shadow] == ["shadow"]
    assert [name for name, rays in sets.items() if rays.coherent] == ["primary"]


def test_shadow_rays_end_on_the_light(sets):
    """Origin, direction and distance lead to points all over the square above."""
    (host,) = sets["shadow"].orders.values()
    ends, light = host.o + host.d * host.distance[:, None], Light()
    np.testing.assert_allclose(ends[:, 1], light.centre[1], atol=1e-5)
    assert abs(ends[:, [0, 2]]).max() == pytest.approx(light.side / 2, rel=0.01)


def test_surface_points_are_spread_by_area():
    """A triangle of three times the area gets three times the points, and they lie in its plane."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 5], [3, 0, 5], [0, 1, 5]], np.float32)
    p, n = mesh_rays.surface_points(np.random.default_rng(1), vertices, np.array([[0, 1, 2], [3, 4, 5]]), 40_000)
    upper = p[:, 2] > 2.5
    np.testing.assert_allclose(p[:, 2], np.where(upper, 5, 0), rtol=1e-12)
    assert upper.mean() == pytest.approx(0.75, abs=0.01) and (n == [0, 0, 1]).all()
    np.testing.assert_allclose(p[upper].mean(axis=0), [1, 1 / 3, 5], atol=0.02)


def test_bounces_go_off_by_the_cosine():
    """From a flat floor: the mean cosine is 2/3, and all directions go up."""
    vertices, faces = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), np.array([[0, 1, 2]])
    sets = {rays.name: rays for rays in mesh_rays.ray_sets(vertices, faces, 200, 100)}
    (host,) = sets["bounce"].orders.values()
    assert host.d[:, 2].min() >= 0 and host.d[:, 2].mean() == pytest.approx(2 / 3, abs=0.01)
    np.testing.assert_allclose(host.o[:, 2], mesh_rays.OFFSET)


def test_tiles_are_the_same_pixels_in_another_order():
    """Four pixels of a tile follow each other; pictures need not be whole tiles."""
    assert mesh_rays.pixel_order(4, 2, 2).tolist() == [0, 1, 4, 5, 2, 3, 6, 7]
    assert mesh_rays.pixel_order(3, 2, 1).tolist() == list(range(6))
    assert sorted(mesh_rays.pixel_order(7, 5, 4)) == list(range(35))


def test_primary_rays_are_those_of_mitsubas_camera():
    """The picture that is path-traced is seen from where the primary rays start."""
    picture = DiffusePicture(size=8)
    (primary,) = [rays for rays in mesh_rays.ray_sets(*bumpy(100), 8, 8) if rays.coherent]
    host = primary.orders["rows"]
    middle = np.stack([np.tile(np.arange(8), 8), np.repeat(np.arange(8), 8)]) + 0.5
    sensor = embree.mi.load_dict(embree._sensor(picture))
    ray, _ = sensor.sample_ray(0, 0, embree.mi.Point2f(middle / 8), embree.mi.Point2f(0.5))
    np.testing.assert_allclose(ray.d.numpy().T, host.d, atol=1e-6)
    assert host.o[0] == pytest.approx(View().eye)
