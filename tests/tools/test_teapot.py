"""The teapot: the committed mesh is what the command makes, and is the surface that the control points describe."""

import json
from pathlib import Path

import numpy as np
import pytest

from renderer.io.mesh import read_mesh
from tools import teapot

MESHES = Path(__file__).resolve().parents[2] / "scenes" / "meshes"
DATA = json.loads((MESHES / "teapot.json").read_text(encoding="utf-8"))
LOW, HIGH = (-3, 0, -2), (3.4338, 3.15, 2)  # of the surface: handle to spout, height, width of the body
# Edges of patches that no other patch has: the mouth's and the lid's, four each, and two at each end of two tubes.
RIMS = 4 + 4 + 2 * 2 * 2


def mesh(divisions):
    return teapot.tessellate(DATA, divisions)


def edges(vertices, faces):
    """Return the directed edges (E, 2) between different places, and the places (P, 3)."""
    places, number = np.unique(vertices, axis=0, return_inverse=True)
    faces = number.reshape(-1)[faces]
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), places


def test_command_makes_the_committed_file(tmp_path):
    """To the last byte, and in at most 400 kB."""
    teapot.main(["-o", str(tmp_path / "teapot.ply")])
    made = (tmp_path / "teapot.ply").read_bytes()
    assert made == (MESHES / "teapot.ply").read_bytes()
    assert len(made) <= 400_000


def test_data_has_its_source_and_licence():
    """32 patches of 16, all vertices in use."""
    assert "Newell" in DATA["source"] and "MIT" in DATA["licence"]
    assert np.shape(DATA["patches"]) == (32, 16) and np.shape(DATA["vertices"])[1] == 3
    assert {*np.ravel(DATA["patches"])} == {*range(len(DATA["vertices"]))}
    assert sum(count for _, count in DATA["parts"].values()) == 32


def test_extents_are_the_published_ones():
    """y upwards, spout towards +x."""
    vertices = read_mesh(MESHES / "teapot.ply").vertices
    np.testing.assert_allclose(vertices.min(0), LOW, atol=1e-6)
    np.testing.assert_allclose(vertices.max(0), HIGH, atol=1e-4)


@pytest.mark.parametrize("divisions", [2, 5, 14])
def test_edges_have_two_triangles_except_at_the_rims(divisions):
    """In opposite directions each; the gap around the lid and the ends of handle and spout are open."""
    vertices, faces, _, _ = mesh(divisions)
    directed, places = edges(vertices, faces)
    met = set(map(tuple, directed.tolist()))
    assert len(met) == len(directed)
    single = np.array([edge for edge in met if edge[::-1] not in met])
    assert len(single) == RIMS * divisions
    ends = places[single[:, 0]]
    around = np.hypot(ends[:, 0], ends[:, 2])
    mouth_or_lid = (np.abs(ends[:, 1] - 2.4) < 1e-6) & (around < 1.42) & (around > 1.29)
    assert np.count_nonzero(mouth_or_lid) == 8 * divisions


def test_normals_are_unit_and_agree_with_the_triangles():
    """In a fine mesh, a vertex's normal is near those of its triangles, the poles of lid and bottom included."""
    vertices, faces, normals, _ = mesh(40)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-12)
    e1, e2 = (vertices[faces[:, i]] - vertices[faces[:, 0]] for i in (1, 2))
    flat = np.cross(e1, e2)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert (flat[:, None, :] * normals[faces]).sum(-1).min() > 0.85
    top, foot = np.argmax(vertices[:, 1]), np.argmin(np.abs(vertices).max(1))
    np.testing.assert_allclose([normals[top], normals[foot]], [(0, 1, 0), (0, -1, 0)], atol=1e-12)


def test_normals_point_outwards():
    """From the sides and from below, where no opening shows the inside, the front of the first triangle is seen."""
    vertices, faces, normals, _ = mesh(6)
    corner, e1, e2 = vertices[faces[:, 0]], *(vertices[faces[:, i]] - vertices[faces[:, 0]] for i in (1, 2))
    rng, seen = np.random.default_rng(4), 0
    for _ in range(300):
        direction = rng.normal(size=3)
        direction[1] = abs(direction[1])  # rays that climb, or nearly level ones
        direction /= np.linalg.norm(direction)
        origin = rng.uniform((-2, 0.2, -1), (2, 2.2, 1)) - 10 * direction
        p = np.cross(direction, e2)
        determinant = (e1 * p).sum(1)
        offset = origin - corner
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (offset * p).sum(1) / determinant
            q = np.cross(offset, e1)
            v, t = (q * direction).sum(1) / determinant, (q * e2).sum(1) / determinant
        hit = np.flatnonzero((u > 0) & (v > 0) & (u + v < 1) & (t > 0))
        if len(hit):
            first = hit[np.argmin(t[hit])]
            seen += 1
            assert (normals[faces[first]].mean(0) * direction).sum() < 0.15  # grazed edges of coarse triangles
    assert seen > 100


def test_texture_coordinates_cover_each_part_once():
    """All within 0 and 1, and not mirrored in one part against another."""
    vertices, faces, normals, uv = mesh(4)
    assert uv.min() == 0 and uv.max() == 1
    (du1, dv1), (du2, dv2) = (np.moveaxis(uv[faces[:, i]] - uv[faces[:, 0]], -1, 0) for i in (1, 2))
    area = du1 * dv2 - du2 * dv1
    assert np.count_nonzero(area < -1e-9) in (0, len(area)) or np.count_nonzero(area > 1e-9) in (0, len(area))
