"""What a light kind provides, and the registry that finds it by its name in the scene file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.registry import Registry


@dataclass
class LightSample:
    """Light that may reach a point: test the segment for shadow, then use `radiance`."""

    wo: Vector3f  # unit direction from the point to the light
    distance: Float  # scene units
    radiance: Vector3f  # what arrives without falling off, as phong mode wants it


@dataclass
class DirectSample:
    """A direction from which light arrives in path-traced scenes, and with which density it was chosen."""

    wo: Vector3f  # unit direction from the point to the light
    distance: Float  # scene units; FAR for what is infinitely far away
    radiance: Vector3f  # towards the point; of a point light intensity / distance^2; 0 where the light does not shine
    pdf_sa: Float  # per steradian; 1 for lights that rays cannot hit
    delta: Bool  # whether rays cannot hit it


@dataclass(frozen=True)
class LightKind:
    """`pack(light)` returns its record on the host; `sample(row, p)` returns a LightSample for points in lanes."""

    name: str
    pack: Callable
    sample: Callable


KINDS = Registry()
register = KINDS.register
