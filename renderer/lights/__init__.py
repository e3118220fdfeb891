"""Light kinds, each in a module of its name; importing this package registers those of phong mode.

`environment`, `mesh`, `sheet` and `sphere` are what shines in path-traced scenes besides points.
"""

from renderer.lights import arealight, directional, disklight, environment, mesh, pointlight, sheet, sphere, spot
from renderer.lights.base import KINDS

__all__ = [
    "KINDS", "arealight", "directional", "disklight", "environment", "mesh", "pointlight", "sheet", "sphere", "spot"
]  # fmt: skip
