"""The lists of a uniform grid's cells, built in whole-array operations.

A level of the grid is made of cubes around all boxes, and one layer of cubes more, at which rays stop. Boxes are
entered, widened by a share of a cube's edge, into all cubes that they touch. The same boxes give the same bytes.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.accel.records import TAG
from renderer.core.backend import Float, Float64, UInt32
from renderer.core.numeric import greater, lesser

DENSITY = 16.0  # cells an item, where the other limits allow for as many
MOST_ENTRIES = 8  # an item, in the mean
MOST_CELLS = 1024  # along an axis
COARSER = 1.1  # by how much the edge grows while there are too many entries
# of a cell without a list, beside the number of crossings along any axis after which there may be one; rays stop at 0
EMPTY = 0x80000000
FARTHEST = 8  # crossings
LAST = 0x80000000  # bit of an entry: the last one of its cell
# words of a level's record: its lowest corner, edge, 1 / edge, cells along each axis, strides, and cell (0, 0, 0)
CORNER, EDGE, PER_EDGE, COUNTS, STRIDES, FIRST = 0, 3, 4, 5, 8, TAG


@dataclass(frozen=True)
class Layout:
    """Where the cells of a level are."""

    corner: tuple[float, float, float]  # lowest of the first cell
    edge: float  # scene units
    counts: tuple[int, int, int]  # cells along each axis, without the layer around them
    margin: float  # by which boxes are widened, scene units

    @property
    def strides(self):
        """How far neighbours along each axis are apart in the list of cells."""
        return 1, self.counts[0] + 2, (self.counts[0] + 2) * (self.counts[1] + 2)

    @property
    def cell_count(self):
        """Cells in the list."""
        return self.strides[2] * (self.counts[2] + 2)

    def record(self, cells_before):
        """Return the level's words, of which `cells_before` cells of other levels come first in the list."""
        floats = Float(*self.corner, self.edge, 1 / self.edge, *self.counts)
        integers = UInt32(*self.strides, *(0,) * (TAG - STRIDES - 3), cells_before + sum(self.strides))
        return dr.concat((dr.reinterpret_array(UInt32, floats), integers))


def edge_for(size, cells):
    """Return the edge of cubes of which about `cells` fill a box (three floats), however flat; 0 for a point."""
    sizes = sorted(size, reverse=True)
    for axes in (3, 2, 1):
        volume = 1.0
        for k in range(axes):
            volume *= sizes[k]
        edge = (volume / cells) ** (1 / axes)
        if sizes[axes - 1] >= edge > 0:
            break
    return max(edge, sizes[0] / MOST_CELLS)


def layout(lo, hi, bounds, edge, share):
    """Return the Layout of cells with at least this edge, so that there are at most MOST_ENTRIES an item.

    `bounds` are the lowest and the highest corner of all boxes (tuples); `share` is the margin's in the edge.
    """
    lowest, highest = bounds
    most = MOST_ENTRIES * len(lo.x)
    while True:
        margin = share * edge
        counts = tuple(int((high - low) / edge + 2 * share) + 1 for low, high in zip(lowest, highest))
        made = Layout(tuple(low - margin for low in lowest), edge, counts, margin)
        if counts == (1, 1, 1) or _entry_count(made, lo, hi) <= most:
            return made
        edge *= COARSER


def enter(made, lo, hi, entries_before):
    """Return the cells and the entries of a level (UInt32), whose first entry has the place `entries_before`.

    A cell holds the place of its first entry, or EMPTY and a number of crossings; an entry is an item's number, with
    LAST in a cell's last one. In a cell, items are in their order.
    """
    first, spans = _ranges(made, lo, hi)
    sizes = spans[0] * spans[1] * spans[2]
    starts = dr.prefix_sum(sizes)
    total = int(starts[-1] + sizes[-1])
    item = dr.zeros(UInt32, total)
    dr.scatter(item, UInt32(1), starts)
    item = dr.prefix_sum(item) + item - 1
    place = dr.arange(UInt32, total) - dr.gather(UInt32, starts, item)
    cell = dr.zeros(UInt32, total)
    for axis, stride in enumerate(made.strides):
        # the lanes that fill up the last packet read 0, and a division by that ends the process
        span = greater(dr.gather(UInt32, spans[axis], item), UInt32(1))
        quotient = place // span
        cell += (dr.gather(UInt32, first[axis], item) + place - quotient * span) * dr.opaque(UInt32, stride)
        place = quotient
    cell += dr.opaque(UInt32, sum(made.strides))
    dr.eval(cell, item)
    order = dr.argsort(cell)
    return _listed(made, dr.gather(UInt32, cell, order), dr.gather(UInt32, item, order), entries_before)


def _listed(made, cell, item, entries_before):
    """Return cells and entries from the sorted pairs of both."""
    here, total = dr.arange(UInt32, len(cell)), len(cell)
    before = dr.gather(UInt32, cell, here - 1, here > 0)
    after = dr.gather(UInt32, cell, here + 1, here + 1 < total)
    starts, ends = (here == 0) | (before != cell), (here + 1 == total) | (after != cell)
    cells = _clearances(made, cell)
    dr.scatter(cells, here + dr.opaque(UInt32, entries_before), cell, starts)
    entries = item | dr.select(ends, UInt32(LAST), 0)
    dr.eval(cells, entries)
    return cells, entries


def _clearances(made, full):
    """Return all cells as if they were empty, with the distance from the nearest in `full` or in the border layer.

    It is the largest of the three axes' differences, and found axis by axis.
    """
    place, rest = dr.arange(UInt32, made.cell_count), dr.arange(UInt32, made.cell_count)
    clear = dr.full(UInt32, FARTHEST, made.cell_count)
    for count in made.counts:
        width = dr.opaque(UInt32, count + 2)
        quotient = rest // width
        along = rest - quotient * width
        clear = dr.select((along == 0) | (along == width - 1), UInt32(0), clear)
        rest = quotient
    dr.scatter(clear, UInt32(0), full)
    for stride in made.strides:
        dr.eval(clear)
        nearest, stride, end = clear, dr.opaque(UInt32, stride), dr.opaque(UInt32, made.cell_count)
        for k in range(1, FARTHEST):
            # what is read across the border is farther away than the border
            before = dr.gather(UInt32, clear, place - k * stride, place >= k * stride)
            after = dr.gather(UInt32, clear, place + k * stride, place + k * stride < end)
            nearest = lesser(nearest, greater(lesser(before, after), UInt32(k)))
        clear = nearest
    return clear | EMPTY


def _ranges(made, lo, hi):
    """Return for each axis the first cell of every item, and how many there are."""
    first, spans = [], []
    for axis, count in enumerate(made.counts):
        low, per_edge, margin = (dr.opaque(Float, value) for value in (made.corner[axis], 1 / made.edge, made.margin))
        last = dr.opaque(Float, count - 1)
        begin = UInt32(lesser(greater((lo[axis] - margin - low) * per_edge, Float(0)), last))
        end = UInt32(lesser(greater((hi[axis] + margin - low) * per_edge, Float(0)), last))
        first.append(begin)
        spans.append(end - begin + 1)
    return first, spans


def _entry_count(made, lo, hi):
    """Return how many entries all items together need."""
    _, spans = _ranges(made, lo, hi)
    return dr.sum(Float64(spans[0]) * Float64(spans[1]) * Float64(spans[2]))[0]
