"""Lamps: area lights as the shapes that path-traced scenes see."""

from __future__ import annotations

import dataclasses

from renderer.scene import schema
from renderer.scene.materials import Diffuse, Material

BLACK = Material(bsdf=Diffuse(type="diffuse", reflectance=(0.0, 0.0, 0.0)))


def with_lamps(loaded):
    """Return the scene with a black shining shape for each area light.

    The lamp of light k has the index `lamp_index(loaded, k)`, beyond those of the file's own shapes.
    """
    lamps = [
        (lamp_index(loaded, k), _lamp(light))
        for k, light in enumerate(loaded.description.scene.lightsources)
        if light.type in ("arealight", "disklight")
    ]
    return dataclasses.replace(loaded, shapes=(*loaded.shapes, *lamps)) if lamps else loaded


def lamp_index(loaded, light):
    """Return the index of the lamp of a light (by its index in the file)."""
    return len(loaded.description.scene.shapes) + light


def _lamp(light):
    """Return the shape of an area light."""
    shared = {"center": light.position, "material": BLACK, "emission": light.intensity}
    if light.type == "arealight":
        return schema.Rectangle(type="rectangle", u=light.u, v=light.v, **shared)
    return schema.Disk(type="disk", normal=light.normal, radius=light.radius, **shared)
