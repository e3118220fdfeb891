"""What a light kind provides, and the registry that finds it by its name in the scene file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from renderer.core.backend import Float, Vector3f


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


KINDS = {}


def register(kind):
    """Add a kind to those that scenes may name."""
    assert kind.name not in KINDS, kind.name
    KINDS[kind.name] = kind
