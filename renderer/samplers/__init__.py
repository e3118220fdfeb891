"""Sample generators."""

from renderer.samplers import independent, r2, sobol
from renderer.samplers.base import KINDS

__all__ = ["KINDS", "independent", "r2", "sobol"]
