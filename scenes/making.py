"""What the scripts of our scenes share: meshes of rows and columns of points, binary PLY files, and scene files."""

import json

import numpy as np


def grid(points, uv=None):
    """Return (vertices, uv, triangles) of points in rows and columns, (rows, columns, 3) and (rows, columns, 2)."""
    rows, columns = points.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    uv = np.zeros((rows * columns, 2)) if uv is None else uv.reshape(-1, 2)
    return points.reshape(-1, 3), uv, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def joined(parts):
    """Return one mesh of several."""
    starts = np.cumsum([0, *(len(part[0]) for part in parts[:-1])])
    return (np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts]),
            np.concatenate([part[2] + start for part, start in zip(parts, starts)]))


def ply(mesh):
    """Return a mesh as the bytes of a binary PLY file, numbers rounded to 10^-5, to be the same everywhere."""
    vertices, uv, triangles = mesh
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}",
              *(f"property float {name}" for name in "xyzuv"), f"element face {len(triangles)}",
              "property list uchar int vertex_indices", "end_header", ""]
    faces = np.zeros(len(triangles), [("count", "u1"), ("corner", "<i4", 3)])
    faces["count"], faces["corner"] = 3, triangles
    numbers = np.round(np.hstack([vertices, uv]), 5) + 0.0  # no negative zero
    return "\n".join(header).encode() + numbers.astype("<f4").tobytes() + faces.tobytes()


def text(document):
    """Return a scene file, a shape a line."""
    document = {**document, "scene": dict(document["scene"])}
    shapes = document["scene"].pop("shapes")
    lines = ",\n    ".join(json.dumps(shape) for shape in shapes)
    rest = {key: value for key, value in document.items() if key not in ("camera", "scene")}
    return (f'{{\n  {json.dumps(rest)[1:-1]},\n  "camera": {json.dumps(document["camera"])},\n'
            f'  "scene": {json.dumps(document["scene"])[:-1]}, "shapes": [\n    {lines}\n  ]}}\n}}\n')
