"""What a camera kind provides, and the registry that finds it by its name in the scene file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from renderer.core.registry import Registry


@dataclass(frozen=True)
class CameraKind:
    """`pack(camera)` returns its record on the host; `ray(row, position)` returns origins and unit directions.

    `position` is the point on the picture in pixels, from the top left corner, in lanes.
    """

    name: str
    pack: Callable
    ray: Callable


KINDS = Registry()
register = KINDS.register
