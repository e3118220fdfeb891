"""Shape kinds, each in a module of its name; importing this package registers them all."""

from renderer.shapes import box, convex, cylinder, disk, plane, rectangle, sphere, triangle
from renderer.shapes.base import KINDS

__all__ = ["KINDS", "box", "convex", "cylinder", "disk", "plane", "rectangle", "sphere", "triangle"]
