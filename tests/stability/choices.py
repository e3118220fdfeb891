"""Choices among things of very different weights.

Lights of a scene and triangles of a mesh are chosen by weights that may span 1e12. Random numbers have 24 bits: what is
rarer than 2^-24 of them is chosen never, or far too often, and the light that it stands for is wrong by as much,
because each choice is divided by its exact probability. How often each thing is chosen is counted exactly, by looking
for the numbers at which choices change.
"""

import drjit as dr
import numpy as np

from renderer.core.backend import Float, UInt32, Vector3f
from renderer.core.distribution import RANDOM_BITS, AliasTables
from renderer.scene.light_choice import Estimate, FewLights
from tests.stability.case import ULP, Case, mitsuba, relative

STEPS = 2**RANDOM_BITS
BITS = 6
THINGS = 2**BITS


def weights():
    """Return (rows, THINGS) weights from 1e-12 to 1, in any order, and in the order of their size."""
    rng = np.random.default_rng(1)
    own = 10.0 ** rng.uniform(-12, 0, (4, THINGS))
    own[:, 0], own[:, 1] = 1e-12, 1.0
    own[2:] = np.sort(own[2:], axis=1)
    own[3] = own[3, ::-1]
    return own


def shares():
    """Return the exact probabilities (rows, THINGS)."""
    own = weights()
    return own / own.sum(axis=1, keepdims=True)


def first_where(true, count, shape):
    """Return the first number below `count` for which true(number) holds, of monotonic answers; `count` where none."""
    low, high = np.zeros(shape, np.int64), np.full(shape, count, np.int64)
    while (low < high).any():
        middle = (low + high) // 2
        found = true(np.minimum(middle, count - 1)) & (middle < count)
        low, high = np.where(found, low, np.minimum(middle + 1, high)), np.where(found, middle, high)
    return low


def by_alias(own):
    """Return how often the renderer's table of one row (THINGS,) chooses each thing."""
    tables, _, (bits,) = AliasTables.of([own[None]])
    place, rest = np.arange(THINGS), STEPS >> BITS

    def chosen(number):
        v, low = number // rest, number % rest
        u = (place * rest + low) / STEPS
        return tables.choose(Float(u.astype(np.float32)), Float((v / STEPS).astype(np.float32)), 0, bits)[0].numpy()

    other = chosen(np.full(THINGS, STEPS * rest - 1))
    switch = first_where(lambda number: chosen(number) != place, STEPS * rest, THINGS) / (STEPS * rest)
    return (switch + np.bincount(other, 1 - switch, THINGS)) / THINGS


def by_thresholds(starts):
    """Return how often things are chosen whose first random numbers, (THINGS - 1,) of STEPS, are given."""
    return np.diff(np.concatenate([[0], starts, [STEPS]])) / STEPS


def by_sums(own):
    """Return how often the textbook's running sums choose each thing."""
    sums = np.cumsum(own.astype(np.float32), dtype=np.float32)
    return by_thresholds(np.ceil(sums[:-1] / sums[-1] * np.float32(STEPS)).astype(float))


def by_mitsuba(own):
    """Return how often Mitsuba's distribution chooses each thing."""
    mi = mitsuba()
    distribution, thing = mi.DiscreteDistribution(mi.Float(own.astype(np.float32))), np.arange(THINGS - 1)

    def beyond(number):
        return distribution.sample(mi.Float((number / STEPS).astype(np.float32))).numpy() > thing

    return by_thresholds(first_where(beyond, STEPS, THINGS - 1))


def frequencies(choose):
    """Return a callable: relative errors of how often things are chosen by a function of one row of weights."""
    return lambda: relative(np.stack([choose(own) for own in weights()]), shares())


LIGHTS = 8


def lamps():
    """Return Estimates of lights around the origin of strengths over 1e12; some shine away from everything."""
    rng = np.random.default_rng(2)
    made = []
    for k in range(LIGHTS):
        place = rng.normal(size=3)
        away = {"axis": tuple(place / np.linalg.norm(place)), "gate": 0.0} if k in (0, 3, LIGHTS - 1) else {}
        made.append(Estimate(tuple(place), 10.0 ** rng.uniform(-6, 6), 1e-6, **away))
    return made


def points():
    """Return points near the origin (3, N) float32, and random numbers (N,), many of them at the ends of [0, 1)."""
    rng = np.random.default_rng(3)
    count = 50_000
    numbers = rng.integers(0, STEPS, count)
    numbers[: count // 2] = rng.choice([0, 1, 2, STEPS - 2, STEPS - 1], count // 2)
    return (rng.normal(size=(3, count)) * 0.05).astype(np.float32), (numbers / STEPS).astype(np.float32)


def strengths(p):
    """Return what each light brings to points, (LIGHTS, N), exactly."""
    result = []
    for lamp in lamps():
        offset = p.astype(float) - np.array(lamp.center)[:, None]
        squared = (offset**2).sum(axis=0)
        shines = True if lamp.gate < 0 else np.array(lamp.axis) @ offset > lamp.gate * np.sqrt(squared)
        result.append(lamp.strength / np.maximum(squared, lamp.least) * shines)
    return np.array(result)


def chosen_lights(choose):
    """Return a callable: which choices of a function are wrong, and which probabilities by more than 8 roundings."""

    def measure():
        p, u = points()
        weight = strengths(p)
        number, probability = choose(p, u)
        told = np.take_along_axis(weight / weight.sum(axis=0), number[None], axis=0)[0]
        with np.errstate(invalid="ignore"):
            return ~((told > 0) & (relative(probability, told) < 16 * ULP))

    return measure


def by_estimates(p, u):
    """Return the renderer's lights and their probabilities."""
    found = FewLights(lamps()).choose(Vector3f(*p), Float(u), Float(0.5))
    number = UInt32(0)
    for k, mask in enumerate(found.masks, start=1):
        number = dr.select(mask, UInt32(k), number)
    return number.numpy(), found.probability.numpy()


def by_running_sums(p, u):
    """Return the textbook's: the first light whose sum of weights reaches the random number's share of all."""
    sums = np.cumsum(strengths(p).astype(np.float32), axis=0, dtype=np.float32)
    number = (sums < u * sums[-1]).sum(axis=0)
    weight = np.diff(sums, axis=0, prepend=np.float32(0))
    return number, np.take_along_axis(weight, number[None], axis=0)[0] / sums[-1]


CASES = (
    Case("64 things of weights from 1e-12 to 1", "relative", 2.0 ** (BITS - 48) / (THINGS * shares().min()),
         "48 - 6 bits of two random numbers tell a place's two things apart, of which the lightest has its share",
         frequencies(by_alias), frequencies(by_sums), "running sums of float32", frequencies(by_mitsuba)),
    Case("lights of powers from 1e-6 to 1e6, some dark", "share", 0,
         "none is chosen that is dark, and probabilities are good to 16 roundings", chosen_lights(by_estimates),
         chosen_lights(by_running_sums), "running sums, weights as their differences", None,
         "chooses emitters evenly unless weights are set by hand"),
)  # fmt: skip
