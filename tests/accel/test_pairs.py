"""Pairing triangles at their edges: an exact cover, of the input's own corners, worth its boxes, always the same."""

import drjit as dr
import numpy as np
import pytest

from renderer.accel import pairs as pairs_module
from renderer.accel.pairs import MOST_AREA, NO_PRIMITIVE, pair, turn_alike
from renderer.core.backend import NAME, Float, Vector3f

LEAST_SHARE = 0.85  # of a closed mesh's triangles; only then a leaf's record is well filled


def vectors(corners):
    """Return the corners of triangles, (T, 3, 3), as lanes; copied, because memory of numpy need not be aligned."""
    one = dr.opaque(Float, 1)
    return [Vector3f(*(Float(np.ascontiguousarray(corners[:, k, axis], np.float32)) * one for axis in range(3)))
            for k in range(3)]


def paired(corners):
    """Return `(v, first, second)`, (M, 4, 3) float32 and two of M numbers, of triangles (T, 3, 3)."""
    pairs = pair(*vectors(corners))
    v = np.stack([np.array(part).T for part in (pairs.v0, pairs.v1, pairs.v2, pairs.v3)], 1)
    return v, np.array(pairs.first), np.array(pairs.second)


def corner_sets(triangles):
    """Return the bits of triangles' corners, (T, 3, 3), the corners of each sorted: rotation and winding are gone."""
    bits = np.ascontiguousarray(triangles, np.float32).view(np.uint32)
    corners = bits.view([("x", np.uint32), ("y", np.uint32), ("z", np.uint32)])[..., 0]
    return np.sort(corners, axis=1)


def assert_valid(corners, v, first, second):
    """Every triangle is in one item, and each item consists of exactly the corners of its triangles."""
    two = second != NO_PRIMITIVE
    assert np.array_equal(np.sort(np.concatenate([first, second[two]])), np.arange(len(corners)))
    assert (first[two] < second[two]).all() and (np.diff(first.astype(np.int64)) > 0).all()
    sets = corner_sets(corners)
    assert np.array_equal(corner_sets(v[:, [0, 1, 2]]), sets[first])
    assert np.array_equal(corner_sets(v[two][:, [0, 2, 3]]), sets[second[two]])
    assert np.array_equal(v[~two, 3].view(np.uint32), v[~two, 2].view(np.uint32))


def sphere(rows, shuffle=None):
    """Return the triangles of a closed bumpy sphere, (4 rows^2 - 4 rows, 3, 3) float32, in a random order if wished."""
    rng = np.random.default_rng(1)
    polar = np.linspace(0, np.pi, rows + 1)[:, None]
    around = np.linspace(0, 2 * np.pi, 2 * rows + 1)[:-1]
    points = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar + 0 * around)], -1)
    points *= rng.uniform(0.95, 1.05, points.shape[:2])[..., None]
    points[0], points[-1] = [0, 0, 1], [0, 0, -1]
    points = points.astype(np.float32)
    north, south = points[:-1], points[1:]
    east = np.roll(points, -1, axis=1)
    upper, lower = np.stack([north, south, east[:-1]], 2)[1:], np.stack([south, east[1:], east[:-1]], 2)[:-1]
    corners = np.concatenate([upper.reshape(-1, 3, 3), lower.reshape(-1, 3, 3)])
    if shuffle is None:
        return corners
    rng = np.random.default_rng(shuffle)
    turns = rng.permuted(np.tile(np.arange(3), (len(corners), 1)), axis=1)
    return np.take_along_axis(corners[rng.permutation(len(corners))], turns[..., None], axis=1)


def half_area(points):
    """Return half the surface area of the boxes around points, (N, K, 3), in double precision."""
    x, y, z = np.ptp(points.astype(np.float64), axis=1).T
    return x * y + y * z + z * x


def share(corners, second):
    """Return which part of the triangles is paired."""
    return 2 * (second != NO_PRIMITIVE).sum() / len(corners)


@pytest.mark.parametrize("shuffle", [None, 0, 1])
def test_closed_mesh_is_mostly_paired(shuffle):
    """Whatever the order of triangles and corners, few stay alone, and each pair is worth its box."""
    corners = sphere(60, shuffle)
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert share(corners, second) >= LEAST_SHARE
    two = second != NO_PRIMITIVE
    sums = half_area(corners[first[two]]) + half_area(corners[second[two]])
    assert (half_area(v[two]) <= MOST_AREA * sums * (1 + 1e-5)).all()


def test_no_worthwhile_pair_is_left():
    """Of two neighbours that both stay alone, the common box is too large."""
    corners = sphere(60, shuffle=3)
    _, first, second = paired(corners)
    owner, neighbours = {}, []
    for triangle in first[second == NO_PRIMITIVE]:
        for k in range(3):
            edge = frozenset(corners[triangle, end].tobytes() for end in (k, (k + 1) % 3))
            if edge in owner:
                neighbours.append((owner[edge], triangle))
            owner[edge] = triangle
    one, other = corners[neighbours].swapaxes(0, 1)
    together = half_area(np.concatenate([one, other], 1))
    assert (together > MOST_AREA * (half_area(one) + half_area(other)) * (1 - 1e-5)).all()


@pytest.mark.skipif(NAME != "llvm", reason="a GPU has no number of threads")
def test_number_of_threads_does_not_matter():
    """One thread and four give the same bytes."""
    corners, results, threads = sphere(100, shuffle=2), [], dr.thread_count()
    try:
        for count in (1, 4, 4):
            dr.set_thread_count(count)
            results.append([part.tobytes() for part in paired(corners)])
    finally:
        dr.set_thread_count(threads)
    assert results[0] == results[1] == results[2]


def test_kernels_do_not_depend_on_the_number_of_triangles():
    """What was compiled for small meshes also serves a larger one."""
    if dr.flag(dr.JitFlag.Debug):
        pytest.skip("Dr.Jit's checks write the sizes of arrays into the kernels")

    def kernels(rows):
        lanes = vectors(sphere(rows))
        dr.eval(lanes)
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
            dr.kernel_history_clear()
            pair(*lanes)
            return {entry["hash"] for entry in dr.kernel_history([dr.KernelType.JIT])}

    assert kernels(90) <= set().union(*(kernels(rows) for rows in range(2, 20)))


@pytest.mark.parametrize("power", [-100, 100])
def test_size_does_not_matter(power):
    """The same mesh, much smaller or larger by a power of two, has the same pairs."""
    _, first, second = paired(sphere(20))
    _, scaled_first, scaled_second = paired(sphere(20) * np.float32(2.0**power))
    assert np.array_equal(first, scaled_first) and np.array_equal(second, scaled_second)


@pytest.mark.parametrize("count", [1, 2, 3, 100])
def test_loose_triangles_stay_alone(count):
    """Triangles without common corners are returned as they are."""
    corners = np.random.default_rng(0).random((count, 3, 3), np.float32)
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert (second == NO_PRIMITIVE).all()


@pytest.mark.parametrize("one", [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1]])
@pytest.mark.parametrize("other", [[0, 2, 3], [2, 3, 0], [3, 0, 2], [2, 0, 3]])
def test_two_triangles_with_any_winding(one, other):
    """A quad is recognised however its two halves are written down."""
    points = np.array([[-0.0, 0, 1], [1, 0, 1], [1, 1, 0], [0, 1, 0]], np.float32)
    corners = points[[one, other]]
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert first.tolist() == [0] and second.tolist() == [1]
    lanes = vectors(corners)
    assert turn_alike(pair(*lanes), lanes) == ((one == [0, 2, 1]) == (other == [2, 0, 3]))


def test_one_common_corner_is_not_enough():
    """Triangles that only touch are no pair: an item could not hold them."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], np.float32)
    corners = points[[[0, 1, 2], [0, 3, 4]]]
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert (second == NO_PRIMITIVE).all()


def test_long_triangles_across_each_other_stay_alone():
    """Two that share an edge but whose common box is far larger than theirs are better off alone."""
    points = np.array([[0, 0, 0], [0, 0, 1], [1000, 0, 0], [0, 1000, 0]], np.float32)
    corners = points[[[0, 1, 2], [0, 1, 3]]]
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert (second == NO_PRIMITIVE).all()


@pytest.mark.parametrize(
    "points", [[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [1, 0, 0], [1, 0, 0]], [[1, 2, 3]] * 3],
    ids=["triangle", "line", "point"])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 1001])
def test_identical_triangles(points, count):
    """Equal triangles are paired, all but one if their number is odd; that they may be degenerate does not matter."""
    corners = np.tile(np.array(points, np.float32), (count, 1, 1))
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert (second == NO_PRIMITIVE).sum() == count % 2


def test_better_mate_is_taken():
    """Of two neighbours, the one that completes a square is chosen, although the other comes first."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, 0.5, 0]], np.float32)
    corners = points[[[0, 3, 4], [0, 1, 3], [1, 2, 3]]]
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert first.tolist() == [0, 1] and second.tolist() == [NO_PRIMITIVE, 2]


def test_mates_with_equal_keys_are_compared(monkeypatch):
    """Triangles whose edges only hash the same are no pair: here all edges do."""
    monkeypatch.setattr(pairs_module, "mix", lambda x: x & 0)
    corners = np.random.default_rng(0).random((100, 3, 3), np.float32)
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert (second == NO_PRIMITIVE).all()


def test_equal_triangles_of_a_strip():
    """Where all mates are equally good, none is left over."""
    places = np.arange(1002)
    zigzag = np.stack([places, places % 2, 0 * places], 1).astype(np.float32)
    corners = np.stack([zigzag[:-2], zigzag[1:-1], zigzag[2:]], 1)
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert np.array_equal(first, np.arange(0, 1000, 2)) and np.array_equal(second, first + 1)


def test_growing_triangles_of_a_strip():
    """Where every triangle likes its greater neighbour best, far more find a partner than one a round."""
    sizes, on_x = 1.02 ** np.arange(1002), np.arange(1002) % 2
    corner = np.stack([sizes * on_x, sizes * (1 - on_x), 0 * sizes], 1).astype(np.float32)
    corners = np.stack([corner[:-2], corner[1:-1], corner[2:]], 1)
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert share(corners, second) >= LEAST_SHARE


def test_mesh_on_top_of_itself():
    """Where four triangles meet at every edge, most still find a partner."""
    corners = sphere(30, shuffle=4)
    corners = np.concatenate([corners, corners[:, ::-1]])
    v, first, second = paired(corners)
    assert_valid(corners, v, first, second)
    assert share(corners, second) >= LEAST_SHARE
