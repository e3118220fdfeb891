"""What a light kind provides, and the registry that finds it by its name in the scene file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from renderer.core.backend import Float, Vector3f
from renderer.core.registry import Registry


@dataclass
class LightSample:
    """Light that may reach a point: test the segment for shadow, then use `radiance`."""

    wo: Vector3f  # unit direction from the point to the light
    distance: Float  # scene units
    radiance: Vector3f  # what arrives without falling off, as phong mode wants it


@dataclass(frozen=True)
class LightKind:
    """`pack(light)` returns its record on the host; `sample(row, p)` returns a LightSample for points in lanes."""

    name: str
    pack: Callable
    sample: Callable


KINDS = Registry()
register = KINDS.register
