"""BSDF kinds, each in a module of its name; importing this package registers them all."""

from renderer.bsdfs import (
    conductor, coursework, dielectric, diffuse, mirror, plastic, principled, roughconductor, roughdielectric,
)
from renderer.bsdfs.base import KINDS

__all__ = ["KINDS", "conductor", "coursework", "dielectric", "diffuse", "mirror", "plastic", "principled",
           "roughconductor", "roughdielectric"]  # fmt: skip
