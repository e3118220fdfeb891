"""Scenes of mode `pathtracer` for Mitsuba's path integrator: what both can express means the same in both."""

from __future__ import annotations

from converters import cameras
from converters.mitsuba import bsdfs, lamps
from converters.mitsuba.nodes import Node
from converters.nesting import index_of, outside_indices
from converters.solids import far_plane, is_unbounded, parts, textured_plane

NEVER = 1_000_000  # path length from which Russian roulette starts: it would only add noise
FILTERS = {"box": {}, "tent": {"radius": 1.0}, "gaussian": {"stddev": 0.5}, "mitchell": {"B": 1 / 3, "C": 1 / 3}}
FLAT = ("triangle", "rectangle", "disk", "plane")  # shine on both sides


def children(loaded, remarks, exact):
    """Return {name: node} of the whole scene; `exact` allows plugins of our own."""
    description = loaded.description
    # N bounces are N + 1 segments.
    integrator = Node("integrator", "path", {
        "max_depth": description.nbounces + 1, "rr_depth": NEVER, "hide_emitters": False})
    result = {"integrator": integrator, "sensor": _sensor(description), **lamps.emitters(loaded)}
    for name, (part, radiance) in lamps.lamps(loaded).items():
        result[name] = part_node(part, {"bsdf": lamps.BLACK, "emitter": lamps.area(radiance)})
    outside = outside_indices([shape for _, shape in loaded.shapes], description.rendermode)
    for (number, shape), around in zip(loaded.shapes, outside):
        result |= _shape(loaded, number, shape, around, remarks.at(f"scene.shapes[{number}]"), exact)
    return result


def _shape(loaded, number, shape, outside, remark, exact):
    """Return {name: node} of one shape's primitives."""
    if is_unbounded(shape):
        remark("unbounded convex volume is cut off far away")
    primitives = parts(shape, loaded.resolve)
    if shape.type == "plane" and bsdfs.textures(shape.material):
        remark("infinite textured plane written as a large rectangle around its point, of its mean colour beyond")
        primitives = [textured_plane(shape), far_plane(shape)]
    shines = max(shape.emission) > 0
    named = {part.name: part for part in primitives}
    if shines and shape.type in FLAT:
        if index_of(shape.material, loaded.description.rendermode) is not None:
            remark("shining sheet of glass written as two sheets, back to back")
        named = {f"{part.name}_{side}": half for part in primitives for side, half in lamps.both_sides(part).items()}
    result = {}
    for name, part in named.items():
        surface = bsdfs.Surface(loaded, number, shape.material, outside, part.uv_map, remark, exact)
        if part.uv_map is None:
            surface = bsdfs.evened(surface)
        inside = {"bsdf": bsdfs.bsdf(surface), **({"emitter": lamps.area(shape.emission)} if shines else {})}
        result[f"shape{number}_{name}"] = part_node(part, inside)
    return result


def part_node(part, inside):
    """Return the primitive as a node with the given children (material, emitter, attributes)."""
    named = {"mesh": part.mesh, "file": part.file, "to_world": part.to_world}
    return Node("shape", part.kind, {**{name: value for name, value in named.items() if value is not None}, **inside})


def _sensor(description):
    """Return the camera with the scene's filter and number of samples."""
    sampler = Node("sampler", "independent", {"sample_count": description.spp})
    return sensor_node(description.camera, sampler, Node("rfilter", description.filter, FILTERS[description.filter]))


def sensor_node(camera, sampler, pixel_filter, with_lens=True):
    """Return the camera as a node."""
    film = Node("film", "hdrfilm", {"width": camera.width, "height": camera.height, "pixel_format": "rgb",
                                    "component_format": "float32", "filter": pixel_filter})
    kind, parameters = cameras.sensor(camera, with_lens)
    return Node("sensor", kind, {**parameters, "film": film, "sampler": sampler})
