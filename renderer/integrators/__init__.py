"""Integrators: from camera rays to radiance, one module a render mode; importing this package registers them."""

from renderer.integrators import binary, first_hit, path, phong
from renderer.integrators.base import INTEGRATORS

__all__ = ["INTEGRATORS", "binary", "first_hit", "path", "phong"]
