"""Rays in arrays: what each of them hits, for whoever has rays and wants no picture.

A packet of lanes runs until its last ray is done, and incoherent rays differ in length by a factor of ten. So a lane
here takes its next ray as soon as the last one is done, and follows two at once: while one waits for memory, the other
computes. Its rays lie side by side in memory, so that what the cache brings for one serves the next dozen.

Coherent rays visit the same records. A lane takes four neighbours along one way through the hierarchy.
"""

from __future__ import annotations

import functools
import operator
from dataclasses import dataclass

import drjit as dr

from renderer.accel.bvh import Bvh, Walk
from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.numeric import FAR, lesser
from renderer.core.records import NO_SHAPE, Hit, Ray
from renderer.scene.geometry import SHADOW_END

LANES = 2048  # enough for a hundred threads of 16; with more of them each has fewer rays, and they end less evenly
AT_ONCE = 2  # rays that a lane follows
GROUP = 4  # coherent rays on one walk; eight are faster yet in squares of pixels, and slower in rows of them
STEPS = 3  # through the hierarchy between looking for finished rays, which costs about as much as one step


@dataclass
class Query:
    """One of the rays that a lane follows."""

    number: UInt32
    o: Vector3f
    d: Vector3f
    t: Float
    index: UInt32
    walk: Walk


def closest(geometry, ray, coherent=False):
    """Return the Hit of each ray (evaluated): distance, FAR for none, and primitive, NO_SHAPE for none.

    `coherent` tells that neighbours in the arrays go about the same way, as the rays of a picture's pixels do.
    """
    if not isinstance(geometry.structure, Bvh):
        hit = geometry.intersect(ray)
        dr.eval(hit.t, hit.index)
        return hit
    return _in_groups(geometry, ray) if coherent else _in_turns(geometry, ray, None)


def occluded(geometry, ray, distance, coherent=False):
    """Return whether anything lies on each ray before its distance (evaluated)."""
    if coherent or not isinstance(geometry.structure, Bvh):
        blocked = geometry.occluded(ray, distance, Bool(True))
        dr.eval(blocked)
        return blocked
    blocked = _in_turns(geometry, ray, distance * SHADOW_END).index != NO_SHAPE
    dr.eval(blocked)
    return blocked


def _in_groups(geometry, rays):
    """Return the closest hits of rays, of which every lane follows GROUP neighbours on one walk."""
    count = dr.width(rays)
    lanes = -(-count // GROUP)
    numbers = [lesser(GROUP * dr.arange(UInt32, lanes) + k, dr.opaque(UInt32, count - 1)) for k in range(GROUP)]
    t_found, index_found = dr.empty(Float, count), dr.empty(UInt32, count)
    dr.eval(rays, numbers)
    group, valid = [], []
    for number in numbers:
        o, d = dr.gather(Vector3f, rays.o, number), dr.gather(Vector3f, rays.d, number)
        valid.append(abs(dr.sum(o) + dr.sum(d)) < FAR)  # false for NaN, which must not spoil its neighbours' boxes
        group.append(Ray(dr.select(valid[-1], o, 0), dr.select(valid[-1], d, Vector3f(0, 0, 1))))
    hits = [geometry.loose_hit(ray, Float(FAR)) for ray in group]
    hits = geometry.structure.trace_groups(group, hits, [geometry.leaf_test(ray) for ray in group])
    hits = [(dr.select(good, t, FAR), dr.select(good, index, NO_SHAPE)) for (t, index), good in zip(hits, valid)]
    dr.eval(hits)
    for number, (t, index) in zip(numbers, hits):
        dr.scatter(t_found, t, number)
        dr.scatter(index_found, index, number)
    dr.eval(t_found, index_found)
    return Hit(t_found, index_found)


def _in_turns(geometry, rays, ends):
    """Return the closest hits of rays, or any before `ends` where these are given."""
    bvh, count, any_hit = geometry.structure, dr.width(rays), ends is not None
    lanes = min(LANES, -(-count // AT_ONCE))
    share = dr.opaque(UInt32, -(-count // (lanes * AT_ONCE)))  # rays of a lane, for each that it follows at once
    firsts = [(dr.arange(UInt32, lanes) * AT_ONCE + k) * share for k in range(AT_ONCE)]
    stops = [lesser(first + share, dr.opaque(UInt32, count)) for first in firsts]
    t_found, index_found = dr.empty(Float, count), dr.empty(UInt32, count)
    dr.eval(rays, ends, stops)

    def begin(query, number, where):
        """Start the ray with the given number in the lanes `where`."""
        o, d = dr.gather(Vector3f, rays.o, number, where), dr.gather(Vector3f, rays.d, number, where)
        t, index = geometry.loose_hit(Ray(o, d), dr.gather(Float, ends, number, where) if any_hit else Float(FAR))
        query.o, query.d = dr.select(where, o, query.o), dr.select(where, d, query.d)
        query.t, query.index = dr.select(where, t, query.t), dr.select(where, index, query.index)
        query.walk.record = dr.select(where, 0, query.walk.record)
        query.walk.height = dr.select(where, 0, query.walk.height)

    def advance(*queries):
        queries = list(queries)
        tests = [(bvh.slabs(Ray(query.o, query.d)), geometry.leaf_test(Ray(query.o, query.d))) for query in queries]
        running = [query.number < stop for query, stop in zip(queries, stops)]
        active = [run & slabs.valid for run, (slabs, _) in zip(running, tests)]
        if any_hit:
            active = [still & (query.index == NO_SHAPE) for still, query in zip(active, queries)]
        for _ in range(STEPS):
            fetched = [bvh.fetch(query.walk, still) for query, still in zip(queries, active)]
            for k, (query, (slabs, leaf)) in enumerate(zip(queries, tests)):
                query.walk, query.t, query.index, active[k] = bvh.step(
                    query.walk, fetched[k], slabs, query.t, query.index, leaf, active[k], any_hit
                )
        for query, run, still, stop in zip(queries, running, active, stops):
            done = run & ~still
            dr.scatter(t_found, query.t, query.number, done)
            dr.scatter(index_found, query.index, query.number, done)
            query.number = dr.select(done, query.number + 1, query.number)
            begin(query, query.number, done & (query.number < stop))
        return tuple(queries)

    queries = []
    for first, stop in zip(firsts, stops):
        zero = dr.zeros(Vector3f, lanes)
        query = Query(first, zero, zero, dr.zeros(Float, lanes), dr.zeros(UInt32, lanes), bvh.start(lanes))
        begin(query, first, first < stop)
        queries.append(query)

    def any_left(*queries):
        return functools.reduce(operator.or_, (query.number < stop for query, stop in zip(queries, stops)))

    dr.while_loop(tuple(queries), any_left, advance, label="queries")
    dr.eval(t_found, index_found)
    return Hit(t_found, index_found)
