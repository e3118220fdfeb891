"""Makes the scene of a shell of copper rings: nautilus.json and its meshes.

Run `python -m scenes.make_nautilus`; the result is the same each time. It needs numpy. x is to the right, y up, and the
camera looks along +z.
"""

import math
from pathlib import Path

import numpy as np

from scenes.making import grid, joined, ply, text

FOLDER = Path(__file__).parent
RINGS, STEP = 150, 7.2  # rings, and degrees from one to the next
TURN = 3.0  # factor by which the shell grows in a turn
WIDE = 0.47  # radius of a ring over its distance from the pole; whorls would touch at (TURN - 1) / (TURN + 1)
START = -112.0  # degrees: where the mouth is
OUTER = 2.0  # distance of the mouth's middle from the pole
YAW = -24.0  # degrees by which the shell is turned
PLACE = 0.2, 0.3, -1.0  # of the pole
WALL = 0.75
BLADE = 0.075, 0.010  # half of the width and of the thickness of a ring of radius 1
CHROME = {"eta": [3.1, 3.2, 2.2], "k": [3.3, 3.3, 3.1]}


def distance(degrees):
    """Return the distance from the pole after an angle along the spiral from the mouth."""
    return OUTER * TURN ** (-degrees / 360)


def tube(points, normals, radius, around=10):
    """Return a tube along (N, 3) points; `normals` are across it, `radius` (N,) its radii."""
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = normals - (normals * along).sum(1, keepdims=True) * along
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    third = np.cross(along, across)
    angle = np.linspace(0, 2 * np.pi, around + 1)[None, :, None]
    circle = np.cos(angle) * across[:, None] + np.sin(angle) * third[:, None]
    u, v = np.meshgrid(np.linspace(0, 1, around + 1), np.linspace(0, 1, len(points)))
    return grid(points[:, None] + radius[:, None, None] * circle, np.stack([v, u], -1))


def ring():
    """Return a flat ring of radius 1 around +y, its section an ellipse."""
    angle, around = np.linspace(0, 2 * np.pi, 81)[:, None], np.linspace(0, 2 * np.pi, 13)
    r, y = 1 - BLADE[0] + BLADE[0] * np.cos(around), BLADE[1] * np.sin(around)
    points = np.stack([r * np.cos(angle), y + 0 * angle, -r * np.sin(angle)], -1)
    points[-1], points[:, -1] = points[0], points[:, 0]
    return grid(points, np.stack(np.broadcast_arrays(angle / (2 * np.pi), around / (2 * np.pi)), -1))


def ribs():
    """Return the wires that run along the shell and hold its rings, as one mesh in the shell's own place."""
    degrees = np.linspace(0, (RINGS - 1) * STEP, 400)
    theta, r = np.radians(START + degrees), distance(degrees)
    out = np.stack([np.cos(theta), np.sin(theta), 0 * theta], -1)
    parts = []
    for around in (0, 65, -65, 130, -130):
        c, s = math.cos(math.radians(around)), math.sin(math.radians(around))
        side = c * out + s * np.array([0, 0, 1.0])
        parts.append(tube(r[:, None] * (out + WIDE * side), side, 0.013 * r * WIDE + 0.001, 6))
    return joined(parts)


def shell():
    """Return the shapes of the shell."""
    shapes = []
    for k in range(RINGS):
        degrees = k * STEP
        r, theta = distance(degrees), START + degrees
        steps = [{"scale": round(WIDE * r, 5)}, {"rotate": {"axis": [0, 0, 1], "angle": theta}},
                 {"translate": [*(round(r * f(math.radians(theta)), 5) for f in (math.cos, math.sin)), 0]}]
        shapes.append(mesh("ring", {"type": "roughconductor", **CHROME, "alpha": 0.2}, *steps, *placed()))
    return [*shapes, mesh("ribs", {"type": "roughconductor", **CHROME, "alpha": 0.22}, *placed())]


def placed():
    """Return the steps that bring the shell from its pole at the origin to its place."""
    return [{"rotate": {"axis": [0, 1, 0], "angle": YAW}}, {"translate": list(PLACE)}]


def mesh(name, bsdf, *steps):
    """Return a mesh of this scene."""
    return {"type": "mesh", "filename": f"meshes/nautilus/{name}.ply", "normals": "smooth", "transform": list(steps),
            "material": {"bsdf": bsdf}}


def at(degrees, around=(0.0, 0.0)):
    """Return where a point of the shell lies: at an angle along it, and aside (outwards, along z) in radii there."""
    r, theta, yaw = distance(degrees), math.radians(START + degrees), math.radians(YAW)
    x, y, z = (r * (1 + WIDE * around[0]) * c for c in (math.cos(theta), math.sin(theta), 0))
    z += r * WIDE * around[1]
    x, z = math.cos(yaw) * x + math.sin(yaw) * z, math.cos(yaw) * z - math.sin(yaw) * x
    return [round(c + p, 5) for c, p in zip((x, y, z), PLACE)]


def scene():
    """Return the scene as a document."""
    wall = {"bsdf": {"type": "diffuse", "reflectance": [0.80, 0.79, 0.77]}}
    shapes = [
        {"type": "plane", "point": [0, 0, WALL], "normal": [0, 0, -1], "material": wall}, *shell(),
        {"type": "sphere", "center": at(-4), "radius": 0.60,
         "material": {"bsdf": {"type": "principled", "basecolor": [0.86, 0.80, 0.70], "roughness": 0.3,
                               "clearcoat": 0.5, "clearcoatgloss": 0.85}}},
    ]
    lights = [
        {"type": "disklight", "position": [-7.5, 4.6, -7.5], "normal": [0.75, -0.45, 0.75], "radius": 0.26,
         "intensity": [1120, 400, 225], "twosided": False},
        {"type": "disklight", "position": [7.5, 6.0, -7.0], "normal": [-0.75, -0.6, 0.7], "radius": 0.26,
         "intensity": [150, 750, 890], "twosided": False},
        {"type": "arealight", "position": [0, 9, -5], "u": [8, 0, 0], "v": [0, -2, 4], "intensity": [0.6, 0.6, 0.62]},
    ]
    return {"camera": {"type": "thinlens", "width": 840, "height": 700, "fov": 23, "position": [-0.9, 0.4, -15.0],
                       "lookAt": [-0.2, -0.25, 0], "apertureRadius": 0.08, "focusDistance": 14.2, "exposure": 0.1},
            "scene": {"backgroundcolor": [0.03, 0.03, 0.035], "lightsources": lights, "shapes": shapes},
            "rendermode": "pathtracer", "samples": 256, "nbounces": 6, "filter": "tent", "tonemap": "filmic"}


def meshes():
    """Return {name: mesh} of all meshes of the scene."""
    return {"ring": ring(), "ribs": ribs()}


if __name__ == "__main__":
    (FOLDER / "meshes" / "nautilus").mkdir(exist_ok=True)
    for name, (vertices, uv, triangles) in meshes().items():
        (FOLDER / "meshes" / "nautilus" / f"{name}.ply").write_bytes(ply(vertices, triangles, uv=uv))
    (FOLDER / "nautilus.json").write_text(text(scene()))
