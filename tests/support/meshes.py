"""Small meshes as files, and as documents of scenes: written here byte by byte, and read by whoever is tested."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.mesh_scenes import bumpy

ENCODINGS = {"ascii": "ascii", "little": "binary_little_endian", "big": "binary_big_endian"}
ORDER = {"little": "<", "big": ">"}


@dataclass(frozen=True)
class Model:
    """A mesh: (V, 3) positions, (F, 3) corners, and (V, 3) normals and (V, 2) texture coordinates or None."""

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None = None
    uv: np.ndarray | None = None

    def but(self, **values):
        """Return the model with other arrays."""
        return replace(self, **values)

    @property
    def inside_out(self):
        """The model with all windings reversed."""
        return self.but(faces=self.faces[:, ::-1])

    @property
    def unshared(self):
        """The model with three vertices for each triangle."""
        rows = self.faces.ravel()
        normals, uv = (None if values is None else values[rows] for values in (self.normals, self.uv))
        return Model(self.vertices[rows], np.arange(len(rows)).reshape(-1, 3), normals, uv)


def lump(count=200):
    """Return a closed bumpy ball of radius 1, wound outwards, about `count` triangles.

    Its normals are those of an ellipsoid, and of different lengths: neither its triangles' nor what is computed from
    them. u and v are oblique, without a seam, and leave [0, 1].
    """
    vertices, faces = bumpy(count)
    normals = vertices * [1.0, 0.7, 1.2] * np.linspace(0.5, 2.0, len(vertices))[:, None]
    uv = vertices @ np.array([[0.5, 0.1], [0.15, -0.6], [0.2, 0.25]]) + [0.4, 0.55]
    return Model(vertices, faces, normals.astype(np.float32), uv.astype(np.float32))


def write_ply(path, model, encoding="ascii"):
    """Write a PLY file and return its path."""
    groups = [(("x", "y", "z"), model.vertices), (("nx", "ny", "nz"), model.normals), (("u", "v"), model.uv)]
    groups = [(names, rows) for names, rows in groups if rows is not None]
    header = ["ply", f"format {ENCODINGS[encoding]} 1.0", f"element vertex {len(model.vertices)}",
              *(f"property float {name}" for names, _ in groups for name in names),
              f"element face {len(model.faces)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = np.concatenate([rows for _, rows in groups], axis=1)
    if encoding == "ascii":
        lines = [_line(row) for row in rows] + [f"3 {a} {b} {c}" for a, b, c in model.faces]
        body = ("\n".join(lines) + "\n").encode()
    else:
        order = ORDER[encoding]
        faces = np.empty(len(model.faces), [("count", "u1"), ("corners", f"{order}i4", 3)])
        faces["count"], faces["corners"] = 3, model.faces
        body = rows.astype(f"{order}f4").tobytes() + faces.tobytes()
    path.write_bytes("\n".join(header).encode() + body)
    return path


def write_obj(path, model):
    """Write an OBJ file and return its path: normals and texture coordinates in reverse, so that indices differ.

    v is turned round, because it runs upwards there.
    """
    lines = ["v " + _line(row) for row in model.vertices]
    lines += ["vt " + _line((u, 1 - v)) for u, v in (() if model.uv is None else model.uv[::-1])]
    lines += ["vn " + _line(row) for row in (() if model.normals is None else model.normals[::-1])]
    count = len(model.vertices)
    for face in model.faces:
        uv, normal = ("" if values is None else count for values in (model.uv, model.normals))
        slots = ([str(v + 1), str(uv and uv - v), str(normal and normal - v)] for v in face.tolist())
        lines.append("f " + " ".join("/".join(slot).rstrip("/") for slot in slots))
    path.write_text("\n".join(lines) + "\n")
    return path


def write(path, model, **options):
    """Write the model as its file name says, and return the path."""
    return {".ply": write_ply, ".obj": write_obj}[path.suffix](path, model, **options)


def _line(row):
    """Return numbers as text, with the digits that float32 has."""
    return " ".join(f"{float(value):.9g}" for value in row)


def mesh(filename, material, *steps, **keys):
    """Return a mesh's document; `steps` are those of its transformation."""
    return {"type": "mesh", "filename": filename, "transform": list(steps), "material": dict(material), **keys}
