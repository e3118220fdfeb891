"""Sums over many samples.

A pixel of 65,536 samples, or of 2^24, is a sum to which each adds less than its rounding takes away: a plain sum of
float32 stops to grow, or drifts where all samples are rounded the same way. Variances are differences of such sums.
Samples are 1/3 and other awkward numbers all the same, numbers spread evenly, and numbers of which one in 4096 is a
million times brighter than the rest. The yardstick is a sum in double precision of the same float32 numbers.
"""

import math

import drjit as dr
import numpy as np

from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.colour import LUMINANCE
from renderer.core.hashing import mix
from renderer.engine.film import Film
from tests.stability.case import ULP, Case, mitsuba, relative

LANES = 32
MANY, MOST = 2**16, 2**24
EQUAL = np.array([1 / 3, 0.1, 0.7, 1e-3, 1e6 / 3, 1.0000001, math.pi, 5e-7] * 4, np.float32)


def equal(sample, lane):
    """Return the same number for all samples."""
    return Float(EQUAL)


def even(sample, lane):
    """Return numbers spread over [0, 1)."""
    return Float(mix(sample * LANES + lane) >> 8) * 2.0**-24


def glaring(sample, lane):
    """Return the same, one in 4096 a million times as bright."""
    bits = mix(sample * LANES + lane)
    return Float(bits >> 8) * 2.0**-24 * dr.select((bits & 0xFFF) == 0, Float(1e6), 1)


def close(sample, lane):
    """Return numbers within 0.01 of 1."""
    return 0.99 + 0.02 * even(sample, lane)


def looped(start, added, count):
    """Return the state after `state = added(state, sample)` for so many samples, a lane each."""
    end = dr.opaque(UInt32, count)
    state = (dr.opaque(UInt32, 0) + dr.zeros(UInt32, LANES), start)
    _, result = dr.while_loop(state, lambda k, state: k < end, lambda k, state: (k + 1, added(state, k)))
    dr.eval(result)
    return result


def film(values, count, variance=False):
    """Return the Film of so many samples of a function, all channels alike."""
    lane = dr.arange(UInt32, LANES)
    return looped(Film.empty(LANES, variance=variance).opaque(),
                  lambda film, k: film.add(Vector3f(values(k, lane)), Bool(True)), count)  # fmt: skip


def means(values, count):
    """Return the renderer's means."""
    return film(values, count).mean(count).numpy()[0]


def running(values, count):
    """Return the means of a plain sum."""
    lane = dr.arange(UInt32, LANES)
    total = looped(dr.zeros(Float, LANES) + dr.opaque(Float, 0), lambda total, k: total + values(k, lane), count)
    return total.numpy() / np.float32(count)


def all_samples(values, count):
    """Return all samples, (count, LANES) float64."""
    number = dr.arange(UInt32, count * LANES)
    return values(number // LANES, number % LANES).numpy().astype(float).reshape(count, LANES)


def exact(values, count):
    """Return the exact means."""
    if values is equal:
        return EQUAL.astype(float)
    return all_samples(values, count).sum(axis=0) / count


def errors(mean, values, count):
    """Return a callable: relative errors of the means by a function."""
    return lambda: relative(mean(values, count), exact(values, count))


def plain_variance(values, count):
    """Return the variances of means from plain sums of numbers and their squares."""
    lane = dr.arange(UInt32, LANES)
    zero = dr.zeros(Float, LANES) + dr.opaque(Float, 0)

    def added(sums, k):
        value = values(k, lane)
        return sums[0] + value, sums[1] + dr.square(value)

    total, squares = (part.numpy() for part in looped((zero, zero), added, count))
    count = np.float32(count)
    return (squares - total * total / count) / (count * (count - 1))


def variance(values, count):
    """Return the renderer's variances of means."""
    return film(values, count, variance=True).variance(count).numpy()


def deviations(spread, values, count):
    """Return a callable: relative errors of the standard deviations by a function of variances."""

    def measure():
        wanted = all_samples(values, count).var(axis=0, ddof=1) / count * sum(LUMINANCE) ** 2
        with np.errstate(invalid="ignore"):
            return relative(np.sqrt(np.asarray(spread(values, count), float)), np.sqrt(wanted))

    return measure


def constant_picture(values, count):
    """Return the means that Mitsuba's film makes of a constant emitter, one picture for each different number."""
    mi = mitsuba()
    found = {}
    for value in map(float, EQUAL[:8]):
        scene = mi.load_dict({
            "type": "scene", "emitter": {"type": "constant", "radiance": {"type": "rgb", "value": value}},
            "integrator": {"type": "path"},
            "sensor": {"type": "perspective", "sampler": {"type": "independent", "sample_count": count},
                       "film": {"type": "hdrfilm", "width": 2, "height": 2, "rfilter": {"type": "box"},
                                "component_format": "float32", "pixel_format": "rgb"}},
        })  # fmt: skip
        found[value] = np.array(mi.render(scene)).mean()
    return np.array([found[float(value)] for value in EQUAL])


FEW_ROUNDINGS = "the sum carries what rounding took, so that it, its last rounding and the division are left"
CASES = (
    Case("65,536 equal samples", "relative", 3 * ULP, FEW_ROUNDINGS, errors(means, equal, MANY),
         errors(running, equal, MANY), "a running sum", errors(constant_picture, equal, MANY)),
    Case("65,536 samples of [0, 1)", "relative", 3 * ULP, FEW_ROUNDINGS, errors(means, even, MANY),
         errors(running, even, MANY), "a running sum", None, "asked only for equal samples"),
    Case("65,536 samples, some a million times brighter", "relative", 3 * ULP, FEW_ROUNDINGS,
         errors(means, glaring, MANY), errors(running, glaring, MANY), "a running sum", None,
         "asked only for equal samples"),
    Case("2^24 equal samples", "relative", 3 * ULP, FEW_ROUNDINGS, errors(means, equal, MOST),
         errors(running, equal, MOST), "a running sum", None, "takes a gigabyte for so many samples of a pixel"),
    Case("standard deviation of 65,536 samples within 0.01 of 1", "relative", 2.7e-3,
         "three roundings of each luminance and square, all the same way, are 1.8e-7 of a variance of 3.3e-5",
         deviations(variance, close, MANY), deviations(plain_variance, close, MANY), "sums of numbers and squares",
         None, "its integrator `moment` sums squares as the film sums colours"),
)  # fmt: skip
