"""Sample generators."""

from renderer.samplers import independent, sobol
from renderer.samplers.base import KINDS

__all__ = ["KINDS", "independent", "sobol"]
