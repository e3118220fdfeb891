"""The only loop over path vertices.

One lane a pixel: as soon as its path ends it starts its next sample, so that the lanes of a packet never wait for
the longest path among them. The image stays in registers, and memory does not depend on the number of samples.

Where pixels differ much in what they cost, lanes render several one after the other (engine/tiles.py).

`ray(sampler, corner, sample)` returns origin and direction of the camera rays of samples, and whether these count
negatively (None: none ever does); `span` is the first sample and the one after the last, opaque UInt32.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, Float64, UInt32, Vector2f, Vector3f
from renderer.engine.film import Film
from renderer.engine.tiles import NO_PIXEL
from renderer.samplers.base import Draws


def pixel_corner(pixel, width):
    """Return column and row of a pixel number, as Vector2f of its top left corner in pixels.

    Division in double precision, because integer division has no vector instruction; exact for 2^28 pixels.
    """
    row = UInt32((Float64(pixel) + 0.5) / Float64(width))
    return Vector2f(Float(pixel - row * width), Float(row))


def sample_pixels(integrator, ray, sampler, corner, film, span):
    """Return the Film (one lane a pixel) with the samples of a span, added in their order."""
    lanes, (first, end) = dr.width(corner), span
    sample = first + dr.zeros(UInt32, lanes)
    o, d, negative = ray(sampler, corner, sample)
    path = integrator.restart(integrator.start(lanes), True, o, d)

    def finished(sample, path, current, negative, film, where):
        """Return the state with the samples `where` added to the film, and the next ones begun."""
        film = film.add(current, where & (sample < end), negative)
        sample = sample + dr.select(where, UInt32(1), 0)
        current = dr.select(where, 0, current)
        o, d, next_negative = ray(sampler, corner, sample)
        if negative is not None:
            negative = dr.select(where, next_negative, negative)
        return sample, integrator.restart(path, where, o, d), current, negative, film

    def advance(sample, path, current, negative, film):
        hit = ()
        if integrator.looks_ahead:
            ahead = integrator.trace(path)
            current = current + dr.select(ahead.valid, 0, integrator.missed(path))
            sample, path, current, negative, film = finished(sample, path, current, negative, film, ~ahead.valid)
            hit = (dr.select(ahead.valid, ahead, integrator.trace(path)),)
        added, alive, path = integrator.step(path, Draws(sampler, sample), *hit)
        return finished(sample, path, current + added, negative, film, ~alive)

    *_, film = dr.while_loop(
        (sample, path, dr.zeros(Vector3f, lanes), negative, film),
        lambda sample, path, current, negative, film: sample < end, advance, label="samples",
    )
    return film


@dataclass
class Turn:
    """Where a lane is: its pixel, and what that has so far."""

    number: UInt32
    pixel: UInt32  # NO_PIXEL where this turn has none
    corner: Vector2f
    sample: UInt32
    film: Film


def sample_tiles(integrator, ray, lanes_of, tiles, film, span):
    """Return the Film of the pixels of Tiles with the samples of a span, added in their order.

    `lanes_of` returns the sampler and the corner of pixels by their numbers.
    """
    dr.eval(film)  # what it adds up to now is read in the loop
    lanes, after, (first, end) = tiles.lanes, film.opaque(), span

    def turned(number):
        """Return the Turn of this number in each lane."""
        pixel = tiles.pixel(number)
        there = pixel != NO_PIXEL
        before = film.at(tiles.place(pixel), there)
        return Turn(number, pixel, lanes_of(pixel)[1], dr.select(there, first, end), before)

    def moved(turn):
        """Return the lanes' next turns; what their pixels have is stored."""
        after.put(turn.film, tiles.place(turn.pixel), turn.pixel != NO_PIXEL)
        return (turned(turn.number + 1),)

    def finished(turn, path, current, negative, where):
        """Return the state with the samples `where` added to the film, and the next ones begun."""
        turn.film = turn.film.add(current, where, negative)
        turn.sample = turn.sample + dr.select(where, UInt32(1), 0)
        complete = (turn.sample >= end) & (turn.number < tiles.turns)
        (turn,) = dr.if_stmt((turn,), complete, moved, lambda turn: (turn,), label="next pixel")
        where = where | complete
        o, d, next_negative = ray(lanes_of(turn.pixel)[0], turn.corner, turn.sample)
        if negative is not None:
            negative = dr.select(where, next_negative, negative)
        return turn, integrator.restart(path, where, o, d), dr.select(where, 0, current), negative

    def advance(turn, path, current, negative):
        added, alive, path = integrator.step(path, Draws(lanes_of(turn.pixel)[0], turn.sample))
        return finished(turn, path, current + added, negative, ~alive)

    turn = turned(dr.zeros(UInt32, lanes))
    o, d, negative = ray(lanes_of(turn.pixel)[0], turn.corner, turn.sample)
    path = integrator.restart(integrator.start(lanes), True, o, d)
    dr.while_loop(
        (turn, path, dr.zeros(Vector3f, lanes), negative),
        lambda turn, path, current, negative: turn.number < tiles.turns, advance, label="samples",
    )
    return after


def follow_sample(integrator, ray, sampler, corner, sample):
    """Return the radiance of one sample a lane, whatever it is."""
    o, d, _ = ray(sampler, corner, sample)
    lanes = dr.width(corner)
    path = integrator.restart(integrator.start(lanes), True, o, d)

    def advance(path, radiance, alive):
        added, goes_on, path = integrator.step(path, Draws(sampler, sample))
        return path, radiance + dr.select(alive, added, 0), alive & goes_on

    _, radiance, _ = dr.while_loop(
        (path, dr.zeros(Vector3f, lanes), dr.full(Bool, True, lanes)),
        lambda path, radiance, alive: alive, advance, label="one sample",
    )
    return radiance
