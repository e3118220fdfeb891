"""Integrators: from camera rays to radiance, one module a render mode."""

from renderer.integrators import binary, first_hit, phong
from renderer.integrators.base import INTEGRATORS

__all__ = ["binary", "first_hit", "integrator_of", "phong"]


def integrator_of(mode):
    """Return the integrator of a render mode: a function (scene, bounces)."""
    if mode not in INTEGRATORS:
        from renderer.integrators import path  # noqa: F401 (registers itself; the other modes start faster without)
    return INTEGRATORS[mode]
