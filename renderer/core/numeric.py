"""Tolerances and numeric helpers of the kernels, each with its reason.

"No hit" is the finite distance FAR. Denominators that may vanish are moved away from zero, unless the infinity or NaN
fails every later comparison by itself; where that is meant, the code says so.
"""

import drjit as dr

from renderer.core.backend import Float

EPSILON = 2.0**-24  # unit roundoff of float32
FAR = 1e30  # scene units: no hit, and finite; its square is not
TINY = 1e-30  # below every meaningful direction component; its reciprocal is FAR
LEAST_NORMAL = 2.0**-126  # float32's; what is smaller, Dr.Jit's threads take for 0
EDGE_TOLERANCE = 2.0**-20  # barycentric; neighbours overlap by 16 roundoffs so that no ray slips through their edge
LEAVE_ULPS = 2.0  # roundoffs of |o| by which that may lie off a surface: one along each axis, together sqrt(3)


def away_from_zero(x):
    """Return x moved by TINY away from 0, which is x itself from 2^24 TINY on; -0 counts as negative, NaN stays NaN."""
    return x + dr.copysign(type(x)(TINY), x)


def lesser(a, b):
    """Return the smaller; b where either is NaN (one instruction, which dr.minimum is not)."""
    return dr.select(a < b, a, b)


def greater(a, b):
    """Return the larger; b where either is NaN."""
    return dr.select(a > b, a, b)


def largest(v):
    """Return the size of the largest component of a vector."""
    return greater(abs(v.x), greater(abs(v.y), abs(v.z)))


def safe_sqrt(x):
    """Return the square root of x clamped to 0 from below; NaN gives 0."""
    return dr.sqrt(greater(x, Float(0)))


def widened(value, lanes):
    """Return a value of any width with `lanes` lanes: loops take variables of one lane for constants."""
    zero = dr.zeros(type(value), lanes)
    return value | zero if dr.is_mask_v(value) else value + zero
