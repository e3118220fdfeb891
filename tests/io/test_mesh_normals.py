"""Vertex normals weighted by angle: closed forms, a plain twin, and what has no normal."""

import math

import numpy as np
import pytest

from renderer.io import mesh_normals
from renderer.io.mesh_normals import smooth_normals

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
SIDES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])  # from outside


def halves(quads, other=False):
    """Return the triangles of quads cut along one diagonal or the other."""
    a, b, c, d = quads.T
    cut = [[b, c, d], [b, d, a]] if other else [[a, b, c], [a, c, d]]
    return np.concatenate([np.stack(corners, -1) for corners in cut])


def plain(vertices, faces):
    """Return the normals by the definition, one corner after the other, with arc cosines."""
    sums = np.zeros((len(vertices), 3))
    for face in faces:
        for corner in range(3):
            p, q, r = (vertices[face[(corner + step) % 3]] for step in range(3))
            normal = np.cross(q - p, r - p)
            if np.linalg.norm(normal) > 0:
                cosine = np.dot(q - p, r - p) / np.linalg.norm(q - p) / np.linalg.norm(r - p)
                sums[face[corner]] += math.acos(np.clip(cosine, -1, 1)) * normal / np.linalg.norm(normal)
    return sums / np.linalg.norm(sums, axis=1, keepdims=True)


@pytest.mark.parametrize("diagonals", [[False] * 6, [True] * 6, [True, False, False, True, True, False]])
def test_normals_of_a_cube_do_not_depend_on_its_diagonals(diagonals):
    """At each corner, along the cube's diagonal: what weights by area or by number would miss."""
    faces = np.concatenate([halves(SIDES[i : i + 1], other) for i, other in enumerate(diagonals)])
    expected = (CUBE - 0.5) / np.linalg.norm(CUBE - 0.5, axis=1, keepdims=True)
    np.testing.assert_allclose(smooth_normals(CUBE, faces), expected, atol=1e-7)


def test_agrees_with_the_definition(monkeypatch):
    """On random triangles, over more than one block."""
    monkeypatch.setattr(mesh_normals, "BLOCK", 7)
    rng = np.random.default_rng(3)
    vertices, faces = rng.normal(size=(12, 3)), rng.permuted(np.tile(np.arange(12), (50, 1)), axis=1)[:, :3]
    normals = smooth_normals(vertices, faces.astype(np.uint32))
    assert normals.dtype == np.float32 and normals.flags.c_contiguous
    np.testing.assert_allclose(normals, plain(vertices, faces), atol=1e-6)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e17])
@pytest.mark.parametrize("offset", [0.0, 100.0])
def test_size_and_place_do_not_matter(scale, offset):
    """Nor does the precision of the positions."""
    vertices = (CUBE + offset) * scale
    expected = (CUBE - 0.5) / np.linalg.norm(CUBE - 0.5, axis=1, keepdims=True)
    np.testing.assert_allclose(smooth_normals(vertices.astype(np.float32), halves(SIDES)), expected, atol=2e-4)
    np.testing.assert_allclose(smooth_normals(vertices, halves(SIDES)), expected, atol=1e-6)


def test_undefined_normals_are_zero():
    """A vertex of no triangle, of triangles without area only, and between two triangles back to back."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5], [2, 0, 0], [3, 0, 0]], np.float32)
    normals = smooth_normals(vertices, np.array([[0, 1, 2], [0, 2, 1], [1, 4, 5], [4, 4, 5]], np.uint32))
    np.testing.assert_array_equal(normals, np.zeros((6, 3)))


def test_triangles_without_area_do_not_count():
    """They change nothing for the vertices that others have too."""
    faces = np.concatenate([halves(SIDES), [[0, 0, 1], [3, 3, 3]]])
    np.testing.assert_array_equal(smooth_normals(CUBE, faces), smooth_normals(CUBE, halves(SIDES)))


def test_one_point_has_no_normal():
    """An extent of nothing divides nothing."""
    np.testing.assert_array_equal(smooth_normals(np.ones((3, 3)), np.array([[0, 1, 2]])), np.zeros((3, 3)))
