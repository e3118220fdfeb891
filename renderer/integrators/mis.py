"""Multiple importance sampling of two strategies."""

import drjit as dr

from renderer.core.backend import Float
from renderer.core.numeric import LEAST_NORMAL, greater


def power_heuristic(pdf, other_pdf):
    """Return the weight of a sample with density `pdf` that the other strategy finds with `other_pdf`.

    Both are of the same measure. What is squared is their quotient: where that overflows or falls to 0, the weight is 0
    or 1 to within rounding, and the weights of both strategies add up to 1. `pdf` 0 gives 0 unless both are 0. Whoever
    divides by `pdf` should guard it in the same way: it is then computed once.
    Source: [Veach1997, sec. 9.2.4].
    """
    quotient = other_pdf / greater(pdf, Float(LEAST_NORMAL))
    return dr.rcp(1 + dr.square(quotient))
