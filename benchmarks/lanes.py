"""Arrays of the host as lanes, for the renderer's types and for Mitsuba's."""

from __future__ import annotations

import drjit as dr
import numpy as np

from renderer.core.backend import from_host


def lanes(kind, host):
    """Return an array of the host as one of a Dr.Jit type."""
    return from_host(kind, np.ascontiguousarray(host))


def vectors(vector, kind, host):
    """Return (N, 3) numbers as lanes of vectors."""
    return vector(*(lanes(kind, column) for column in host.T))


def done(*arrays):
    """Return arrays as soon as they are there."""
    dr.eval(*arrays)
    dr.sync_thread()
    return arrays
