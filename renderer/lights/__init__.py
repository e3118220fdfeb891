"""Light kinds, each in a module of its name; importing this package registers them all."""

from renderer.lights import arealight, directional, disklight, pointlight, spot
from renderer.lights.base import KINDS

__all__ = ["KINDS", "arealight", "directional", "disklight", "pointlight", "spot"]
