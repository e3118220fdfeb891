"""Triangle meshes from OBJ and PLY files, checked so far that whoever uses one need not check again.

numpy does the parsing (docs/meshes.md has what the mesh libraries did with the same files). No count in a file is
believed before it was held against the size of the file, so that what is allocated is a small multiple of that size.

Texture coordinates are ours: v = 0 is the top row of the image. PLY files are taken as they are, OBJ files, whose v
runs upwards, get 1 - v; Mitsuba's loaders do the same.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from renderer.core.errors import Problem, SceneError
from renderer.io import mesh_obj, mesh_ply
from renderer.io.files import reason
from renderer.io.mesh_parts import LARGEST, Malformed

READERS = {".obj": mesh_obj.read, ".ply": mesh_ply.read}
MAX_FILE = 2**32  # bytes; a binary PLY of 150 million triangles


@dataclass(frozen=True)
class MeshData:
    """Triangles over shared vertices; normals are as in the file, of any length, and zero where it gives none."""

    vertices: np.ndarray  # (V, 3) float32 or float64, finite, V > 0
    faces: np.ndarray  # (F, 3) uint32, each less than V, F > 0; a face may repeat a vertex
    normals: np.ndarray | None = None  # (V, 3) float32, finite
    uv: np.ndarray | None = None  # (V, 2) float32, finite; v = 0 is the top row of an image


def read_mesh(path):
    """Return the MeshData of an OBJ or PLY file (ASCII or binary, either byte order), by its extension.

    Polygons become fans around their first corner. All groups and objects of an OBJ file become one mesh, its
    materials are not read, and corners with different v/vt/vn become different vertices. Triangles without area stay.

    Raises: SceneError naming the file, the line in a text file, what was found and what is allowed.
    """
    extension = os.path.splitext(path)[1].lower()
    if extension not in READERS:
        _refuse(path, f"not a mesh file: its name must end in {' or '.join(READERS)}")
    data = _contents(path)
    try:
        with np.errstate(over="ignore"):  # what does not fit into float32 is found below, as infinity
            vertices, faces, normals, uv = READERS[extension](data)
            _check(vertices, faces, normals, uv)
    except Malformed as error:
        _refuse(path, str(error), error.line, error.column)
    except MemoryError:
        _refuse(path, f"not enough memory for this mesh ({len(data) >> 20} MiB)")
    return MeshData(vertices, faces.astype(np.uint32), normals, uv)


def _contents(path):
    """Return the bytes of a file of acceptable size."""
    if not os.path.exists(path):
        _refuse(path, "there is no such file")
    if not os.path.isfile(path):
        _refuse(path, "this is not a file")
    try:
        with open(path, "rb") as file:
            size = os.fstat(file.fileno()).st_size
            if size > MAX_FILE:
                _refuse(path, f"larger than {MAX_FILE >> 20} MiB; that is no mesh file")
            data = file.read(size)
    except OSError as error:
        _refuse(path, f"cannot be read: {reason(error)}")
    if not data.strip(b" \t\r\n\0"):
        _refuse(path, "the file is empty")
    return data


def _check(vertices, faces, normals, uv):
    """Raise Malformed for what no mesh may have, whatever its format."""
    for rows, what in ((vertices, "vertices"), (faces, "faces")):
        if not len(rows):
            raise Malformed(f"the file has no {what}")
    for rows, what in ((vertices, "position"), (normals, "normal"), (uv, "uv")):
        if rows is not None:
            _check_numbers(rows, what)
    # Compared as wide integers: a negative index must not wrap around into a good one.
    outside = (faces < 0) | (faces >= len(vertices))
    if outside.any():
        row, corner = np.argwhere(outside)[0]
        raise Malformed(f"triangle {row} names vertex {faces[row, corner]}; the file has {len(vertices)} vertices, "
                        f"so it must be between 0 and {len(vertices) - 1}")


def _check_numbers(rows, what):
    """Raise Malformed for numbers that are not finite or too large."""
    good = np.abs(rows) <= LARGEST  # NaN compares false
    if not good.all():
        row = int(np.argwhere(~good)[0][0])
        told = ", ".join(f"{float(number):g}" for number in rows[row])
        raise Malformed(f"the {what} of vertex {row} is ({told}); its numbers must be finite, and at most {LARGEST:g} "
                        "in size, because their squares must fit a 32-bit float")


def _refuse(path, message, line=0, column=0):
    raise SceneError(Problem(os.fspath(path), message, "", line, column)) from None
