"""The lists of a grid's cells: everything is in them, nothing twice, and there is a bound on how much that is."""

import itertools

import numpy as np
import pytest

from renderer.accel.grid import DENSITY, FAR_SHARE, NEAR_SHARE, Grid
from renderer.accel.grid_build import (
    EMPTY, FARTHEST, LAST, MOST_CELLS, MOST_ENTRIES, edge_for, enter, layout,
)
from renderer.core.backend import UInt32
from tests.accel import grid_inputs
from tests.accel.build_inputs import vector

INPUTS = grid_inputs.inputs()
INPUTS["far apart"] = INPUTS["soup"][:20] * 0.1 + 3 * INPUTS["soup"][20:40, :1]


def boxes(triangles):
    """Return the corners of triangles' boxes on the host and as lanes, and those of the box around all."""
    lo, hi = triangles.min(1).astype(np.float32), triangles.max(1).astype(np.float32)
    bounds = tuple(map(float, lo.min(0))), tuple(map(float, hi.max(0)))
    return lo, hi, vector(lo), vector(hi), bounds


def built(triangles, cells=2000, before=0):
    """Return one level's Layout, cells and entries as host arrays."""
    _, _, lo, hi, bounds = boxes(triangles)
    edge = max(edge_for([high - low for low, high in zip(*bounds)], cells), 1e-3)
    made = layout(lo, hi, bounds, edge, NEAR_SHARE)
    return made, *map(np.array, enter(made, lo, hi, before))


def lists(made, cells, entries, before=0):
    """Return the items of each cell, by the cell's place along the axes."""
    found = {}
    for cell in np.flatnonzero(cells < EMPTY):
        x, y, z = (int(cell) // made.strides[k] % (made.counts[k] + 2) - 1 for k in range(3))
        start = end = int(cells[cell]) - before
        while not entries[end] & LAST:
            end += 1
        found[x, y, z] = (entries[start:end + 1] & ~np.uint32(LAST)).tolist()
    return found


@pytest.mark.parametrize("name", ["soup", "flat", "huge among tiny", "identical", "in a row", "one"])
@pytest.mark.parametrize("before", [0, 1000])
def test_items_are_in_all_cells_that_they_touch(name, before):
    """And in their order, as a plain loop over cells has them; other levels' entries may come before."""
    made, cells, entries = built(INPUTS[name], before=before)
    lo, hi, *_ = boxes(INPUTS[name])
    expected = {}
    for item, (low, high) in enumerate(zip(lo.astype(float), hi.astype(float))):
        first, last = (np.floor((corner + sign * made.margin - made.corner) / made.edge).astype(int)
                       for corner, sign in ((low, -1), (high, 1)))
        spans = (range(max(a, 0), min(b, count - 1) + 1) for a, b, count in zip(first, last, made.counts))
        for cell in itertools.product(*spans):
            expected.setdefault(cell, []).append(item)
    got = lists(made, cells, entries, before)
    # where a box ends on a cell's plane, float32 may decide otherwise than float64
    different = [cell for cell in expected.keys() | got.keys() if got.get(cell) != expected.get(cell)]
    assert len(different) <= 0.002 * len(expected)
    assert sum(map(len, got.values())) == len(entries)


@pytest.mark.parametrize("name", ["one", "teapot in stadium", "far apart"])
def test_empty_cells_tell_how_far_they_are_from_others(name):
    """The largest difference along an axis to the nearest list or border, up to a limit; 0 in the border alone."""
    made, cells, _ = built(INPUTS[name], 20_000)
    shape = tuple(count + 2 for count in reversed(made.counts))
    cells = cells.reshape(shape)
    border = np.ones(shape, bool)
    border[1:-1, 1:-1, 1:-1] = False
    assert (cells[border] == EMPTY).all()
    reached, expected = border | (cells < EMPTY), np.full(shape, FARTHEST)
    for distance in range(FARTHEST):
        expected[reached & (expected == FARTHEST)] = distance
        padded = np.pad(reached, 1)
        for z, y, x in itertools.product(range(3), repeat=3):
            reached = reached | padded[z:z + shape[0], y:y + shape[1], x:x + shape[2]]
    empty = cells >= EMPTY
    assert np.array_equal(cells[empty] - EMPTY, expected[empty])
    assert name != "far apart" or (empty & (expected == FARTHEST)).any()


@pytest.mark.parametrize("name, count", [
    ("soup", 100_000), ("huge", 100_000), ("identical", 20_000), ("nested", 20_000), ("points", 100_000),
])
def test_memory_is_bounded(name, count):
    """Whatever the boxes: by the number of items."""
    rng = np.random.default_rng(1)
    centre, size = rng.random((count, 3)), np.full((count, 1), 0.01)
    if name == "huge":
        size[0] = 1.0
    elif name == "identical":
        centre[:], size[:] = 0.5, 0.3
    elif name == "nested":
        centre[:], size = 0.5, rng.random((count, 1))
    elif name == "points":
        centre[: count // 2], size[:] = 0.25, 0.0
    lo, hi = vector(centre - size), vector(centre + size)
    made = Grid.over(UInt32([0] * 16), lo, hi)
    levels = made.layouts
    assert len(made._entries) <= (2 * MOST_ENTRIES + 1) * count
    cells = sum(level.cell_count for level in levels)
    assert cells <= 2 * DENSITY * count + 1000 and len(made._cells) == cells
    assert levels[2].counts == (1, 1, 1)


@pytest.mark.parametrize("size", [(1, 1, 1), (1, 2, 5), (1, 1, 0), (3, 0, 0), (1e-6, 1, 1e-9), (1e9, 1e-9, 1)])
def test_cells_are_as_many_as_asked_for(size):
    """Within a factor, however flat the box, unless an axis would get too many."""
    edge = edge_for(size, 500)
    count = np.prod(np.maximum(np.ceil(np.array(size) / edge), 1))
    assert 250 <= count <= 1000
    assert edge_for(size, 1e12) >= 0.999 * max(size) / MOST_CELLS


def test_a_point_has_one_cell():
    """All boxes in one place, at the origin and elsewhere."""
    assert edge_for((0.0, 0.0, 0.0), 100) == 0
    for place in (0.0, 3.0, -1e12):
        points = vector(np.full((5, 3), place))
        assert [level.counts for level in Grid.over(UInt32([0] * 80), points, points).layouts] == [(1, 1, 1)] * 3


def test_margins_serve_rays_that_start_in_the_scene():
    """Also where coordinates are large beside the extent."""
    for offset in (0.0, 1e3, 1e6):
        _, _, lo, hi, _ = boxes(grid_inputs.soup() * 100 + offset)
        made = Grid.over(UInt32([0] * 16), lo, hi).layouts
        reach = max(abs(np.array(hi)).max(), abs(np.array(lo)).max())
        assert made[0].margin >= 0.999 * 64 * 2.0**-24 * 2 * reach
        assert made[0].margin == pytest.approx(NEAR_SHARE * made[0].edge)
        assert made[1].margin == pytest.approx(FAR_SHARE * made[1].edge) and made[1].edge >= 8 * made[0].edge


def test_the_same_boxes_give_the_same_bytes():
    """Entries in a cell keep the order of the items."""
    first, second = (built(INPUTS["soup"]) for _ in range(2))
    assert first[0] == second[0] and all(map(np.array_equal, first[1:], second[1:]))
