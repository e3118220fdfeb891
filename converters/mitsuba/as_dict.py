"""A plan as Mitsuba objects and the dictionary that `mi.load_dict` takes."""

from __future__ import annotations

import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

from converters.geometry import joined
from converters.meshes import MeshFile
from converters.mitsuba import materials, srgb
from converters.mitsuba.nodes import Colour, Environment, Node, Pixels, Point
from converters.mitsuba.plan import part_node, pixels

if mi.variant() is None:
    mi.set_variant("llvm_ad_rgb")


def _tensor(image, raw):
    """Return the image as (H, W, 3) float32: of c / 255 if `raw`, else decoded from sRGB."""
    array = np.frombuffer(image.rgb, np.uint8).reshape(image.height, image.width, 3) / 255
    return mi.TensorXf((array if raw else srgb.decoded(array)).astype(np.float32))


def _environment(image):
    """Return Mitsuba's bitmap of an environment: linear RGB times the factor, mirrored as our pictures are."""
    whole = mi.Bitmap(image.path).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return mi.Bitmap(np.ascontiguousarray(np.array(whole)[:, ::-1] * np.float32(image.factor)))


def _mesh(node):
    """Return a flat-shaded mesh that owns the node's children (material, attributes)."""
    properties = mi.Properties()
    for name, child in node.values.items():
        if isinstance(child, Node):
            properties[name] = mi.load_dict(dictionary(child))
    return _flat(node.values["mesh"], properties)


def _flat(mesh, properties):
    """Return Mitsuba's mesh of a Mesh, with the given children."""
    result = mi.Mesh("mesh", len(mesh.vertices), len(mesh.faces), props=properties, has_vertex_normals=False,
                     has_vertex_texcoords=True)
    data = mi.traverse(result)
    data["vertex_positions"] = np.ravel(mesh.vertices).astype(np.float32)
    data["faces"] = np.ravel(mesh.faces).astype(np.uint32)
    data["vertex_texcoords"] = np.ravel(mesh.uv).astype(np.float32)
    data.update()
    return result


def _mesh_file(node):
    """Return the mesh that Mitsuba reads from a file, with the node's children."""
    file = node.values["file"]
    if not file.drops_normals:
        result = mi.load_dict(_reader(node, file.plugin, file.path, file.settings))
        if file.negates_normals:
            data = mi.traverse(result)
            data["vertex_normals"] = -mi.Float(data["vertex_normals"])
            data.update()
        return result
    # Mitsuba computes normals of meshes that come without them, so it writes one such and reads it again.
    bare = mi.load_dict({"type": file.plugin, "filename": str(file.path), "face_normals": True})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bare.ply"
        bare.write_ply(str(path))
        return mi.load_dict(_reader(node, "ply", path, file.settings))


def _reader(node, plugin, path, settings):
    """Return the dictionary of a plugin that reads a mesh file."""
    children = {name: value for name, value in node.values.items() if not isinstance(value, MeshFile)}
    return dictionary(Node(node.family, plugin, {"filename": str(path), **settings, **children}))


def dictionary(node):
    """Return a node as `mi.load_dict` takes it: a dictionary, or an object for a mesh."""
    if "mesh" in node.values:
        return _mesh(node)
    if "file" in node.values:
        return _mesh_file(node)
    result = {"type": node.type}
    for name, value in node.values.items():
        if isinstance(value, Node):
            result[name] = dictionary(value)
        elif isinstance(value, Colour):
            result[name] = {"type": "rgb", "value": list(value)}
        elif isinstance(value, Point):
            result[name] = list(value)
        elif isinstance(value, Pixels):
            result["data"] = _tensor(value, node.values["raw"])
        elif isinstance(value, Environment):
            result["bitmap"] = _environment(value)
        elif isinstance(value, np.ndarray):
            result[name] = (mi.ScalarTransform3f if value.shape == (3, 3) else mi.ScalarTransform4f)(value)
        else:
            result[name] = value
    if "data" in result:
        result["raw"] = True  # decoded here
    return result


def scene_dictionary(plan):
    """Return the whole plan as the dictionary of a scene."""
    from converters import coursework_bsdf  # noqa: F401 (registers a plugin, for which the variant must be chosen)

    return {"type": "scene", **{name: dictionary(node) for name, node in plan.children.items()}}


def part_object(part, attributes):
    """Return a primitive that carries constant scalar attributes, for integrators of our own."""
    constants = {name: Node("texture", "rawconstant", {"value": value}) for name, value in attributes.items()}
    return dictionary(part_node(part, constants))


def soup_object(meshes, attributes):
    """Return one mesh of several that have one triangle each; `attributes` have a value for each of these."""
    result = _flat(joined(meshes), mi.Properties())
    for name, values in attributes.items():
        result.add_attribute(name, 1, np.asarray(values, np.float32))
    return result


def texture_object(loaded, material):
    """Return Mitsuba's texture of a material, for the scene format's own texture coordinates."""
    node = materials.texture(material, pixels(loaded, 0, material))
    return mi.load_dict(dictionary(node))
