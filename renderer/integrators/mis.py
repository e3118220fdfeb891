"""Multiple importance sampling of two strategies."""

import drjit as dr

from renderer.core.numeric import TINY, greater


def power_heuristic(pdf, other_pdf):
    """Return the weight of a sample with density `pdf` that the other strategy finds with `other_pdf`.

    Both are of the same measure; squares of their quotient cannot overflow early. `pdf` 0 gives 0 unless both are 0.
    Source: [Veach1997, sec. 9.2.4].
    """
    quotient = other_pdf / greater(pdf, TINY)
    return dr.rcp(1 + dr.square(quotient))
