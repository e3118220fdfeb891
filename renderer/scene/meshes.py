"""The triangles of a scene as arrays: those of its mesh files in the world's coordinates, and its triangle shapes."""

import numpy as np

from renderer.core.backend import Float, UInt32, from_host
from renderer.core.errors import SceneError
from renderer.io.mesh import read_mesh
from renderer.io.mesh_normals import smooth_normals
from renderer.scene.materials import uses_uv
from renderer.scene.transform import determinant, matrix
from renderer.scene.triangles import CORNER_WORDS, FULL, PLAIN, Triangles

UV = (0.0, 0.0), (1.0, 0.0), (0.0, 1.0)  # of a triangle's corners, where a file gives none


def read_meshes(loaded, meshes):
    """Return {file name: MeshData} of mesh shapes [(index in the file, shape)]; raises SceneError with their place."""
    found = {}
    for index, shape in meshes:
        if shape.filename not in found:
            try:
                found[shape.filename] = read_mesh(str(loaded.resolve(shape.filename)))
            except SceneError as error:
                raise loaded.refused(error, "scene", "shapes", index, "filename") from error
    return found


def triangles(shapes, files, first, uv_shown, paths=False):
    """Return the Triangles of `triangle` and `mesh` shapes, numbered from `first` on; meshes come last.

    `files` is what `read_meshes` returned. Shapes are numbered likewise, so that a `triangle` shape is its triangle.
    `uv_shown` tells whether texture coordinates count, though there are no textures; `paths`: the mode is pathtracer.
    """
    sheets = [shape for shape in shapes if shape.type == "triangle"]
    meshes = [shape for shape in shapes if shape.type == "mesh"]
    materials = {id(shape.material): shape.material for shape in sheets}.values()  # many shapes share one
    shown = uv_shown or any(uses_uv(material, paths) for material in materials)
    parts = [_of_sheets(sheets, first, shown)] if sheets else []
    for number, mesh in enumerate(meshes, first + len(sheets)):
        part = _of_mesh(mesh, files[mesh.filename], number)
        without_uv = part[-1] is None and (uv_shown or uses_uv(mesh.material, paths))
        parts.append(_with_default_uv(*part[:-1], determinant(matrix(mesh.transform)) < 0) if without_uv else part)
    words = FULL if any(normals is not None or uv is not None for _, _, normals, uv in parts) else PLAIN
    vertices = np.zeros((sum(len(part[0]) for part in parts), words), np.float32)
    corners = np.empty((sum(len(part[1]) for part in parts), CORNER_WORDS), np.uint32)
    vertex = corner = 0
    for positions, faces, normals, uv in parts:
        own = vertices[vertex : vertex + len(positions)]
        own[:, :3] = positions
        if normals is not None:
            own[:, 4:7] = normals
        if uv is not None:
            own[:, 3], own[:, 7] = uv[:, 0], uv[:, 1]
        corners[corner : corner + len(faces)] = faces
        corners[corner : corner + len(faces), :3] += np.uint32(vertex)
        vertex, corner = vertex + len(positions), corner + len(faces)
    return _triangles(vertices, corners, first, bool(meshes), len(shapes) == 1)


def plain_triangles(vertices, faces):
    """Return the Triangles of one mesh, (V, 3) and (F, 3) on the host, without normals and texture coordinates."""
    padded, corners = np.zeros((len(vertices), PLAIN), np.float32), np.zeros((len(faces), CORNER_WORDS), np.uint32)
    padded[:, :3], corners[:, :3] = vertices, faces
    return _triangles(padded, corners, 0, of_meshes=True)


def _triangles(vertices, corners, first, of_meshes, one_shape=False):
    """Return Triangles of (V, 4 or 8) float32 and (F, 4) uint32."""
    arrays = from_host(Float, vertices.ravel()), from_host(UInt32, corners.ravel())
    return Triangles(*arrays, vertices.shape[1], first, of_meshes, one_shape)


def _of_sheets(shapes, first, with_uv):
    """Return positions, corners with their shape, no normals, and texture coordinates of `triangle` shapes."""
    count = len(shapes)
    positions = np.array([(shape.v0, shape.v1, shape.v2) for shape in shapes]).reshape(-1, 3)
    faces = np.empty((count, CORNER_WORDS), np.uint32)
    faces[:, :3] = np.arange(3 * count).reshape(-1, 3)
    faces[:, 3] = first + np.arange(count)
    uv = np.array([(shape.uv0, shape.uv1, shape.uv2) for shape in shapes]).reshape(-1, 2) if with_uv else None
    return positions, faces, None, uv


def _of_mesh(shape, data, number):
    """Return positions, corners with their shape, unit normals or None, and texture coordinates of one mesh."""
    transform = matrix(shape.transform)
    linear, offset = np.array(transform)[:3, :3], np.array(transform)[:3, 3]
    mirrored = determinant(transform) < 0
    positions = data.vertices.astype(np.float64) @ linear.T + offset
    faces = np.empty((len(data.faces), CORNER_WORDS), np.uint32)
    faces[:, :3] = data.faces[:, ::-1] if mirrored else data.faces  # so that normals still point outwards
    faces[:, 3] = number
    normals = None
    if shape.normals == "smooth":
        normals = smooth_normals(positions, faces[:, :3])
    elif shape.normals == "file" and data.normals is not None:
        # the inverse transpose but for its length, which does not count
        normals = data.normals.astype(np.float64) @ np.linalg.inv(linear)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals /= np.where(length > 0, length, 1)
    return positions, faces, normals, data.uv


def _with_default_uv(positions, faces, normals, mirrored):
    """Return a mesh without texture coordinates with those of `triangle` shapes, a vertex for each corner."""
    corners = faces[:, :3].ravel()
    own = np.empty_like(faces)
    own[:, :3], own[:, 3] = np.arange(len(corners)).reshape(-1, 3), faces[:, 3]
    uv = np.array(UV[::-1] if mirrored else UV)  # in the file's order of corners, which a mirror has reversed
    return positions[corners], own, None if normals is None else normals[corners], np.tile(uv, (len(faces), 1))
