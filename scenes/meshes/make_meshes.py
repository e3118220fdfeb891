"""Makes the small meshes of the feature scenes, and the scene of loose triangles.

Run `python scenes/meshes/make_meshes.py`; the result is the same each time.
"""

import colorsys
import json
import math
import random
from pathlib import Path

FOLDER = Path(__file__).parent
AROUND, ALONG = 20, 36  # quads of the torus around its tube and along it
MINOR = 0.38  # radius of the tube; the torus's own is 1
LEVELS = 8  # pieces of an octahedron's edge
TRIANGLES = 1500


def torus():
    """Return a torus around +y as an OBJ file: quads whose positions, texture coordinates and normals count separately.

    u runs along the torus, v around the tube; both have a seam, where the positions are shared and the uv are not.
    """
    lines = ["# a torus around +y: quads, with texture coordinates and normals"]
    points = [(2 * math.pi * i / ALONG, 2 * math.pi * j / AROUND) for i in range(ALONG) for j in range(AROUND)]
    for a, b in points:
        r = 1 + MINOR * math.cos(b)
        lines.append(f"v {r * math.cos(a):.6f} {MINOR * math.sin(b):.6f} {r * math.sin(a):.6f}")
    lines += [f"vt {i / ALONG:.6f} {j / AROUND:.6f}" for i in range(ALONG + 1) for j in range(AROUND + 1)]
    for a, b in points:
        lines.append(f"vn {math.cos(b) * math.cos(a):.6f} {math.sin(b):.6f} {math.cos(b) * math.sin(a):.6f}")
    for i in range(ALONG):
        for j in range(AROUND):
            corners = []
            for di, dj in ((0, 0), (0, 1), (1, 1), (1, 0)):
                vertex = (i + di) % ALONG * AROUND + (j + dj) % AROUND + 1
                corners.append(f"{vertex}/{(i + di) * (AROUND + 1) + j + dj + 1}/{vertex}")
            lines.append("f " + " ".join(corners))
    return "\n".join(lines) + "\n"


def rock():
    """Return a lumpy ball as an ASCII PLY file without normals: an octahedron's faces cut up, and bumps."""
    vertices, faces = {}, []

    def vertex(point):
        """Return the number of a point of the octahedron |x| + |y| + |z| = LEVELS."""
        return vertices.setdefault(point, len(vertices))

    for sx, sy, sz in ((x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)):
        for i in range(LEVELS):
            for j in range(LEVELS - i):
                cells = [((i, j), (i + 1, j), (i, j + 1))]
                cells += [((i + 1, j), (i + 1, j + 1), (i, j + 1))] if i + j < LEVELS - 1 else []
                for cell in cells:
                    face = [vertex((sx * x, sy * y, sz * (LEVELS - x - y))) for x, y in cell]
                    faces.append(face if sx * sy * sz > 0 else face[::-1])
    header = ["ply", "format ascii 1.0", "comment a closed lumpy ball", f"element vertex {len(vertices)}",
              *(f"property float {axis}" for axis in "xyz"), f"element face {len(faces)}",
              "property list uchar int vertex_indices", "end_header"]
    rows = [" ".join(f"{c:.6f}" for c in lumpy(point)) for point in vertices]
    return "\n".join([*header, *rows, *(f"3 {a} {b} {c}" for a, b, c in faces)]) + "\n"


def lumpy(point):
    """Return where a point of the octahedron comes to lie."""
    length = math.hypot(*point)
    x, y, z = (c / length for c in point)
    r = 1 + 0.13 * math.sin(5 * x + 1) * math.sin(4 * y) + 0.1 * math.cos(6 * z + 2 * x)
    return r * x, 0.85 * r * y, r * z


def soup():
    """Return a scene of loose triangles, none of which shares a corner: a ring of leaves, one a line of the file."""
    numbers = random.Random(4)
    shapes = []
    for _ in range(TRIANGLES):
        angle, height, radius = numbers.uniform(0, 2 * math.pi), numbers.gauss(0, 0.28), numbers.gauss(1.5, 0.22)
        middle = radius * math.cos(angle), height + 0.25 * math.sin(3 * angle), radius * math.sin(angle)
        corners = [[round(c + numbers.gauss(0, 0.09), 3) for c in middle] for _ in range(3)]
        hue = (angle / (2 * math.pi) + numbers.uniform(-0.05, 0.05)) % 1
        colour = [round(c, 2) for c in colorsys.hsv_to_rgb(hue, 0.6, 0.9)]
        keys = dict(zip(("v0", "v1", "v2"), corners), material={"diffusecolor": colour})
        shapes.append(json.dumps({"type": "triangle", **keys}))
    grey = {"diffusecolor": [0.7] * 3, "ks": 0}
    floor = {"type": "plane", "point": [0, -1.1, 0], "normal": [0, 1, 0], "material": grey}
    camera = {"width": 300, "height": 200, "fov": 38, "position": [0.6, 2.6, -5], "lookAt": [0, -0.1, 0]}
    light = {"type": "pointlight", "position": [-3, 5, -2], "intensity": [0.75, 0.75, 0.7]}
    head = json.dumps({"backgroundcolor": [0.3, 0.36, 0.44], "lightsources": [light]})[:-1]
    body = ",\n    ".join([json.dumps(floor), *shapes])
    return f'{{\n  "camera": {json.dumps(camera)},\n  "scene": {head}, "shapes": [\n    {body}\n  ]}}\n}}\n'


if __name__ == "__main__":
    (FOLDER / "torus.obj").write_text(torus())
    (FOLDER / "rock.ply").write_text(rock())
    (FOLDER.parent / "features" / "shape_triangle_soup.json").write_text(soup())
