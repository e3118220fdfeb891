"""Multiple importance sampling of two strategies."""

import drjit as dr

from renderer.core.backend import Float


def power_heuristic(pdf, other_pdf):
    """Return the weight of a sample with density `pdf` that the other strategy finds with `other_pdf`.

    Both are of the same measure. The weights of both strategies add up to 1 for all densities from 0 to infinity: what is
    squared is their quotient, and where that overflows or falls to 0, the weight is 0 or 1 to within rounding. Where
    both are 0, or both infinite, it is NaN, fails the comparison, and each weighs a half.
    Source: [Veach1997, sec. 9.2.4].
    """
    weight = dr.rcp(1 + dr.square(other_pdf / pdf))
    return dr.select(weight >= 0, weight, Float(0.5))
