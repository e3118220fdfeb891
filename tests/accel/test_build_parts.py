"""The steps of building a hierarchy, each beside a plain twin: curve, merging, moving, collapsing."""

import drjit as dr
import numpy as np
import pytest

from renderer.accel import ploc
from renderer.accel import reinsert as reinsertion
from renderer.accel.binary import BinaryTree, levels
from renderer.accel.boxes import scene_scale
from renderer.accel.collapse import collapse
from renderer.accel.morton import CELLS, morton_order
from renderer.accel.ploc import build_binary
from renderer.accel.reinsert import Moves, reinsert
from renderer.accel.search import Links, search
from renderer.core.backend import Bool, Float, UInt32
from tests.accel.build_inputs import INPUTS, half_areas, vector
from tests.accel.test_build import HARD, random_boxes

SEEDS = range(5)


def binary_tree(lo, hi, max_depth=64):
    """Return the BinaryTree over boxes, which are put in order before, and the scale of the scene."""
    lanes = vector(lo), vector(hi)
    lowest, scale = scene_scale(*lanes)
    order = np.array(morton_order(*lanes, lowest, scale))
    return build_binary(vector(lo[order]), vector(hi[order]), scale, max_depth), scale


class Twin:
    """A binary tree in plain Python."""

    def __init__(self, tree):
        self.count = tree.node_count // 2 + 1
        self.lo, self.hi = np.array(tree.lo).T.astype(float), np.array(tree.hi).T.astype(float)
        self.child = {self.count + k: pair for k, pair in enumerate(np.array(tree.child).reshape(-1, 2).tolist())}
        self.root = tree.root
        self.area = half_areas(self.lo, self.hi)

    @property
    def parent(self):
        """Return {node: its parent}."""
        return {child: node for node, pair in self.child.items() for child in pair}

    def below(self, node):
        """Return a node and all below it."""
        return [node] + [n for child in self.child.get(node, ()) for n in self.below(child)]

    def box(self, node):
        """Return the corners of a node, from its primitives."""
        leaves = [n for n in self.below(node) if n < self.count]
        return self.lo[leaves].min(0), self.hi[leaves].max(0)

    def total_area(self):
        """Return the area of all inner nodes."""
        return sum(half_areas(*self.box(node)) for node in self.below(self.root) if node >= self.count)

    def moved(self, node, target):
        """Return the total area after a move."""
        kept, parent = self.child, self.parent
        removed = parent[node]
        beside = sum(kept[removed]) - node
        self.child = {n: [beside if c == removed else c for c in pair] for n, pair in kept.items() if n != removed}
        self.child = {n: [removed if c == target else c for c in pair] for n, pair in self.child.items()}
        self.child[removed] = [node, target]
        total, self.child = self.total_area(), kept
        return total

    def best_gain(self, node):
        """Return the largest decrease of area by moving a node beside one that is neither above nor below it."""
        parent, path = self.parent, [node]
        while path[-1] != self.root:
            path.append(parent[path[-1]])
        beside = sum(self.child[parent[node]]) - node
        targets = set(self.below(self.root)) - set(path) - set(self.below(node)) - {beside}
        return max([0, *(self.total_area() - self.moved(node, target) for target in targets)])

    def cuts(self, node, width):
        """Return all sets of at most `width` nodes that the primitives of a node can be divided among."""
        if node < self.count or width == 1:
            return [[node]]
        left, right = self.child[node]
        both = [a + b for a in self.cuts(left, width - 1) for b in self.cuts(right, width - 1)]
        return [[node]] + [cut for cut in both if len(cut) <= width]

    def least_cost(self, node, width):
        """Return the least area of wide nodes for a subtree."""
        if node < self.count:
            return 0
        cuts = [cut for cut in self.cuts(node, width) if cut != [node]]
        return self.area[node] + min(sum(self.least_cost(part, width) for part in cut) for cut in cuts)


@pytest.mark.parametrize("seed", SEEDS)
def test_order_is_that_of_the_interleaved_bits(seed):
    """Points in the middle of cells come in the order of their codes, and equal ones in their own."""
    rng = np.random.default_rng(seed)
    cells = rng.integers(0, 2, (500, 3)) << rng.integers(0, 20, (500, 3))  # few bits, so that each decides somewhere
    cells[250:] += 1 << rng.integers(0, 19, (250, 3))
    cells[100:200], cells[-2], cells[-1] = cells[:100], 0, CELLS - 1
    points = vector((cells + 0.5) / CELLS)
    order = morton_order(points, points, vector(np.zeros((1, 3))), dr.opaque(Float, 1))
    codes = [sum((int(c) >> bit & 1) << (3 * bit + 2 - axis) for bit in range(20) for axis, c in enumerate(cell))
             for cell in cells]
    assert np.array(order).tolist() == sorted(range(500), key=codes.__getitem__)


@pytest.mark.parametrize("name", ["quadratic spacing", "geometric spacing", "all the same", "one huge among tiny"])
@pytest.mark.parametrize("max_depth", [15, 16, 20])
def test_merging_keeps_to_its_depth(name, max_depth):
    """20,000 boxes need at least 15 levels, and get no more than are allowed."""
    tree, _ = binary_tree(*HARD[name], max_depth)
    assert 15 <= len(levels(tree)) <= max_depth


@pytest.mark.parametrize("seed", SEEDS)
def test_search_finds_the_best_move(seed, monkeypatch):
    """The gain is that of the best of all moves, and the target attains it, in a tree that leaves much to gain."""
    monkeypatch.setattr(ploc, "LEAST_MERGED", 1)
    tree, scale = binary_tree(*random_boxes(18, seed))
    twin = Twin(tree)
    moved = [node for node, parent in twin.parent.items() if parent != twin.root]
    parent, sibling = reinsertion._links(tree)
    area = Float(twin.area.astype(np.float32) * np.float32(scale[0]) ** 2)
    gain, target, _ = (np.array(part) for part in search(tree, Links(parent, sibling, area), UInt32(moved), scale))
    assert (gain > 0).sum() >= 3
    unit = 1 / scale[0] ** 2
    for node, found, place in zip(moved, gain * unit, target):
        assert found == pytest.approx(twin.best_gain(node), abs=1e-5 * twin.area[twin.root])
        if found > 1e-4:
            assert found == pytest.approx(twin.total_area() - twin.moved(node, place), rel=1e-3)


@pytest.mark.parametrize("name", INPUTS)
def test_boxes_fit_after_moves(name):
    """What is not looked at again did not change: the boxes of all nodes are those of their primitives."""
    tree, scale = binary_tree(*INPUTS[name](500))
    before = Twin(tree)
    reinsert(tree, scale, 3, 64)
    after = Twin(tree)
    assert after.child != before.child and after.total_area() < before.total_area()
    for node in after.child:
        assert np.array_equal(np.stack(after.box(node)), [after.lo[node], after.hi[node]])


def test_deeper_tree_than_allowed_is_not_kept():
    """Moves that make paths too long are all undone."""
    boxes = INPUTS["stadium"](3000)
    tree, scale = binary_tree(*boxes)
    before, depth = Twin(tree), len(levels(tree))
    assert len(reinsert(tree, scale, 4, depth)) == depth
    after = Twin(tree)
    assert after.child == before.child
    assert np.array_equal(after.lo, before.lo) and np.array_equal(after.hi, before.hi)
    assert len(reinsert(tree, scale, 4, 64)) > depth


# root 10 = (8, 9), 8 = (6, 0), 9 = (7, 1), 6 = (2, 3), 7 = (4, 5)
PAIRS = {6: (2, 3), 7: (4, 5), 8: (6, 0), 9: (7, 1), 10: (8, 9)}


@pytest.mark.parametrize("moves, kept", [
    ([(6, 8, 0, 4, 10), (7, 9, 1, 2, 10)], [True, False]),  # 6 below 7 and 7 below 6
    ([(7, 9, 1, 2, 10), (6, 8, 0, 4, 10)], [True, False]),
    ([(6, 8, 0, 1, 10), (7, 9, 1, 0, 10)], [True, True]),  # nothing below what is taken away
    ([(4, 7, 5, 2, 10), (7, 9, 1, 0, 10)], [True, True]),  # out of what is taken away
])  # fmt: skip
def test_moves_below_each_other_are_not_both_made(moves, kept):
    """Of moves that would cut a part of the tree off, the one of lower rank is given up."""
    parent = {child: node for node, pair in PAIRS.items() for child in pair}
    links = Links(UInt32([parent.get(node, 10) for node in range(11)]), None, None)
    columns = Moves(*(UInt32(list(column)) for column in zip(*moves)))
    free = reinsertion._uncrossed(links, columns, dr.arange(UInt32, 2), dr.full(Bool, True, 2))
    assert list(free) == kept


@pytest.mark.parametrize("moves, kept", [
    ([(6, 8, 0, 4, 10), (7, 9, 1, 2, 10)], [True, True]),
    ([(2, 6, 3, 4, 10), (3, 6, 2, 5, 10)], [True, False]),  # the same parent vanishes
    ([(2, 6, 3, 1, 10), (7, 9, 1, 0, 10)], [True, False]),  # a target that takes another's place
    ([(2, 6, 3, 4, 10), (4, 7, 5, 0, 10)], [True, False]),  # a target that leaves
])  # fmt: skip
def test_moves_of_the_same_links_are_not_both_made(moves, kept):
    """Only the first in rank of those that touch a node is made."""
    tree = BinaryTree(vector(np.zeros((11, 3))), vector(np.zeros((11, 3))), None, 10, UInt32(6))
    columns = Moves(*(UInt32(list(column)) for column in zip(*moves)))
    assert list(reinsertion._first(tree, columns, dr.arange(UInt32, 2))) == kept


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("width", [2, 3, 4, 6])
def test_collapse_is_the_cheapest(width, seed):
    """No other choice of nodes of the binary tree costs less."""
    tree, scale = binary_tree(*random_boxes(14, seed))
    twin = Twin(tree)
    nodes, _, count, _ = collapse(tree, levels(tree), width, scale)
    inner = np.array(nodes)[np.array(count) > 0]
    assert twin.area[inner].sum() == pytest.approx(twin.least_cost(tree.root, width), rel=1e-5)
