"""Lights that are none, that light nothing, or of which there are too many; and scenes that nothing lights."""

from __future__ import annotations

from renderer.scene import schema
from renderer.scene.checks_shapes import directed, spanned
from renderer.scene.findings import NOTE, Finding, linked
from renderer.scene.media import CLOSED, encloses, index_of


def check_lights(description, kept, findings):
    """Append what is wrong or odd about the lights of a description, of which `kept` is what can be rendered."""
    world, before = description.scene, len(findings)
    if world.lightsources is None:
        return
    lights = [(k, light) for k, light in enumerate(world.lightsources) if light is not None]
    lights_at, environments = linked(("scene", "lightsources")), 0
    for number, light in lights:
        CHECKS[light.type](light, (lights_at, number), findings)
        environments += light.type == "environment"
        if light.type == "environment" and environments == 2:
            findings.append(Finding((lights_at, number), "must be the only environment: one is all around"))
    if len(findings) > before or description.rendermode not in schema.SHADED_MODES:
        return
    for number, light in lights:
        if not any(light.intensity):
            findings.append(Finding((lights_at, number), "gives no light: its intensity is 0", severity=NOTE))
    _note_walls(description, kept, lights, findings)
    if description.rendermode == "phong":
        _note_phong(description, lights, findings)
    elif not _shines(world, lights):
        message = "nothing gives light (lightsources, emission and backgroundcolor): the picture will be black"
        findings.append(Finding((None, "scene"), message, severity=NOTE))


def _note_walls(description, kept, lights, findings):
    """Find lights walled in by a shape; light of path-traced scenes gets out of glass."""
    paths = description.rendermode == schema.PATHTRACER
    closed = [(index, shape) for index, shape in kept
              if shape.type in CLOSED and not (paths and index_of(shape.material, paths) is not None)]
    for number, light in lights:
        position = getattr(light, "position", None)
        for index, shape in closed:
            if position and encloses(shape, [position]):
                message = f"is inside scene.shapes[{index}] ({shape.type}), so it lights nothing outside of it"
                findings.append(Finding(linked(("scene", "lightsources", number, "position")), message, severity=NOTE))
                break


def _note_phong(description, lights, findings):
    """Find phong scenes that nothing lights, and area lights of which one ray a pixel shows one point."""
    world = description.scene
    if not world.lightsources and world.shapes:
        findings.append(Finding((None, "scene"), "has no lightsources; only ambientlight will be seen", severity=NOTE))
    areas = [number for number, light in lights if light.type in ("arealight", "disklight")]
    if areas and description.spp == 1:
        at = linked(("scene", "lightsources", areas[0]))
        findings.append(Finding(at, "casts soft shadows with samples > 1 only; one ray a pixel sees one point of it",
                                severity=NOTE))


def _shines(world, lights):
    """Return whether anything gives light in a path-traced scene, or may do when mistakes are mended."""
    background = world.backgroundcolor is None or any(world.backgroundcolor)
    around = background and all(light.type != "environment" for _, light in lights)
    shapes = any(shape is None or any(shape.emission) for shape in world.shapes or ())
    return around or shapes or any(any(light.intensity) for _, light in lights) or None in world.lightsources


# Lights that are none


def _check_nothing(light, at, findings):
    """What its keys say is all that there is to check."""


def _check_spot(light, at, findings):
    directed(light, "direction", "light", at, findings)
    if light.beamwidth is not None and light.beamwidth > light.cutoff:
        message = f"must not be greater than cutoff, which is {light.cutoff:g}"
        findings.append(Finding((at, "beamwidth"), message, light.beamwidth))


def _check_directional(light, at, findings):
    directed(light, "direction", "light", at, findings)


def _check_area(light, at, findings):
    spanned(light, "light", at, findings)


def _check_disk(light, at, findings):
    directed(light, "normal", "light", at, findings)


CHECKS = {
    "pointlight": _check_nothing, "spot": _check_spot, "directional": _check_directional, "arealight": _check_area,
    "disklight": _check_disk, "environment": _check_nothing,
}
