"""Traversal of a uniform grid in lanes: from cell to cell along the ray, in the order of the ray [Amanatides1987].

A lane is in one cell. In every iteration it goes on if the cell has no list, or its end was reached, and tests one
entry if it is at one; so no lane waits for the fullest cell of its packet. Empty cells know how far the nearest list
is, and are left behind that many at once, as in [Cohen1994]. A crossing's distance is computed from the number of
crossings before it, so that errors do not add up on the way. Every step crosses a plane, and the layer of cells around
all others stops everything: a walk takes at most one step a plane, and one an entry on its way.

**No item is missed.** A leaf test may find a hit off its box by the rounding of `slabs`, and the way through the cells
is off by less than that again: GRID_ROUNDOFFS of |o| + reach together. As long as this is less than the margin by which
boxes were widened when they were entered into cells, the cell in which the walk is at the distance of a hit has the
item in its list, and the walk goes on until it is there. Therefore rays from farther away take a coarser level with a
wider margin, and those from beyond that the last level: a single cell, in which everything is. For a scene of
extent 1 whose first level has N cells along its longest side, the levels reach to origins at about 16000 / N and
500000 / N.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.accel.grid_build import (
    CORNER, COUNTS, DENSITY, EDGE, EMPTY, FIRST, LAST, PER_EDGE, STRIDES, edge_for, enter, layout,
)
from renderer.accel.records import closest, read
from renderer.accel.slabs import BOX_ROUNDOFFS, Slabs
from renderer.core.backend import Float, UInt32, Vector3f
from renderer.core.numeric import EPSILON, greater, largest, lesser, widened

GRID_ROUNDOFFS = 2 * BOX_ROUNDOFFS  # of |o| + reach
NEAR_SHARE, FAR_SHARE = 1 / 16, 1 / 4  # of the margins in the edges
FAR_EDGE = 8.0  # edge of the coarser level over that of the first
LEAST_EDGE = 1e-30  # scene units
NEVER = 1e38  # along an axis that a ray does not leave its cell on; infinity times no crossing would be NaN


@dataclass
class Walk:
    """Where a lane is in the grid."""

    word: UInt32  # place in the cell's list, or EMPTY and how many crossings are free
    cell: UInt32
    crossed: Vector3f  # planes crossed along each axis


@dataclass
class Course:
    """What a lane's way is made of: plane k along an axis is crossed at the distance first + k pitch."""

    first: Vector3f
    pitch: Vector3f
    per_pitch: Vector3f  # 1 / pitch
    strides: list  # for each axis the difference of cells, modulo 2^32


class Grid:
    """The interface of Bvh, by a grid of cubes with lists of the items in them."""

    def __init__(self, leaves, levels, bounds):
        """Hold leaf records (UInt32, evaluated) in `levels`, [(Layout, cells, entries)] as `over` makes them."""
        lowest, highest = bounds
        self._leaves, self.layouts = leaves, [level[0] for level in levels]
        self._cells, self._entries = (dr.concat([level[k] for level in levels]) for k in (1, 2))
        before = [sum(other[0].cell_count for other in levels[:k]) for k in range(len(levels))]
        self._levels = dr.concat([level[0].record(count) for level, count in zip(levels, before)])
        self._margins = [dr.opaque(Float, level[0].margin) for level in levels[:-1]]
        self._reach = dr.opaque(Float, max(map(abs, (*lowest, *highest))))
        self._lowest, self._highest = ([dr.opaque(Float, value) for value in corner] for corner in bounds)
        dr.eval(self._cells, self._entries, self._levels)

    @classmethod
    def over(cls, leaves, lo, hi, density=DENSITY):
        """Return the grid over items with leaf records (UInt32, 16 words each) and boxes (Vector3f, finite, lo <= hi).

        There must be at least one; boxes may be flat, points, or all the same; the extent must stay below 1e37.
        `density` is the number of cells an item where the other limits allow for as many.
        """
        dr.eval(lo, hi)
        bounds = tuple(dr.min(axis)[0] for axis in lo), tuple(dr.max(axis)[0] for axis in hi)
        size = [high - low for low, high in zip(*bounds)]
        reach = max(abs(value) for corner in bounds for value in corner)
        # so large that the first level serves rays that start in the scene
        least = 2 * reach * GRID_ROUNDOFFS * EPSILON / NEAR_SHARE
        near = layout(lo, hi, bounds, max(edge_for(size, density * len(lo.x)), least, LEAST_EDGE), NEAR_SHARE)
        far = layout(lo, hi, bounds, FAR_EDGE * near.edge, FAR_SHARE)
        whole = layout(lo, hi, bounds, max(4 * max(size), LEAST_EDGE), FAR_SHARE)
        levels, entries = [], 0
        for made in (near, far, whole):
            levels.append((made, *enter(made, lo, hi, entries)))
            entries += len(levels[-1][2])
        return cls(leaves, levels, bounds)

    def trace(self, ray, t, index, leaf, active, any_hit=False):
        """Return distance and index of the closest hit of each active ray, or of any; else what was given."""
        lanes = max(dr.width(ray), dr.width(t), dr.width(active))
        t, index, active = (widened(value, lanes) for value in (t, index, active))
        walk, course, active = self._start(ray, t, active, lanes)
        _, t, index, _ = dr.while_loop(
            (walk, t, index, active),
            lambda walk, t, index, active: active,
            lambda walk, t, index, active: self._step(walk, course, t, index, leaf, active, any_hit),
            label="grid",
        )
        return t, index

    def _start(self, ray, t, active, lanes):
        """Return the walks where rays enter the grid, their courses, and which rays enter at all."""
        slabs = Slabs.of(ray, Vector3f(0), self._reach)
        near, far = Float(0), t
        for axis in range(3):
            low, high = self._lowest[axis], self._highest[axis]
            negative, slack = slabs.negative[axis], slabs.slacks[0][axis]
            enters, leaves = dr.select(negative, high, low), dr.select(negative, low, high)
            near = greater(dr.fma(enters - ray.o[axis], slabs.rates[0][axis], -slack), near)
            far = lesser(dr.fma(leaves - ray.o[axis], slabs.rates[0][axis], slack), far)
        active = active & (near <= far)

        rounding = (largest(ray.o) + self._reach) * Float(GRID_ROUNDOFFS * EPSILON)
        near_by, not_far = (rounding <= margin for margin in self._margins)
        level = dr.select(near_by, UInt32(0), dr.select(not_far, UInt32(1), 2))
        words = read(self._levels, widened(level, lanes), active)
        floats = [dr.reinterpret_array(Float, word) for word in words[:STRIDES]]
        cell, first, strides = words[FIRST], Vector3f(0), []
        for axis in range(3):
            negative, corner = slabs.negative[axis], floats[CORNER + axis]
            position = (dr.fma(ray.d[axis], near, ray.o[axis]) - corner) * floats[PER_EDGE]
            place = UInt32(lesser(greater(position, Float(0)), floats[COUNTS + axis] - 1))
            cell = cell + place * words[STRIDES + axis]
            plane = dr.fma(Float(place) + dr.select(negative, Float(0), 1), floats[EDGE], corner)
            first[axis] = greater((plane - ray.o[axis]) * slabs.rates[0][axis], Float(-NEVER))
            strides.append(dr.select(negative, 0 - words[STRIDES + axis], words[STRIDES + axis]))
        pitch = Vector3f(*(lesser(abs(rate) * floats[EDGE], Float(3 * NEVER)) for rate in slabs.rates[0]))
        per_pitch = abs(ray.d) * floats[PER_EDGE]
        course = Course(first, pitch, per_pitch, strides)
        return Walk(dr.gather(UInt32, self._cells, cell, active), cell, dr.zeros(Vector3f, lanes)), course, active

    def _step(self, walk, course, t, index, leaf, active, any_hit):
        """Return the walk at the next entry or cell, the closest hit so far, and which lanes are not yet done."""
        walk, active = self._cross(walk, course, t, active)
        tests = active & (walk.word < EMPTY)
        entry = dr.gather(UInt32, self._entries, walk.word, tests)
        t, index, closer = closest(t, index, tests, *leaf(read(self._leaves, entry & ~UInt32(LAST), tests)))
        following = dr.select(entry >= LAST, UInt32(EMPTY + 1), walk.word + 1)
        walk = Walk(dr.select(tests, following, walk.word), walk.cell, walk.crossed)
        return walk, t, index, active if any_hit is False else active & ~(closer & any_hit)

    def _cross(self, walk, course, t, active):
        """Return the walk with lanes in empty cells one cell further or more, and which lanes are not yet done.

        Where `clear` crossings are free along every axis, the lane goes on until an axis has used them up.
        """
        clear = Float(walk.word & ~UInt32(EMPTY))
        ahead = walk.crossed + (clear - 1)
        x, y, z = (dr.fma(ahead[k], course.pitch[k], course.first[k]) for k in range(3))
        # one of the three is true, whatever is NaN: with every step the lane comes nearer to the border
        along_x = (x <= y) & (x <= z)
        along_y = ~along_x & (y <= z)
        ways = (along_x, along_y, ~along_x & ~along_y)
        distance = dr.select(along_x, x, dr.select(along_y, y, z))
        goes = active & (walk.word >= EMPTY)
        through = goes & (distance > t)
        goes = goes & ~through

        cell, crossed = walk.cell, Vector3f(0)
        for k in range(3):
            before = walk.crossed[k]
            others = dr.ceil((distance - course.first[k]) * course.per_pitch[k])
            now = dr.select(ways[k], before + clear, lesser(greater(others, before), ahead[k]))
            crossed[k] = dr.select(goes, now, before)
            cell = cell + UInt32(crossed[k] - before) * course.strides[k]
        word = dr.select(goes, dr.gather(UInt32, self._cells, cell, goes), walk.word)
        return Walk(word, cell, crossed), active & ~through & (word != EMPTY)
