"""From the description to the tree of Mitsuba plugins that stock Mitsuba can render.

What it cannot express is replaced by the nearest stock counterpart and named in the warnings:

- A point light without fall-off becomes one with 1/r^2 and intensity pi * d^2 * I, where d is the median distance from
  the light to the shapes: Lambert's kd Cd / pi times I_stock / d^2 is then kd Cd I at that distance.
- The ambient term becomes the light of the background (a constant emitter, which is also what is seen behind the
  shapes), and what the background lacks in brightness a lamp at the camera, whose shadows nobody sees.
- Loose triangles become one mesh for each material where they are many.
- Mode `pathtracer` means the same in Mitsuba, but for parts of the coursework's material (`paths`).
- Binary and debug pictures become channels of the `aov` integrator.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from converters.cameras import NEAR
from converters.geometry import joined
from converters.meshes import placement
from converters.mitsuba import lamps, materials, paths
from converters.mitsuba.nodes import Colour, Node, Pixels, Plan, Point
from converters.mitsuba.paths import part_node, sensor_node
from converters.nesting import outside_indices
from converters.solids import is_unbounded, parts, textured_plane
from renderer.core.errors import Problem
from renderer.io.image import read_texture
from renderer.io.mesh import read_mesh

AOVS = {"binary": "binary:albedo", "depth": "depth:depth,position:position", "normals": "normal:geo_normal",
        "uv": "uv:uv", "albedo": "albedo:albedo", "shapes": "shape:shape_index"}
AOV_REMARKS = {
    "depth": "Mitsuba measures depth from the near plane; the position channels are exact",
    "uv": "texture coordinates of caps and planes are Mitsuba's own",
    "shapes": "Mitsuba counts primitives: a cylinder is three shapes",
}
SAMPLES = 64  # rays a pixel where the scene asks for one: the stock counterpart is a Monte Carlo estimate
SOUP = 64  # triangles; of more, those of one material become one mesh, because each is a file and a shape otherwise
MOST_PLACES = 8  # that a remark names
NEVER = 1000  # path length from which Russian roulette starts: it would only add noise


class _Remarks:
    """Collects what is not exact: each remark once, with all the places it is about."""

    def __init__(self):
        self.places = {}

    def at(self, place):
        """Return a function that takes down a remark about a place in the scene file."""
        return lambda text: self.places.setdefault(text, {}).setdefault(place)

    def problems(self, path):
        """Return one Problem a remark; several places are written as one list, which ends where it gets long."""
        return tuple(Problem(path, text, _listed(list(places))) for text, places in self.places.items())


def _listed(places):
    """Return the first places, and how many there are beside."""
    rest = len(places) - MOST_PLACES
    return ", ".join(places[:MOST_PLACES]) + (f" and {rest} more" if rest > 0 else "")


def plan(loaded, exact=False):
    """Return the Plan of a loaded scene; raises SceneError where a texture or mesh cannot be read.

    `exact` allows plugins of our own, which only code that imports `converters` can use.
    """
    remarks, mode = _Remarks(), loaded.description.rendermode
    if mode == "pathtracer":
        return Plan(paths.children(loaded, remarks, exact), remarks.problems(loaded.path))
    children = {"integrator": _integrator(loaded.description, remarks.at("rendermode")),
                "sensor": _sensor(loaded.description)}
    if mode == "phong":
        children.update(_emitters(loaded, remarks))
    children.update(_shapes(loaded, remarks))
    return Plan(children, remarks.problems(loaded.path))


def _integrator(description, remark):
    """Return the integrator that comes nearest to the render mode."""
    if description.rendermode != "phong":
        remark(f"{description.rendermode} picture written as channels of the aov integrator")
        if description.rendermode in AOV_REMARKS:
            remark(AOV_REMARKS[description.rendermode])
        return Node("integrator", "aov", {"aovs": AOVS[description.rendermode]})
    if not any(materials.share(s.material) for s in description.scene.shapes):
        return Node("integrator", "direct")
    remark("mirrors and glass are followed by the path integrator, which adds light between matt surfaces")
    # N bounces are N + 1 segments; the last surface needs one more to reach a light.
    return Node("integrator", "path", {"max_depth": description.nbounces + 2, "rr_depth": NEVER})


def _sensor(description):
    """Return the camera; its film has the box filter, which keeps pixels independent."""
    box, has_lens = Node("rfilter", "box"), description.spp > 1  # one ray a pixel goes through the lens's middle
    if description.rendermode == "phong":
        sampler = Node("sampler", "independent", {"sample_count": description.spp if has_lens else SAMPLES})
        return sensor_node(description.camera, sampler, box, has_lens)
    sampler = Node("sampler", "stratified", {"jitter": False, "sample_count": 1})
    return sensor_node(description.camera, sampler, box, False)


def _centre(loaded, shape, look_at):
    """Return a point in the middle of the shape; of a plane the foot of the point looked at."""
    if shape.type == "mesh":
        vertices = read_mesh(str(loaded.resolve(shape.filename))).vertices
        to_world = placement(shape.transform)
        return to_world[:3, :3] @ (vertices.min(axis=0) / 2 + vertices.max(axis=0) / 2) + to_world[:3, 3]
    if shape.type in ("sphere", "cylinder"):
        return np.asarray(shape.center)
    if shape.type == "plane":
        normal = np.asarray(shape.normal) / np.linalg.norm(shape.normal)
        return look_at - normal * (normal @ (look_at - np.asarray(shape.point)))
    if shape.type == "box":
        return (np.asarray(shape.min) + np.asarray(shape.max)) / 2
    if shape.type == "triangle":
        return np.mean([shape.v0, shape.v1, shape.v2], axis=0)
    return np.mean([part.mesh.vertices.mean(axis=0) for part in parts(shape)], axis=0)


def _typical_distance(loaded, position):
    """Return the median distance from a point to the middles of the shapes, in scene units."""
    look_at = np.asarray(loaded.description.camera.lookAt)
    centres = [_centre(loaded, shape, look_at) for _, shape in loaded.shapes] or [look_at]
    return max(float(np.median(np.linalg.norm(np.array(centres) - position, axis=1))), NEAR)


def _brightened(loaded, position, intensity):
    """Return the intensity of a light with fall-off that is as bright at the median distance of the shapes."""
    scale = np.pi * _typical_distance(loaded, position) ** 2
    return Colour(float(scale * c) for c in intensity)


def _point_light(loaded, position, intensity):
    """Return a point light with fall-off, brightened."""
    return Node("emitter", "point", {"position": Point(map(float, position)),
                                     "intensity": _brightened(loaded, position, intensity)})


def _light(loaded, light, remark):
    """Return the nearest counterpart of a light that lights without falling off."""
    if light.type == "directional":  # Lambert's kd Cd / pi times the irradiance is kd Cd times the intensity
        return lamps.directional(light, Colour(float(np.pi * c) for c in light.intensity))
    remark("light without fall-off written as one with 1/r^2, as bright at the median distance of the shapes")
    if light.type == "spot":
        return lamps.spot(light, _brightened(loaded, light.position, light.intensity))
    return _point_light(loaded, light.position, light.intensity)


def _emitters(loaded, remarks):
    """Return the lights: points with fall-off, the background, and a lamp at the camera for the rest of the ambient."""
    world, result = loaded.description.scene, {}
    around = lamps.environment(loaded)
    for k, light in enumerate(world.lightsources):
        remark = remarks.at(f"scene.lightsources[{k}]")
        if light.type == "environment":
            result[f"light{k}"] = around
            remark("the image all around also lights the shapes")
        else:
            result[f"light{k}"] = _light(loaded, light, remark)
    if max(world.backgroundcolor) > 0 and not around:
        result["background"] = Node("emitter", "constant", {"radiance": Colour(map(float, world.backgroundcolor))})
        remarks.at("scene.backgroundcolor")("the background also lights the shapes")
    if max(world.ambientlight) > 0:
        rest = [max(a - b, 0.0) for a, b in zip(world.ambientlight, world.backgroundcolor)]
        if max(rest) > 0:
            result["ambient"] = _point_light(loaded, loaded.description.camera.position, rest)
        remarks.at("scene.ambientlight")("ambient term written as the background's light and a lamp at the camera")
    return result


def _shapes(loaded, remarks):
    """Return the nodes of all primitives, in the order of the file."""
    result, soups = {}, _soups(loaded)
    outside = outside_indices([shape for _, shape in loaded.shapes])
    for (number, shape), around in zip(loaded.shapes, outside):
        remark = remarks.at(f"scene.shapes[{number}]")
        if is_unbounded(shape):
            remark("unbounded convex volume is cut off far away")
        for part in soups[number] if number in soups else _stock_parts(loaded, shape, remark):
            bsdf = _bsdf(loaded, number, shape.material, around, part, remark)
            result[f"shape{number}_{part.name}"] = part_node(part, {"bsdf": bsdf})
    return result


def _soups(loaded):
    """Return {number: [part]} of many triangles: the first of a material stands for all of it, the others are nothing.

    In shapes mode each keeps its number.
    """
    alike, result = {}, {}
    for number, shape in loaded.shapes:
        if shape.type == "triangle":
            alike.setdefault(shape.material, []).append((number, parts(shape)[0]))
    if loaded.description.rendermode == "shapes" or sum(map(len, alike.values())) <= SOUP:
        return {}
    for members in alike.values():
        first, part = members[0]
        result |= {number: [] for number, _ in members}
        result[first] = [replace(part, name="triangles", mesh=joined([other.mesh for _, other in members]))]
    return result


def _stock_parts(loaded, shape, remark):
    """Return the primitives of a shape; of a textured plane a finite one."""
    mode = loaded.description.rendermode
    if shape.type == "plane" and shape.material.texture is not None and mode in ("phong", "albedo"):
        remark("infinite textured plane written as a large finite rectangle around its point")
        return [textured_plane(shape)]
    return parts(shape, loaded.resolve)


def pixels(loaded, number, material):
    """Return the image that the material names, or None; raises SceneError where it cannot be read."""
    if not isinstance(material.texture, str):
        return None
    return Pixels(f"shape{number}", *read_texture(loaded.resolve(material.texture)))


def _bsdf(loaded, number, material, outside, part, remark):
    """Return the node of a primitive's material in a render mode."""
    mode = loaded.description.rendermode
    if mode == "binary":
        return materials.matt(materials.BINARY_RED)
    image = pixels(loaded, number, material) if mode in ("phong", "albedo") else None
    if mode == "phong":
        return materials.phong(material, outside, image, part.uv_map, remark)
    if mode == "albedo":
        return materials.matt(materials.texture(material, image, part.uv_map, remark=remark))
    # Mitsuba merges meshes of equal material into one shape: a grey of its own keeps each shape's number.
    return materials.matt(Colour(3 * ((number + 1) / (len(loaded.description.scene.shapes) + 1),)))
