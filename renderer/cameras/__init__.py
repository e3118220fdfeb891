"""Camera kinds, each in a module of its name; importing this package registers them all."""

from renderer.cameras import pinhole
from renderer.cameras.base import KINDS

__all__ = ["KINDS", "pinhole"]
