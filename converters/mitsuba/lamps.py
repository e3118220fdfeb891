"""Lights of mode `pathtracer`, and shapes that shine, as Mitsuba's emitters.

Mitsuba's area lights shine on the side of the normal only: what shines on both sides is written twice, back to back.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from converters.geometry import Mesh, frame, matrix, unit
from converters.mitsuba.nodes import Colour, Environment, Node, Point
from converters.solids import LOWER_CAP_UV, Part, sheet_mesh

HAIR = 1e-5  # distance between the two sides of a sheet, in its size or largest coordinate
TURNED_UV = np.array([[-1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])  # of a rectangle seen from behind
GREATEST = 10.0  # scene units: planes have no size that a hair could be part of
BEAM = 0.75  # of a spot's cutoff, where the file has no beamwidth
BLACK = Node("bsdf", "diffuse", {"reflectance": Colour((0.0, 0.0, 0.0))})


def colour(values):
    """Return three numbers as a Colour."""
    return Colour(map(float, values))


def area(radiance):
    """Return the emitter that makes a primitive shine."""
    return Node("emitter", "area", {"radiance": colour(radiance)})


def emitters(loaded):
    """Return {name: node} of the lights that are no shapes, and of the background."""
    world, result = loaded.description.scene, {}
    for number, light in enumerate(world.lightsources):
        if light.type in _EMITTERS:
            result[f"light{number}"] = _EMITTERS[light.type](loaded, light)
    surrounded = any(light.type == "environment" for light in world.lightsources)
    if max(world.backgroundcolor) > 0 and not surrounded:
        result["background"] = Node("emitter", "constant", {"radiance": colour(world.backgroundcolor)})
    return result


def environment(loaded):
    """Return the node of the image that is all around, or None."""
    found = [light for light in loaded.description.scene.lightsources if light.type == "environment"]
    return _environment(loaded, found[0]) if found else None


def lamps(loaded):
    """Return {name: (part, radiance)} of the lights that are seen as black shapes that shine."""
    result = {}
    for number, light in enumerate(loaded.description.scene.lightsources):
        if light.type not in _SHEETS:
            continue
        part = _SHEETS[light.type](light)
        for name, side in (both_sides(part) if light.twosided else {"front": part}).items():
            result[f"light{number}_{name}"] = side, light.intensity
    return result


def both_sides(part):
    """Return {name: part} of a flat part and of its reverse, a hair apart; texture coordinates stay in place."""
    if part.kind == "mesh":
        corners = part.mesh.vertices
        normal = unit(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
        size = np.abs(corners).max() + np.ptp(corners, axis=0).max()
        front, back = (replace(part, mesh=Mesh(corners + side * HAIR * size * normal, faces, part.mesh.uv))
                       for side, faces in ((1, part.mesh.faces), (-1, part.mesh.faces[:, ::-1])))
        return {"front": front, "back": back}
    x, y, _, origin = part.to_world[:3].T
    normal = unit(np.cross(x, y))
    step = HAIR * normal * (np.abs(origin).max() + min(np.linalg.norm(x) + np.linalg.norm(y), GREATEST))
    front = replace(part, to_world=matrix(x, y, normal, origin + step))
    if part.kind == "disk":  # its azimuth runs backwards, as that of the lower cap of a cylinder
        back = replace(part, to_world=matrix(x, -y, -normal, origin - step),
                       uv_map=None if part.uv_map is None else LOWER_CAP_UV)
    else:
        back = replace(part, to_world=matrix(-x, y, -normal, origin - step), uv_map=part.uv_map @ TURNED_UV)
    return {"front": front, "back": back}


def _point(loaded, light):
    """Return the emitter of a point light."""
    return Node("emitter", "point", {"position": Point(map(float, light.position)),
                                     "intensity": colour(light.intensity)})


def beam_deg(light):
    """Return the half angle of the full part of a spot's cone, in degrees."""
    return BEAM * light.cutoff if light.beamwidth is None else light.beamwidth


def spot(light, intensity):
    """Return a spot with another intensity (Colour)."""
    direction = unit(light.direction)
    t, b = frame(direction)
    return Node("emitter", "spot", {
        "to_world": matrix(t, b, direction, light.position), "intensity": intensity,
        "cutoff_angle": float(light.cutoff), "beam_width": float(beam_deg(light))})


def directional(light, irradiance):
    """Return a directional light with another irradiance (Colour)."""
    t, b = frame(unit(light.direction))
    return Node("emitter", "directional", {
        "to_world": matrix(t, b, unit(light.direction), (0.0, 0.0, 0.0)), "irradiance": irradiance})


def _environment(loaded, light):
    """Return the emitter of an image that is all around, turned about +y."""
    turn = np.radians(light.rotation)
    c, s = np.cos(turn), np.sin(turn)
    rotation = matrix((c, 0, -s), (0, 1, 0), (s, 0, c), (0, 0, 0))
    return Node("emitter", "envmap", {
        "image": Environment(str(loaded.resolve(light.filename)), tuple(map(float, light.intensity))),
        "to_world": rotation})


_EMITTERS = {"pointlight": _point, "spot": lambda loaded, light: spot(light, colour(light.intensity)),
             "directional": lambda loaded, light: directional(light, colour(light.intensity)),
             "environment": _environment}


def _rectangle(light):
    """Return the part of a lamp that is a parallelogram."""
    return sheet_mesh("lamp", light.position, light.u, light.v)


def _disk(light):
    """Return the part of a lamp that is a disk."""
    normal = unit(light.normal)
    t, b = (light.radius * v for v in frame(normal))
    return Part("lamp", "disk", matrix(t, b, normal, light.position))


_SHEETS = {"arealight": _rectangle, "disklight": _disk}
