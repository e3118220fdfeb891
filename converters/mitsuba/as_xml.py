"""A plan as XML text with its meshes and images beside it.

Transforms are written as explicit matrices: Mitsuba's own XML writer turns mirrored cameras the wrong way.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from converters.geometry import Mesh
from converters.mitsuba.nodes import Colour, Environment, Node, Pixels, Point
from renderer.io.image import read_environment, write_exr, write_png
from renderer.io.mesh import read_mesh

VERSION = "3.0.0"  # of the scene format
TAGS = {bool: "boolean", int: "integer", float: "float", str: "string"}
INDENT = "    "


def _numbers(values):
    """Return numbers as text that reads back to the same."""
    return " ".join(repr(float(v)) for v in values)


def _in_space(transform):
    """Return a transform of the plane as one of space: the parser loses the offset of 3 x 3 matrices."""
    if transform.shape == (4, 4):
        return transform
    result = np.eye(4)
    result[:2, :2], result[:2, 3] = transform[:2, :2], transform[:2, 2]
    return result


def ply(mesh, normals=None):
    """Return a mesh as the bytes of a binary PLY file with texture coordinates u, v, if it has some, and normals."""
    columns = [(("x", "y", "z"), mesh.vertices), (("nx", "ny", "nz"), normals), (("u", "v"), mesh.uv)]
    columns = [(names, rows) for names, rows in columns if rows is not None]
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(mesh.vertices)}\n"
              + "".join(f"property float {name}\n" for names, _ in columns for name in names)
              + f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    corners = np.column_stack([rows for _, rows in columns]).astype("<f4")
    faces = np.empty(len(mesh.faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    return header.encode("ascii") + corners.tobytes() + faces.tobytes()


def mesh_copy(file):
    """Return the suffix and the bytes of a mesh file for Mitsuba: its own, unless Mitsuba must see other normals."""
    if not (file.drops_normals or file.negates_normals):
        return file.path.suffix.lower(), file.path.read_bytes()
    data = read_mesh(str(file.path))
    return ".ply", ply(data, -data.normals if file.negates_normals else None)


class _Writer:
    """Collects the lines of the XML and the files that belong beside it."""

    def __init__(self, folder):
        self.folder, self.lines, self.assets = folder, [], {}

    def line(self, depth, text):
        """Add a line of XML."""
        self.lines.append(INDENT * depth + text)

    def _asset(self, name, content):
        """Return the name under which equal content is stored once; different content gets a number."""
        stem, suffix = os.path.splitext(name)
        number = 0
        while self.assets.setdefault(name, content) != content:
            number += 1
            name = f"{stem}_{number}{suffix}"
        return f"{self.folder}/{name}"

    def node(self, depth, name, node):
        """Add the element of a node, which is called `name`, with all that is in it."""
        kind, values, named = node.type, node.values, ""
        if "mesh" in values:
            kind, values = "ply", {**values, "face_normals": True}
        elif "file" in values:
            kind, values = self._with_copy(values)
        if depth == 1 and node.family in ("shape", "emitter"):
            named = f" id={quoteattr(name)}"
        elif node.family in ("bsdf", "texture"):
            named = f" name={quoteattr(name)}"
        self.line(depth, f'<{node.family} type="{kind}"{named}>')
        for key, value in values.items():
            self._value(depth + 1, key, value, name)
        self.line(depth, f"</{node.family}>")

    def _with_copy(self, values):
        """Return the plugin and the values of a mesh file of which a copy lies beside the XML."""
        file = values["file"]
        suffix, content = mesh_copy(file)
        children = {name: value for name, value in values.items() if name != "file"}
        return suffix[1:], {"filename": self._asset(file.path.stem + suffix, content), **file.settings, **children}

    def _value(self, depth, key, value, owner):
        """Add the element of one of a node's values; `owner` is the node's name, after which files are called."""
        if isinstance(value, Node):
            self.node(depth, key, value)
        elif isinstance(value, Mesh):
            file = self._asset(f"{owner}.ply", ply(value))
            self.line(depth, f'<string name="filename" value={quoteattr(file)}/>')
        elif isinstance(value, Pixels):
            file = self._asset(f"{value.name}.png", value)
            self.line(depth, f'<string name="filename" value={quoteattr(file)}/>')
        elif isinstance(value, Environment):
            file = self._asset("environment.exr", value)
            self.line(depth, f'<string name="filename" value={quoteattr(file)}/>')
        elif isinstance(value, Colour):
            self.line(depth, f'<rgb name="{key}" value="{_numbers(value)}"/>')
        elif isinstance(value, Point):
            self.line(depth, f'<point name="{key}" value="{_numbers(value)}"/>')
        elif isinstance(value, np.ndarray):
            numbers = _numbers(_in_space(value).ravel())
            self.line(depth, f'<transform name="{key}"><matrix value="{numbers}"/></transform>')
        else:
            text = str(value).lower() if isinstance(value, bool) else str(value)
            self.line(depth, f'<{TAGS[type(value)]} name="{key}" value={quoteattr(text)}/>')


def xml(plan, folder):
    """Return the XML text and the files it names, {name: bytes, Pixels or Environment}, to be put in `folder`."""
    writer = _Writer(folder)
    writer.line(0, f'<scene version="{VERSION}">')
    for name, node in plan.children.items():
        writer.node(1, name, node)
    writer.line(0, "</scene>")
    return "\n".join(writer.lines) + "\n", writer.assets


def write(plan, path):
    """Write the XML to `path` and its files to the folder `<stem>_files` beside it; nothing is half-written.

    Every file is written under a temporary name first and renamed when all are complete, the XML last.
    Raises OSError where something cannot be written.
    """
    path = Path(path)
    if path.is_dir():  # else the files would be in place before the XML fails
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    folder = path.with_name(path.stem + "_files")
    text, assets = xml(plan, folder.name)
    made_folder = bool(assets) and not folder.exists()
    if assets:
        folder.mkdir(exist_ok=True)
    staged = []
    try:
        for name, content in assets.items():
            _stage(staged, folder / name, content)
        _stage(staged, path, text.encode("utf-8"))
        for temporary, target in staged:
            os.replace(temporary, target)
    except BaseException:
        for temporary, _ in staged:
            temporary.unlink(missing_ok=True)
        if made_folder and not any(folder.iterdir()):
            folder.rmdir()
        raise


def _stage(staged, target, content):
    """Write the content beside its target under a temporary name, and remember the pair."""
    temporary = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    staged.append((temporary, target))
    if isinstance(content, Pixels):
        write_png(temporary, content.rgb, content.width, content.height)
    elif isinstance(content, Environment):  # mirrored, as our pictures are against Mitsuba's
        pixels = read_environment(content.path)[:, ::-1] * np.asarray(content.factor, np.float32)
        write_exr(temporary, {name: np.ascontiguousarray(pixels[..., k]) for k, name in enumerate("RGB")}, {})
    else:
        temporary.write_bytes(content)
