"""No structure: every ray tests every leaf. What the others are compared with, and the best for a handful."""

import drjit as dr

from renderer.accel.records import WORDS, closest, read
from renderer.core.backend import UInt32
from renderer.core.numeric import widened


class BruteForce:
    """The interface of Bvh, by a loop over the leaf records (UInt32, evaluated, 16 words each)."""

    def __init__(self, records):
        self._records, self._count = records, dr.opaque(UInt32, len(records) // WORDS)

    def trace(self, ray, t, index, leaf, active, any_hit=False):
        """Return distance and index of each active ray's closest hit, or of any; where it has none, what was given."""
        lanes = max(dr.width(ray), dr.width(t), dr.width(active))
        t, index, active = (widened(value, lanes) for value in (t, index, active))

        def test(k, t, index, active):
            t, index, closer = closest(t, index, active, *leaf(read(self._records, k, active)))
            k += 1
            return k, t, index, active & (k < self._count) & ~(closer & any_hit)

        _, t, index, _ = dr.while_loop(
            (dr.zeros(UInt32, lanes), t, index, active), lambda k, t, index, active: active, test, label="all leaves"
        )
        return t, index
