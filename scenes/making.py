"""What the scripts of our scenes share: meshes of rows and columns of points, binary PLY files, and scene files."""

import json

import numpy as np

from renderer.io import mesh_ply

PLACES = 5  # decimals of what is written, so that it is the same everywhere


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


def ply(vertices, triangles, normals=None, uv=None):
    """Return a mesh as the bytes of a PLY file, numbers rounded to PLACES."""
    vertices, normals, uv = (numbers if numbers is None else np.round(numbers, PLACES) + 0.0  # no negative zero
                             for numbers in (vertices, normals, uv))
    return mesh_ply.encoded(vertices, triangles, normals, uv)


def text(document):
    """Return a document as a scene file, a line for each light and shape."""
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in document.items() if key != "scene"]
    inner = []
    for key, value in document["scene"].items():
        if key in ("lightsources", "shapes"):
            items = ",\n".join(f"      {json.dumps(item)}" for item in value)
            inner.append(f'    "{key}": [\n{items}\n    ]')
        else:
            inner.append(f'    "{key}": {json.dumps(value)}')
    lines.append('  "scene": {\n' + ",\n".join(inner) + "\n  }")
    return "{\n" + ",\n".join(lines) + "\n}\n"
