"""Cheaper binary hierarchies by moving subtrees to where they cost least [MeisterReinsertion2018].

Taking node x out removes its parent p, whose area is saved, and lets the boxes above shrink. Putting it back at node t
makes a new parent of both, and lets the boxes above t grow. Each x looks for the t with the largest gain: it climbs,
and on the way searches every subtree beside its path that may still hold something better (bounded by x's own area).

Of moves that would touch the same links only the one with the larger gain is made. Moves that are left can still
cut a part of the tree off: x goes below y while y goes below x. So a move is given up if a move of higher rank takes
away a node between its target and where the path to it turns down; in every such cycle of moves the lowest in
rank is. All is decided by ranks, which do not depend on the order of lanes.

Differently from the paper, gains add up over a round without locking the whole paths, and not all nodes are tried: only
those whose parent's box is much larger than their own, which hardly loses anything (docs/bvh-build.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.accel.binary import levels, refit
from renderer.accel.boxes import half_area, union
from renderer.core.backend import Bool, Float, UInt32
from renderer.core.numeric import greater

NONE = 0xFFFFFFFF  # no node, no rank
SHARE = 0.25  # of the nodes are tried in a round
STEPS = 64  # nodes that a search visits at most
STACK_SIZE = 32  # subtrees left for later; what finds no place is not searched
SAMPLES = 4096  # nodes from which the threshold of the share is taken
LEAST_AREA = 1e-35  # keeps quotients of areas finite


@dataclass(frozen=True)
class Links:
    """What a round asks of the tree as it was before, by node."""

    parent: UInt32  # the root's is the root
    sibling: UInt32
    area: Float  # half the surface area, in units of the scene


@dataclass(frozen=True)
class Moves:
    """Subtrees and where they go."""

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
    """Improve a tree in rounds, and return its `levels`; a round that makes more than `max_depth` is undone."""
    by_depth = None
    for _ in range(rounds):
        links = _links(tree, scale)
        moves = _best_moves(tree, links, _candidates(tree, links), scale)
        if moves is None:
            break
        before = UInt32(tree.child)  # a copy, as soon as the original changes
        _relink(tree, links, moves)
        deeper = levels(tree)
        if len(deeper) > max_depth:
            tree.child = before
            break
        by_depth = deeper
        refit(tree, by_depth)
    return by_depth or levels(tree)


def _links(tree, scale):
    """Return the Links of a tree."""
    place = dr.arange(UInt32, len(tree.child))
    parent, sibling = dr.full(UInt32, tree.root, tree.node_count), dr.zeros(UInt32, tree.node_count)
    dr.scatter(parent, (place >> 1) + tree.leaf_count, tree.child)
    dr.scatter(sibling, dr.gather(UInt32, tree.child, place ^ 1), tree.child)
    area = half_area(tree.lo, tree.hi, scale)
    dr.eval(parent, sibling, area)
    return Links(parent, sibling, area)


def _candidates(tree, links):
    """Return the nodes worth a search: the SHARE with the largest part of their parent's area to gain."""
    above = dr.gather(Float, links.area, links.parent)
    excess = above - links.area
    promise = excess * excess / greater(above, Float(LEAST_AREA))
    dr.eval(promise)
    count = min(SAMPLES, tree.node_count)
    stride = dr.opaque(UInt32, tree.node_count // count)
    ranked = dr.sort(dr.gather(Float, promise, dr.arange(UInt32, count) * stride))
    threshold = dr.gather(Float, ranked, dr.opaque(UInt32, int(count * (1 - SHARE))))
    # the root stays where it is, and so its children have no place to go to
    tried = (promise >= threshold) & (promise > 0) & (links.parent != dr.opaque(UInt32, tree.root))
    dr.eval(tried)
    return dr.compress(tried)


def _best_moves(tree, links, candidates, scale):
    """Return the Moves of one round, none of which is in another's way; None where nothing is gained."""
    if len(candidates) < 2:  # local memory does not work with a single lane
        return None
    gain, target, turn = _search(tree, links, candidates, scale)
    dr.eval(gain, target, turn)
    found = dr.compress(gain > 0)
    if not len(found):
        return None
    found = dr.gather(UInt32, found, dr.argsort(dr.gather(Float, gain, found), descending=True))
    removed, beside = dr.gather(UInt32, links.parent, candidates), dr.gather(UInt32, links.sibling, candidates)
    moves = Moves(candidates, removed, beside, target, turn).select(found)
    rank = dr.arange(UInt32, len(found))
    return moves.select(dr.compress(_uncrossed(links, moves, rank, _first(tree, moves, rank))))


def _search(tree, links, moved, scale):
    """Return gain, target and turn of the best move of each node; gain 0 where there is none."""
    moved_lo, moved_hi = tree.box(moved)
    moved_area = half_area(moved_lo, moved_hi, scale)
    removed = dr.gather(UInt32, links.parent, moved)
    removed_area = dr.gather(Float, links.area, removed)
    beside = dr.gather(UInt32, links.sibling, moved)
    root, most_steps = dr.opaque(UInt32, tree.root), dr.opaque(UInt32, STEPS)
    zero, none = dr.zeros(UInt32, len(moved)), dr.full(UInt32, NONE, len(moved))

    def climb(node, saved, turn, path_saved, path_lo, path_hi, active):
        """Go on with the sibling of `turn`, below which all is searched; the path ends above the root."""
        shrinks = active & (turn != removed)  # the parent does not shrink: it vanishes, which is counted from the start
        less = dr.gather(Float, links.area, turn, shrinks) - half_area(path_lo, path_hi, scale)
        path_saved = dr.select(shrinks, path_saved + less, path_saved)
        ends = active & (turn == root)
        active &= ~ends
        node = dr.select(active, dr.gather(UInt32, links.sibling, turn, active), node)
        saved = dr.select(active, path_saved, saved)
        above = dr.gather(UInt32, links.parent, turn, active)
        turn = dr.select(ends, none, dr.select(active, above, turn))
        return node, saved, turn, path_saved, active

    def advance(steps, node, saved, turn, path_saved, path_lo, path_hi, top, best, target, best_turn, stack):
        # take what was left for later, or go up
        pops, climbing = (node == NONE) & (top > 0), (node == NONE) & (top == 0)
        top = dr.select(pops, top - 1, top)
        node = dr.select(pops, stack[0].read(top, pops), node)
        saved = dr.select(pops, stack[1].read(top, pops), saved)
        node, saved, turn, path_saved, climbing = climb(node, saved, turn, path_saved, path_lo, path_hi, climbing)

        # the new parent of this node and the moved one
        here = turn != NONE
        lo, hi = tree.box(node, here)
        larger_lo, larger_hi = union(path_lo, path_hi, lo, hi)
        path_lo, path_hi = dr.select(climbing, larger_lo, path_lo), dr.select(climbing, larger_hi, path_hi)
        gain = saved - half_area(*union(lo, hi, moved_lo, moved_hi), scale)
        better = here & (gain > best) & (node != beside)
        best, target = dr.select(better, gain, best), dr.select(better, node, target)
        best_turn = dr.select(better, turn, best_turn)

        # below it, at least the moved node's own area is to be paid, and the growth of this one
        below = gain + half_area(lo, hi, scale)
        descends = here & (node >= tree.leaf_count) & (below - moved_area > best)
        left, right = tree.children(node, descends)
        pushes = descends & (top < STACK_SIZE)
        stack[0].write(right, top, pushes)
        stack[1].write(below, top, pushes)
        return (steps + 1, dr.select(descends, left, none), dr.select(descends, below, saved), turn, path_saved,
                path_lo, path_hi, top + dr.select(pushes, UInt32(1), 0), best, target, best_turn, stack)

    stack = (dr.alloc_local(UInt32, STACK_SIZE), dr.alloc_local(Float, STACK_SIZE))
    path_lo, path_hi = tree.box(beside)  # the box around what is left on the path when x is gone
    state = (zero + 0, beside, removed_area, removed + 0, removed_area + 0, path_lo, path_hi, zero + 0,
             Float(zero), none + 0, none + 0, stack)
    state = dr.while_loop(state, lambda steps, node, saved, turn, *rest: (steps < most_steps) & (turn != NONE),
                          advance, label="reinsertion")
    return state[8], state[9], state[10]


def _first(tree, moves, rank):
    """Return which moves are the first in rank at all nodes that they touch."""
    owner = dr.full(UInt32, NONE, tree.node_count)
    for node in moves.touched:
        dr.scatter_reduce(dr.ReduceOp.Min, owner, rank, node)
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
