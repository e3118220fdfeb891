"""Cheaper binary hierarchies by moving subtrees to where they cost least [MeisterReinsertion2018].

Of moves that would touch the same links only the one with the larger gain is made. Moves that are left can still
cut a part of the tree off: x goes below y while y goes below x. So a move is given up if one of higher rank takes
away a node between its target and where the path to it turns down; in every such cycle of moves the lowest in
rank is. All is decided by ranks, which do not depend on the order of lanes.

Differently from the paper, moves lock the links that they change and not the whole path, so that gains of one round are
not exactly additive, and a round tries a share of the nodes only: those with the largest part of their parent's box to
gain, less often those that lately found nothing. Both hardly lose quality (docs/bvh-build.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.accel.binary import levels, refit
from renderer.accel.boxes import half_area
from renderer.accel.search import NONE, Links, search
from renderer.core.backend import Bool, Float, UInt32
from renderer.core.numeric import greater

SHARE = 0.1  # of the nodes are tried in a round
DISCOURAGED = 0.1  # the promise of a node that found nothing is multiplied by this
SAMPLES = 4096  # nodes from which the threshold of the share is taken
LEAST_AREA = 1e-35  # keeps quotients of areas finite


@dataclass(frozen=True)
class Moves:
    """Subtrees and where they go, best first."""

    moved: UInt32
    removed: UInt32  # its parent, which becomes the parent of moved and target
    beside: UInt32  # its sibling, which takes the parent's place
    target: UInt32
    turn: UInt32  # the lowest common ancestor of moved and target

    def select(self, index):
        """Return the moves at places."""
        chosen = Moves(*(dr.gather(UInt32, part, index) for part in vars(self).values()))
        dr.eval(*vars(chosen).values())
        return chosen

    @property
    def touched(self):
        """Return the nodes that no two moves of one round may share."""
        return self.moved, self.removed, self.beside, self.target


def reinsert(tree, scale, rounds, max_depth):
    """Improve a tree in rounds, and return its `levels`; leave it as it was if there are more than `max_depth`."""
    before = UInt32(tree.child)  # a copy, as soon as the original changes
    weight = dr.full(Float, 1, tree.node_count)
    parent, sibling = _links(tree)
    for _ in range(rounds):
        links = Links(parent, sibling, half_area(tree.lo, tree.hi, scale))
        dr.eval(links.area)
        moves = _best_moves(tree, links, _candidates(tree, links, weight), weight, scale)
        if moves is None:
            break
        _relink(tree, links, moves)
        parent, sibling = _links(tree)
        grandparent = dr.gather(UInt32, links.parent, moves.removed)
        refit(tree, levels(tree, _above(tree, parent, moves.removed, grandparent)))
    by_depth = levels(tree)
    if len(by_depth) > max_depth:
        tree.child = before
        by_depth = levels(tree)
        refit(tree, by_depth)
    return by_depth


def _links(tree):
    """Return each node's parent and sibling."""
    place = dr.arange(UInt32, len(tree.child))
    parent, sibling = dr.full(UInt32, tree.root, tree.node_count), dr.zeros(UInt32, tree.node_count)
    dr.scatter(parent, (place >> 1) + tree.leaf_count, tree.child)
    dr.scatter(sibling, dr.gather(UInt32, tree.child, place ^ 1), tree.child)
    dr.eval(parent, sibling)
    return parent, sibling


def _candidates(tree, links, weight):
    """Return the nodes worth a search: the SHARE with the largest part of their parent's area to gain."""
    above = dr.gather(Float, links.area, links.parent)
    excess = above - links.area
    promise = weight * excess * excess / greater(above, Float(LEAST_AREA))
    dr.eval(promise)
    count = min(SAMPLES, tree.node_count)
    stride = dr.opaque(UInt32, tree.node_count // count)
    ranked = dr.sort(dr.gather(Float, promise, dr.arange(UInt32, count) * stride))
    threshold = dr.gather(Float, ranked, dr.opaque(UInt32, int(count * (1 - SHARE))))
    # the root stays where it is, and so its children have no place to go to
    tried = (promise >= threshold) & (promise > 0) & (links.parent != dr.opaque(UInt32, tree.root))
    dr.eval(tried)
    return dr.compress(tried)


def _best_moves(tree, links, candidates, weight, scale):
    """Return the Moves of one round, none of which is in another's way, or None; lower the weight of failures."""
    if len(candidates) < 2:
        return None
    gain, target, turn = search(tree, links, candidates, scale)
    less = dr.gather(Float, weight, candidates) * dr.opaque(Float, DISCOURAGED)
    dr.eval(gain, target, turn, less)
    dr.scatter(weight, less, candidates, gain == 0)
    dr.eval(weight)
    found = dr.compress(gain > 0)
    if not len(found):
        return None
    found = dr.gather(UInt32, found, dr.argsort(dr.gather(Float, gain, found), descending=True))
    removed, beside = dr.gather(UInt32, links.parent, candidates), dr.gather(UInt32, links.sibling, candidates)
    moves = Moves(candidates, removed, beside, target, turn).select(found)
    rank = dr.arange(UInt32, len(found))
    return moves.select(dr.compress(_uncrossed(links, moves, rank, _first(tree, moves, rank))))


def _first(tree, moves, rank):
    """Return which moves are the first in rank at all nodes that they touch."""
    owner = dr.full(UInt32, NONE, tree.node_count)
    for node in moves.touched:  # by default, Dr.Jit would compile a kernel for each number of nodes
        dr.scatter_reduce(dr.ReduceOp.Min, owner, rank, node, mode=dr.ReduceMode.Direct)
    dr.eval(owner)
    first = dr.full(Bool, True, len(rank))
    for node in moves.touched:
        first &= dr.gather(UInt32, owner, node) == rank
    return first


def _uncrossed(links, moves, rank, chosen):
    """Return which of the chosen moves go nowhere below a node that one of higher rank takes away."""
    mover = dr.full(UInt32, NONE, len(links.parent))
    dr.scatter(mover, rank, moves.moved, chosen)
    dr.eval(mover)

    def climb(node, free):
        return dr.gather(UInt32, links.parent, node), free & (dr.gather(UInt32, mover, node) >= rank)

    state = (moves.target + 0, chosen & True)
    free = dr.while_loop(state, lambda node, free: free & (node != moves.turn), climb, label="crossing")[1]
    dr.eval(free)
    return free


def _relink(tree, links, moves):
    """Make the moves."""
    def slot(node):
        parent = dr.gather(UInt32, links.parent, node)
        left, _ = tree.children(parent)
        return 2 * (parent - tree.leaf_count) + dr.select(left == node, UInt32(0), 1)

    places = slot(moves.removed), slot(moves.target), slot(moves.moved) ^ 1
    dr.eval(places)  # reads before writes
    for place, child in zip(places, (moves.beside, moves.removed, moves.target)):
        dr.scatter(tree.child, child, place)
    dr.eval(tree.child)


def _above(tree, parent, *nodes):
    """Return which nodes are these or above one of them, as Bool of all nodes."""
    marked, root = dr.zeros(Bool, tree.node_count), dr.opaque(UInt32, tree.root)
    dr.eval(marked)

    def climb(node):
        dr.scatter(marked, True, node)
        return (dr.gather(UInt32, parent, node),)

    for node in nodes:
        dr.while_loop((node + 0,), lambda node: node != root, climb, label="above")
        dr.eval(marked)
    return marked
