"""Traversal of a bounding volume hierarchy, four children a node, in lanes.

A lane is at one record, a node or a leaf: both have one size, so that a single fetch serves lanes that are at either.
Of a node it enters the nearest child that the ray meets; the others wait on the stack as one word, in their order:
the first child's record, and three slots of two bits, the last one repeated to mark the end. The last few words are in
registers, where lanes shift them up and down; memory, which lanes reach one by one, holds the others. All lanes do both
tests in every step, because to fetch a record costs more than to compute.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.accel.build import MAX_DEPTH
from renderer.accel.records import HIGH_HALF, LEAF, ORIGIN, TAG, WIDTH, WORDS, closest, read
from renderer.accel.slabs import Slabs
from renderer.core.backend import Bool, Float, UInt32
from renderer.core.errors import RenderError
from renderer.core.numeric import greater, lesser, widened

STACK_TOP = MAX_DEPTH - 1  # in the kernel as a literal, because Dr.Jit 1.5 knows stacks of different sizes as the same
REGISTERS = 7  # entries of the stack that are not in memory
SLOT_BITS, SLOT = 2, 3
WAITING_BITS = 3 * SLOT_BITS
MAX_RECORDS = 1 << (32 - WAITING_BITS)
MISSED = 0xFFFFFFFF


@dataclass
class Walk:
    """Where a lane is in the hierarchy."""

    record: UInt32
    height: UInt32  # entries on the stack
    top: list  # those that were pushed last, UInt32, the very last one first; others in the order in which they came
    stack: dr.Local


class Bvh:
    """A hierarchy over leaf records; `leaf` is a function (words) -> (met, t, index) that tests one for each lane.

    The words are those of `records`; what it returns only counts where the words are a leaf's.
    """

    def __init__(self, records, middle, radius):
        """Hold `records` (UInt32, evaluated) of a scene that reaches `radius` from `middle` along each axis.

        Raises: RenderError for more records than the stack's words can name.
        """
        count = len(records) // WORDS
        if count > MAX_RECORDS:
            raise RenderError(f"too many shapes for a hierarchy: it has {count} records, and can have {MAX_RECORDS}")
        self._records, self._middle, self._radius = records, middle, radius

    def words(self, record, active):
        """Return the words of a record in each active lane."""
        return read(self._records, record, active)

    def slabs(self, ray):
        """Return what `step` needs of the rays."""
        return Slabs.of(ray, self._middle, self._radius)

    def start(self, lanes):
        """Return lanes at the root."""
        top = [dr.zeros(UInt32, lanes) for _ in range(REGISTERS)]
        return Walk(dr.zeros(UInt32, lanes), dr.zeros(UInt32, lanes), top, dr.alloc_local(UInt32, MAX_DEPTH))

    def fetch(self, walk, active):
        """Return what `step` reads from memory."""
        return self.words(walk.record, active)

    def step(self, walk, words, slabs, t, index, leaf, active, any_hit, jump=False):
        """Return the walk one record further, the closest hit so far, and which lanes are not yet done.

        `words` are those that `fetch` returned. Lanes with `any_hit` are done as soon as something closer than their t
        was met. `jump` is for coherent rays: leaf tests are jumped over where no lane of a packet is at a leaf.
        """
        walk, goes_on, here = self._follow(walk, words, _entries(words, slabs, t), active)

        def test(t, index, closer):
            return closest(t, index, here, *leaf(words))

        state = t, index, dr.zeros(Bool, dr.width(t))
        t, index, closer = dr.if_stmt(state, here, test, lambda *state: state, label="leaf") if jump else test(*state)
        return walk, t, index, goes_on if any_hit is False else goes_on & ~(closer & any_hit)

    def _follow(self, walk, words, entries, active):
        """Return the walk at its next record, whether there is one, and which lanes were at a leaf."""
        at_leaf = words[TAG] >= LEAF
        nearest, *others = _sorted(entries)
        enters = active & (nearest != MISSED) & ~at_leaf

        # what waits: the other children, or what is left on top of the stack when its next child is taken
        pushes = enters & (others[0] != MISSED)
        pops = active & ~enters & (walk.height > 0)
        top = walk.top[0]
        next_slot, rest, keeps = _take(top)
        drops = pops & ~keeps
        following = dr.select(enters, words[TAG] + (nearest & SLOT), (top >> WAITING_BITS) + next_slot)
        place = dr.select(enters | pops, following, walk.record)
        walk = _stacked(walk, pushes, drops, dr.select(pops, rest, top), _waiting(words[TAG], others))
        walk.record = place
        return walk, enters | pops, active & at_leaf

    def trace_groups(self, rays, hits, leaves):
        """Return [(distance, index)] of the closest hit of each of a lane's valid rays, which share one walk.

        `hits` are what they begin with, `leaves` their leaf tests. Pays where the rays go about the same way: a record
        is fetched once for all of them, and a box tested once.
        """
        slabs, lanes = Slabs.of_group(rays, self._middle, self._radius), dr.width(rays[0])
        hits = [tuple(widened(part, lanes) for part in hit) for hit in hits]

        def step(walk, active, hits):
            words = self.fetch(walk, active)
            farthest = hits[0][0]
            for t, _ in hits[1:]:
                farthest = greater(t, farthest)
            walk, goes_on, here = self._follow(walk, words, _entries(words, slabs, farthest), active)

            def test(hits):
                return [closest(t, index, here, *leaf(words))[:2] for leaf, (t, index) in zip(leaves, hits)]

            return walk, goes_on, dr.if_stmt((hits,), here, test, lambda hits: hits, label="leaf")

        state = self.start(lanes), dr.full(Bool, True, lanes), hits
        return dr.while_loop(state, lambda walk, active, hits: active, step, label="bvh of groups")[2]

    def trace(self, ray, t, index, leaf, active, any_hit=False):
        """Return distance and index of each active ray's closest hit, or of any; where it has none, what was given."""
        slabs, lanes = self.slabs(ray), max(dr.width(ray), dr.width(t), dr.width(active))
        t, index, active = (widened(value, lanes) for value in (t, index, active & slabs.valid))

        def step(walk, t, index, active):
            return self.step(walk, self.fetch(walk, active), slabs, t, index, leaf, active, any_hit, jump=True)

        state = self.start(lanes), t, index, active
        _, t, index, _ = dr.while_loop(state, lambda walk, t, index, active: active, step, label="bvh")
        return t, index


def _stacked(walk, pushes, drops, top, entry):
    """Return the walk with `top` on top, and then lanes' entries added to the stack or taken from it.

    Only what registers do not hold goes to memory; a loop of no more than one turn jumps over that.
    """
    old, height = walk.top, walk.height
    over, under = pushes & (height >= REGISTERS), drops & (height > REGISTERS)

    def exchange(waits, last, stack):
        place = lesser(dr.select(over, height - REGISTERS, height - (REGISTERS + 1)), UInt32(STACK_TOP))
        found = stack.read(place, waits & under)
        stack.write(last, place, waits & over)
        return waits & False, dr.select(under, found, last), stack

    _, last, stack = dr.while_loop(
        (over | under, old[-1], walk.stack), lambda waits, last, stack: waits, exchange, label="stack"
    )
    below, above = [entry, top, *old[1:-1]], [*old[1:], last]
    new = [dr.select(pushes, b, dr.select(drops, a, o)) for b, a, o in zip(below, above, [top, *old[1:]])]
    height = dr.select(pushes, height + 1, dr.select(drops, height - 1, height))
    return Walk(walk.record, height, new, stack)


def _entries(words, slabs, t):
    """Return for each child the distance at which the ray enters it, with its slot in the lowest bits, or MISSED.

    Where 0 times infinity makes NaN of a bound, that slab does not restrict the ray: `greater` and `lesser` then
    return their second operand.
    """
    near, far = [Float(0)] * WIDTH, [t] * WIDTH
    for axis in range(3):
        low, high = words[4 * axis : 4 * axis + 2], words[4 * axis + 2 : 4 * axis + 4]
        origin = dr.reinterpret_array(Float, words[ORIGIN + axis])
        for planes, swapped, o, sign, bounds, tighter, wider in (
            (low, high, slabs.o[0], -1, near, greater, lesser), (high, low, slabs.o[1], 1, far, lesser, greater),
        ):  # fmt: skip
            lines = [
                (rate[axis], (origin - o[axis]) * rate[axis] + sign * slack[axis])
                for rate, slack in zip(slabs.rates, slabs.slacks)
            ]
            for pair in range(2):
                word = dr.select(slabs.negative[axis], swapped[pair], planes[pair])
                for k, bits in ((2 * pair, word & HIGH_HALF), (2 * pair + 1, word << 16)):
                    plane = dr.reinterpret_array(Float, bits)
                    bound = dr.fma(plane, *lines[0])
                    for line in lines[1:]:
                        bound = wider(bound, dr.fma(plane, *line))
                    bounds[k] = tighter(bound, bounds[k])
    keys = ((dr.reinterpret_array(UInt32, near[k]) & ~UInt32(SLOT)) | k for k in range(WIDTH))
    return [dr.select(near[k] <= far[k], key, MISSED) for k, key in enumerate(keys)]


def _sorted(keys):
    """Return four keys in ascending order: a sorting network of five comparisons."""
    a, b, c, d = keys
    a, b = _ordered(a, b)
    c, d = _ordered(c, d)
    a, c = _ordered(a, c)
    b, d = _ordered(b, d)
    b, c = _ordered(b, c)
    return a, b, c, d


def _ordered(a, b):
    return dr.select(a < b, a, b), dr.select(a < b, b, a)


def _waiting(first_child, keys):
    """Return the stack's word for up to three children: their record base and slots, the last slot repeated."""
    slots = [keys[0] & SLOT]
    for key in keys[1:]:
        slots.append(dr.select(key != MISSED, key & SLOT, slots[-1]))
    return (first_child << WAITING_BITS) | slots[0] | (slots[1] << SLOT_BITS) | (slots[2] << 2 * SLOT_BITS)


def _take(entry):
    """Return the first slot of a stack entry, the entry without it, and whether that still holds a child."""
    first, second, third = (entry >> shift & SLOT for shift in range(0, WAITING_BITS, SLOT_BITS))
    record = entry & ~UInt32((1 << WAITING_BITS) - 1)
    return first, record | second | (third << SLOT_BITS) | (third << 2 * SLOT_BITS), second != first
