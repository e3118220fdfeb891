"""Arrays of the host as lanes, for the renderer's types and for Mitsuba's."""

from __future__ import annotations

import drjit as dr
import numpy as np


def lanes(kind, host):
    """Return an aligned array of a Dr.Jit type; arrays that numpy lends are not, and load more slowly."""
    array = kind(np.ascontiguousarray(host)) + dr.opaque(kind, 0)
    dr.eval(array)
    return array


def vectors(vector, kind, host):
    """Return (N, 3) numbers as lanes of vectors."""
    return vector(*(lanes(kind, column) for column in host.T))


def done(*arrays):
    """Return arrays as soon as they are there."""
    dr.eval(*arrays)
    dr.sync_thread()
    return arrays
