"""Sample generators."""

from renderer.samplers import r2

__all__ = ["r2"]
