"""Pairs of triangles that share an edge, each of which fills one record of the hierarchy's leaves.

Edges are found by sorting: the positions of an edge's two ends give a key that does not depend on their order, and in
the sorted list of keys equal edges stand together. An edge's mate is its neighbour in that list; where more than two
triangles meet at an edge, each knows one of the others. Keys are hashes: mates whose positions differ are sent away.

Every triangle then asks the best of its at most three mates, those that ask each other become a pair, and the others
ask again. The best one lowers the expected cost most: its box adds least to the sum of the areas [MacDonald1990]. Of
equally good ones it is the mate whose number differs in the lowest bits. Where mates only become better along a strip,
that makes one pair a round; after ROUNDS_BY_AREA rounds random numbers therefore take the place of areas. Nothing
depends on the order in which lanes run.
"""

from dataclasses import dataclass

import drjit as dr

from renderer.accel.boxes import half_area, scene_scale, union
from renderer.accel.records import NO_PRIMITIVE
from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.hashing import mix

NO_EDGE = 0xFFFFFFFF
# Of a pair's box, in the sum of its triangles' boxes. Above 1 because a pair also saves a child of an inner node: the
# cost of Delaunay meshes' trees stays within 1 % from 1 to 2, but 1.5 pairs 88 % of the triangles where 1 pairs 84 %.
MOST_AREA = 1.5
ROUNDS_BY_AREA, ROUNDS = 8, 24  # a random round pairs a fixed share of those left, by expectation
NEVER = 3e38  # rank of a mate with which a triangle cannot be paired


@dataclass(frozen=True)
class Pairs:
    """Items of one or two triangles, {v0, v1, v2} and {v0, v2, v3}, in the order of their first ones' numbers."""

    v0: Vector3f  # v0 and v2 are the shared corners; all positions are the input's to the last bit
    v1: Vector3f
    v2: Vector3f
    v3: Vector3f  # v2 where there is no second triangle
    first: UInt32  # numbers of the triangles
    second: UInt32  # the greater one; NO_PRIMITIVE where there is none


def pair(a, b, c):
    """Return the Pairs of triangles with the corners `a`, `b` and `c` (Vector3f, a lane each, at least one, finite).

    Every triangle is in one item. Two make one only if they have two corners in common to the last bit and their common
    box has at most MOST_AREA times the sum of their areas. There must be fewer than 2^32 / 3 triangles.
    """
    corners = a, b, c
    dr.eval(corners)
    _, scale = scene_scale(*_box(corners))
    mates = _mates(_keys(corners))
    return _items(corners, mates, _match(mates, _ranks(corners, mates, scale)))


def turn_alike(pairs, corners):
    """Return whether all items' second triangles run around as their first ones do: {v0, v2, v1} and {v0, v3, v2}.

    `corners` are the input of `pair`; first ones always do.
    """

    def runs(number, p, q, valid=True):
        a, b, c = (dr.gather(Vector3f, corner, number, valid) for corner in corners)
        return (_same(p, a) & _same(q, b)) | (_same(p, b) & _same(q, c)) | (_same(p, c) & _same(q, a))

    two = pairs.second != NO_PRIMITIVE
    return bool(dr.all(runs(pairs.first, pairs.v0, pairs.v2) & (~two | runs(pairs.second, pairs.v2, pairs.v0, two))))


def _bits(p):
    """Return the bits of a position's coordinates, which tell 0 from -0."""
    return [dr.reinterpret_array(UInt32, axis) for axis in p]


def _same(p, q):
    """Return where two positions agree in all bits."""
    x, y, z = (s == t for s, t in zip(_bits(p), _bits(q)))
    return x & y & z


def _box(corners):
    """Return the two corners of the boxes around triangles."""
    a, b, c = corners
    return union(*union(a, a, b, b), c, c)


def _triangle(edge, count):
    """Return the triangle of an edge, and which of its edges that is; all `count` first edges come first."""
    second, third = edge >= count, edge >= 2 * count
    number = dr.select(third, UInt32(2), dr.select(second, UInt32(1), 0))
    return edge - number * count, number


def _turned(corners, number):
    """Return start and end of an edge, and the corner opposite of it."""
    a, b, c = corners
    first, second = number == 0, number == 1
    return [dr.select(first, x, dr.select(second, y, z)) for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]


def _keys(corners):
    """Return the keys of all edges: first those from each `a` to `b`, then from `b` to `c`, then from `c` to `a`."""
    width = len(corners[0].x)
    lane, count = dr.arange(UInt32, width), dr.opaque(UInt32, width)
    hashes = []
    for corner in corners:
        x, y, z = _bits(corner)
        hashes.append(mix(mix(mix(x) + y) + z))
    keys = dr.empty(UInt32, 3 * width)
    for k in range(3):
        dr.scatter(keys, mix(hashes[k] + hashes[(k + 1) % 3]), lane + k * count)
    dr.eval(keys)
    return keys


def _mates(keys):
    """Return another edge with the same key for each, NO_EDGE where there is none."""
    order = dr.argsort(keys)  # stable: edges of the same key stay in their order
    keys = dr.gather(UInt32, keys, order)
    dr.eval(keys)
    place, count = dr.arange(UInt32, len(order)), dr.opaque(UInt32, len(order))
    twin = place ^ 1  # equal twins find each other; only where they differ an edge turns to its other side
    mate = dr.full(UInt32, NO_EDGE, len(order))
    for neighbour in (2 * place - twin, twin):
        valid = neighbour < count  # the one before the first wraps around to a huge one
        equal = valid & (dr.gather(UInt32, keys, neighbour, valid) == keys)
        mate = dr.select(equal, dr.gather(UInt32, order, neighbour, equal), mate)
    mates = dr.empty(UInt32, len(order))
    dr.scatter(mates, mate, order)
    dr.eval(mates)
    return mates


def _ranks(corners, mates, scale):
    """Return how much area the mate at each of three edges adds, NEVER where it is too much or there is none."""
    width = len(corners[0].x)
    lane, count = dr.arange(UInt32, width), dr.opaque(UInt32, width)
    own_box = _box(corners)
    ranks = []
    for k in range(3):
        mate = dr.gather(UInt32, mates, lane + k * count)
        other, number = _triangle(mate, count)
        valid = (mate != NO_EDGE) & (other != lane)  # a degenerate triangle's edges may be each other's mates
        theirs = [dr.gather(Vector3f, corner, other, valid) for corner in corners]

        # both hash the same, but are they the same?
        start, end, _ = _turned(theirs, number)
        p, q = corners[k], corners[(k + 1) % 3]
        valid &= (_same(p, start) & _same(q, end)) | (_same(p, end) & _same(q, start))

        # sums of two numbers do not depend on their order: both mates find the same rank
        box = _box(theirs)
        alone, together = half_area(*own_box, scale) + half_area(*box, scale), half_area(*union(*own_box, *box), scale)
        ranks.append(dr.select(valid & (together <= MOST_AREA * alone), together - alone, Float(NEVER)))
    dr.eval(ranks)
    return ranks


def _wishes(lane, count, mates, ranks, partners, at_random, salt):
    """Return the best mates that are still free of the triangles `lane`, NO_EDGE where there is none."""
    best = dr.full(Float, NEVER, len(lane))
    wish, wished = dr.full(UInt32, NO_EDGE, len(lane)), dr.zeros(UInt32, len(lane))
    for k in range(3):
        mate, rank = dr.gather(UInt32, mates, lane + k * count), dr.gather(Float, ranks[k], lane)
        other, _ = _triangle(mate, count)
        valid = rank < NEVER
        valid &= dr.gather(UInt32, partners, other, valid) == NO_EDGE
        rank = dr.select(at_random, Float(mix(lane ^ salt) + mix(other ^ salt)), rank)
        better = valid & ((rank < best) | ((rank == best) & ((lane ^ other) < (lane ^ wished))))
        best, wish, wished = (dr.select(better, *both) for both in ((rank, best), (mate, wish), (other, wished)))
    return wish


def _match(mates, ranks):
    """Return the edge of the other triangle that each is paired by, NO_EDGE where it stays alone."""
    width = len(ranks[0])
    count = dr.opaque(UInt32, width)
    wishes, partners = dr.full(UInt32, NO_EDGE, width), dr.full(UInt32, NO_EDGE, width)
    lane = dr.arange(UInt32, width)
    dr.make_opaque(wishes, partners, lane)
    for round_index in range(ROUNDS):
        at_random = dr.opaque(Bool, round_index >= ROUNDS_BY_AREA)
        wish = _wishes(lane, count, mates, ranks, partners, at_random, dr.opaque(UInt32, round_index))
        dr.scatter(wishes, wish, lane)
        dr.eval(wish, wishes)

        # who wishes nothing will never do: free mates only become fewer
        asks = wish != NO_EDGE
        answer = dr.gather(UInt32, wishes, _triangle(wish, count)[0], asks)
        mutual = asks & (answer != NO_EDGE) & (_triangle(answer, count)[0] == lane)
        dr.scatter(partners, wish, lane, mutual)
        left = asks & ~mutual
        dr.eval(partners, left)
        lane = dr.gather(UInt32, lane, dr.compress(left))
        if not len(lane):
            break
        dr.eval(lane)
    return partners


def _items(corners, mates, partners):
    """Return the Pairs of triangles whose partners were found."""
    count, lane = dr.opaque(UInt32, len(partners)), dr.arange(UInt32, len(partners))
    first = dr.compress((partners == NO_EDGE) | (lane < _triangle(partners, count)[0]))
    edge = dr.gather(UInt32, partners, first)
    paired = edge != NO_EDGE
    own_number = dr.zeros(UInt32, len(first))
    for k in (1, 2):
        own_number = dr.select(paired & (dr.gather(UInt32, mates, first + k * count) == edge), UInt32(k), own_number)
    other, number = _triangle(edge, count)
    v0, v2, v1 = _turned([dr.gather(Vector3f, corner, first) for corner in corners], own_number)
    _, _, opposite = _turned([dr.gather(Vector3f, corner, other, paired) for corner in corners], number)
    pairs = Pairs(v0, v1, v2, dr.select(paired, opposite, v2), first, dr.select(paired, other, UInt32(NO_PRIMITIVE)))
    dr.eval(pairs.v0, pairs.v1, pairs.v2, pairs.v3, pairs.first, pairs.second)
    return pairs
