"""Camera kinds, each in a module of its name; importing this package registers them all."""

from renderer.cameras import orthographic, pinhole, thinlens
from renderer.cameras.base import KINDS


def kind_of(camera):
    """Return the kind of a validated camera: a lens without an aperture is a pinhole."""
    return KINDS["pinhole" if camera.type == "thinlens" and camera.apertureRadius == 0 else camera.type]


__all__ = ["KINDS", "kind_of", "orthographic", "pinhole", "thinlens"]
