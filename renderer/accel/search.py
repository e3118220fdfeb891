"""The search of reinsertion: where else in a binary hierarchy a subtree would cost least.

Taking node x out removes its parent p, whose area is saved, and lets the boxes above shrink. Putting it back at node t
makes a new parent of both, and lets the boxes above t grow. A lane climbs from its x to the root; on the way it
searches every subtree beside its path that may still hold something better than the best found: below a node, at least
x's own area and the growth of the boxes down to there have to be paid.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr

from renderer.accel.boxes import half_area, union
from renderer.core.backend import Float, UInt32, Vector3f

NONE = 0xFFFFFFFF  # no node
STEPS = 64  # nodes that a search visits at most
STACK_SIZE = 32  # subtrees left for later; what finds no place is not searched


@dataclass(frozen=True)
class Links:
    """What a search asks of the tree, by node."""

    parent: UInt32  # the root's is the root
    sibling: UInt32
    area: Float  # half the surface area, in units of the scene


@dataclass(frozen=True)
class Subtree:
    """What is to be moved."""

    lo: Vector3f
    hi: Vector3f
    area: Float
    parent: UInt32
    sibling: UInt32


@dataclass
class Progress:
    """The state of a search."""

    steps: UInt32  # nodes visited
    node: UInt32  # to be visited next; NONE: from the stack, or by climbing
    saved: Float  # area saved, less the growth above the node
    turn: UInt32  # the highest node of the path yet, below which all is searched but one side; NONE: search is over
    path_saved: Float  # area saved below it
    path_lo: Vector3f  # box of what is left below it
    path_hi: Vector3f
    best: Float  # largest gain
    target: UInt32  # where it is
    target_turn: UInt32  # where the path to it turns down
    waiting: UInt32  # subtrees on the stack
    nodes: dr.Local
    saves: dr.Local


def search(tree, links, moved, scale):
    """Return the gain of the best move of each node, its target, and their lowest common ancestor.

    The gain is in units of `links.area`, and 0 where no move is better than none. Two nodes at least must be asked
    for, because local memory does not work with a single lane; the root and its children have no place to go to.
    """
    parent, sibling = dr.gather(UInt32, links.parent, moved), dr.gather(UInt32, links.sibling, moved)
    lo, hi = tree.box(moved)
    subtree = Subtree(lo, hi, half_area(lo, hi, scale), parent, sibling)
    root, most_steps = dr.opaque(UInt32, tree.root), dr.opaque(UInt32, STEPS)

    def visit(progress):
        progress, climbs = _next(tree, links, subtree, progress, root, scale)
        return (_visit(tree, subtree, progress, climbs, scale),)

    state = dr.while_loop((_start(tree, links, subtree),),
                          lambda progress: (progress.steps < most_steps) & (progress.turn != NONE),
                          visit, label="reinsertion")
    return state[0].best, state[0].target, state[0].target_turn


def _start(tree, links, subtree):
    """Return the state before the first step, which visits the sibling."""
    lanes = dr.width(subtree.area)
    path_lo, path_hi = tree.box(subtree.sibling)
    saved = dr.gather(Float, links.area, subtree.parent)  # the parent vanishes

    def full(array_type, value):
        return dr.full(array_type, value, lanes)

    return Progress(full(UInt32, 0), subtree.sibling + 0, saved, subtree.parent + 0, saved + 0, path_lo, path_hi,
                    full(Float, 0), full(UInt32, NONE), full(UInt32, NONE), full(UInt32, 0),
                    dr.alloc_local(UInt32, STACK_SIZE), dr.alloc_local(Float, STACK_SIZE))


def _next(tree, links, subtree, now, root, scale):
    """Return the state with a node to visit, from the stack or from one level higher, and whether it is the latter."""
    pops, climbs = (now.node == NONE) & (now.waiting > 0), (now.node == NONE) & (now.waiting == 0)
    waiting = dr.select(pops, now.waiting - 1, now.waiting)
    node = dr.select(pops, now.nodes.read(waiting, pops), now.node)
    saved = dr.select(pops, now.saves.read(waiting, pops), now.saved)

    # the node left behind shrinks to its path's box, unless it is the parent, which is counted already
    shrinks = climbs & (now.turn != subtree.parent)
    less = dr.gather(Float, links.area, now.turn, shrinks) - half_area(now.path_lo, now.path_hi, scale)
    path_saved = dr.select(shrinks, now.path_saved + less, now.path_saved)
    ends = climbs & (now.turn == root)
    climbs &= ~ends
    node = dr.select(climbs, dr.gather(UInt32, links.sibling, now.turn, climbs), node)
    saved = dr.select(climbs, path_saved, saved)
    above = dr.gather(UInt32, links.parent, now.turn, climbs)
    turn = dr.select(ends, UInt32(NONE), dr.select(climbs, above, now.turn))
    return replace(now, waiting=waiting, node=node, saved=saved, path_saved=path_saved, turn=turn), climbs


def _visit(tree, subtree, now, climbs, scale):
    """Return the state after its node was tried as a target, and its children were taken up if they may be better."""
    here = now.turn != NONE
    lo, hi = tree.box(now.node, here)
    larger_lo, larger_hi = union(now.path_lo, now.path_hi, lo, hi)
    gain = now.saved - half_area(*union(lo, hi, subtree.lo, subtree.hi), scale)
    # beside its sibling the subtree is already, which rounding must not count as a gain
    better = here & (gain > now.best) & (now.node != subtree.sibling)
    best = dr.select(better, gain, now.best)

    below = gain + half_area(lo, hi, scale)
    descends = here & (now.node >= tree.leaf_count) & (below - subtree.area > best)
    left, right = tree.children(now.node, descends)
    pushes = descends & (now.waiting < STACK_SIZE)
    now.nodes.write(right, now.waiting, pushes)
    now.saves.write(below, now.waiting, pushes)
    return replace(
        now, steps=now.steps + 1, node=dr.select(descends, left, UInt32(NONE)),
        saved=dr.select(descends, below, now.saved), waiting=now.waiting + dr.select(pushes, UInt32(1), 0),
        path_lo=dr.select(climbs, larger_lo, now.path_lo), path_hi=dr.select(climbs, larger_hi, now.path_hi),
        best=best, target=dr.select(better, now.node, now.target),
        target_turn=dr.select(better, now.turn, now.target_turn))
