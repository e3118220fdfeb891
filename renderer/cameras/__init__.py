"""Camera kinds, each in a module of its name; importing this package registers them all."""

from renderer.cameras import pinhole, thinlens
from renderer.cameras.base import KINDS


def kind_of(camera):
    """Return the kind of a validated camera: a lens without an aperture is a pinhole."""
    return KINDS[camera.type if camera.apertureRadius > 0 else "pinhole"]


__all__ = ["KINDS", "kind_of", "pinhole", "thinlens"]
