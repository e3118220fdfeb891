"""Textures: what replaces a constant colour."""

from renderer.textures import bitmap, checkerboard

__all__ = ["bitmap", "checkerboard"]
