"""Elementary functions for the ranges that sampling needs, without what the general ones spend on other arguments.

On CPUs Dr.Jit's own cost as much as 8 divisions (measured with LLVM 19 on AVX-512, a lane and thread: log2 0.35 ns,
sincos 0.31 ns, exp2 0.16 ns, a division 0.04 ns); these take 0.13, 0.16 and 0.13 ns. GPUs have instructions for them.
The coefficients interpolate at Chebyshev points,
`Chebyshev.interpolate(f, count - 1, domain).convert(kind=Polynomial)` in numpy; errors are those in float32.
"""

import math

import drjit as dr

from renderer.core.backend import NAME, Float, Int32
from renderer.core.numeric import away_from_zero, greater, lesser

ON_GPU = NAME == "cuda"
# sin(2 pi t) / t and cos(2 pi t) in t^2 <= 1/16; sin(pi q / 4) / q and cos(pi q / 4) in q^2 <= 1
SIN_TURN = 6.28318528, -41.34168061, 81.60247637, -76.58117264, 39.75982707
COS_TURN = 0.999999953, -19.73917121, 64.93457265, -85.23987026, 56.23870043
SIN_EIGHTH = 0.785398161, -0.08074543471, 0.002490006801, -3.595429073e-05
COS_EIGHTH = 0.9999999723, -0.3084242519, 0.01584991071, -0.0003188774749
# log2(1 + f) / f for sqrt(1/2) <= 1 + f <= sqrt(2); 2^f for -1/2 <= f <= 1/2
LOG2 = (1.442695004, -0.7213474682, 0.4809107535, -0.3606932681, 0.2879032609, -0.2391698814, 0.2160782256,
        -0.2058618803, 0.1231096843)  # fmt: skip
EXP2 = 1.0, 0.6931472067, 0.2402265092, 0.05550327227, 0.009618056678, 0.001340042818, 0.0001546144472
# atan(t) / t in t^2 <= 1
ATAN = (1.0, -0.33333276, 0.19998075, -0.14260016, 0.10932342, -0.083497247, 0.057089558, -0.030351866, 0.010487654,
        -0.0017011701)  # fmt: skip
ROOT_HALF_BITS = 0x3F3504F3  # of sqrt(1/2)
MANTISSA_BITS, EXPONENT_BIAS = 23, 127
LOG2_E = 1.442695041
NEAR_1 = 0.29  # below 1 - sqrt(1/2): how far from 1 the polynomial of log2 goes
LEAST_EXPONENT = -100.0  # less counts as this much: numbers that are not normal are slow, or 0


def polynomial(x, coefficients):
    """Return the polynomial with the coefficients of 1, x, x^2, ..."""
    *rest, last = coefficients
    result = Float(last)
    for coefficient in reversed(rest):
        result = dr.fma(result, x, coefficient)
    return result


def sincos_turns(u):
    """Return sine and cosine of u turns, 0 <= u <= 1, to 3e-7."""
    if ON_GPU:
        return dr.sincos(u * math.tau)
    x = 0.5 - u
    t = abs(x) - 0.25
    t2 = dr.square(t)
    return dr.mulsign(polynomial(t2, COS_TURN), x), t * polynomial(t2, SIN_TURN)


def sincos_eighth(q):
    """Return sine and cosine of q eighths of a turn, -1 <= q <= 1, to 1e-7."""
    if ON_GPU:
        return dr.sincos(q * (math.tau / 8))
    q2 = dr.square(q)
    return q * polynomial(q2, SIN_EIGHTH), polynomial(q2, COS_EIGHTH)


def atan2(y, x):
    """Return the angle of (x, y) in radians, between -pi and pi, to 4e-7; 0 for (0, 0)."""
    if ON_GPU:
        return dr.atan2(y, x)
    a, b = abs(x), abs(y)
    steep = b > a
    t = dr.select(steep, a, b) / away_from_zero(dr.select(steep, b, a))
    angle = t * polynomial(dr.square(t), ATAN)
    angle = dr.select(steep, 0.5 * math.pi - angle, angle)
    return dr.mulsign(dr.select(x < 0, math.pi - angle, angle), y)


def polar(cosine, sine):
    """Return the angle between 0 and pi with this cosine and sine (not negative), to 3e-7 of it, also near 0.

    It is twice the arc tangent of sine / (1 + cosine). An arc cosine would lose small angles.
    """
    t = sine / (1 + abs(cosine))
    angle = 2 * (dr.atan2(t, Float(1)) if ON_GPU else t * polynomial(dr.square(t), ATAN))
    return dr.select(cosine < 0, math.pi - angle, angle)


def log2(x):
    """Return the logarithm to base 2 of normal x > 0, to 2e-7 of it (also near 1) or of 1; finite for 0 and below."""
    if ON_GPU:
        return dr.log2(greater(x, Float(2.0**LEAST_EXPONENT)))
    bits = dr.reinterpret_array(Int32, x)
    exponent = (bits - ROOT_HALF_BITS) >> MANTISSA_BITS
    f = dr.reinterpret_array(Float, bits - (exponent << MANTISSA_BITS)) - 1
    return dr.fma(f, polynomial(f, LOG2), Float(exponent))


def log2_below_1(x, rest):
    """Return log2(x) <= 0 to 3e-7 of it where the difference from 1 is better known as `rest` than by x; finite for 0.

    High powers of cosines are powers of numbers that float32 can hardly tell from 1, but their sines are known.
    """
    if ON_GPU:
        return dr.select(rest < NEAR_1, -rest * polynomial(-rest, LOG2), log2(x))
    # where x is small, this adds some 1e-7 to its logarithm
    return lesser(dr.fma((1 - x) - rest, LOG2_E, log2(x)), Float(0))


def exp2(x):
    """Return 2^x for -100 <= x < 127.5, to 2e-7 of it; 2^-100 below."""
    if ON_GPU:
        return dr.exp2(x)
    x = greater(x, Float(LEAST_EXPONENT))
    whole = dr.round(x)
    scale = dr.reinterpret_array(Float, (Int32(whole) + EXPONENT_BIAS) << MANTISSA_BITS)
    return polynomial(x - whole, EXP2) * scale


def exp2_both(x):
    """Return 2^x as `exp2` does and 1 - 2^x, each to 3e-7 of itself, for x <= 0."""
    if ON_GPU:
        power = dr.exp2(x)
        return power, dr.select(x > -0.5, -x * polynomial(x, EXP2[1:]), 1 - power)
    x = greater(x, Float(LEAST_EXPONENT))
    whole = dr.round(x)
    scale = dr.reinterpret_array(Float, (Int32(whole) + EXPONENT_BIAS) << MANTISSA_BITS)
    part = x - whole
    rise = part * polynomial(part, EXP2[1:])
    return dr.fma(rise, scale, scale), dr.fma(-rise, scale, 1 - scale)
