"""Small scenes made in code, for tests that need one shape or one pixel rather than a picture."""

import copy
import json

from renderer.scene.loader import load

MATT = {"kd": 0.9, "ks": 0.0, "diffusecolor": [0.8, 0.5, 0.25], "specularexponent": 20}
CAMERA = {
    "type": "pinhole", "width": 16, "height": 12, "position": [0, 0, -4], "lookAt": [0, 0, 0],
    "upVector": [0, 1, 0], "fov": 40, "exposure": 0.1,
}  # fmt: skip


def document(shapes=(), lights=(), camera=None, **keys):
    """Return a scene file's content: `keys` named like World's go there, others to the top level."""
    top, world = {"rendermode": "phong"}, {"backgroundcolor": [0.25, 0.25, 0.25]}
    for name, value in keys.items():
        (world if name in ("backgroundcolor", "ambientlight") else top)[name] = value
    world |= {"lightsources": list(lights), "shapes": copy.deepcopy(list(shapes))}
    return top | {"camera": CAMERA | (camera or {}), "scene": world}


def write(folder, content, name="scene.json"):
    """Return the path of a scene file with the given content."""
    path = folder / name
    path.write_text(json.dumps(content))
    return path


def loaded(folder, *args, **keys):
    """Return the LoadedScene of `document` with the same arguments."""
    return load(str(write(folder, document(*args, **keys))))


def point_light(position, intensity=(1.0, 1.0, 1.0)):
    """Return a point light."""
    return {"type": "pointlight", "position": list(position), "intensity": list(intensity)}


# Settings of every kind of shape that lanes know, one of them extreme. A mesh is none of these kinds: what lanes meet
# are its triangles, on their way through a structure. tests/engine/test_mesh_scenes.py and tests/oracle/test_meshes.py
# hold it to the same contract.
SHAPES = {
    "sphere": [
        {"type": "sphere", "center": [0.3, -0.2, 0.1], "radius": 0.7},
        {"type": "sphere", "center": [0, -25, 0], "radius": 25.1},
    ],
    "cylinder": [
        {"type": "cylinder", "center": [0.1, 0.2, -0.1], "axis": [1, 2, -1], "radius": 0.4, "height": 0.6},
        {"type": "cylinder", "center": [0, 0, 0], "axis": [0, 1, 0], "radius": 1.0, "height": 0.001},
    ],
    "box": [
        {"type": "box", "min": [-0.5, -0.4, -0.3], "max": [0.6, 0.7, 0.2]},
        {"type": "box", "min": [-1, -0.001, -1], "max": [1, 0.001, 1]},
    ],
    "convex": [
        {"type": "convex", "vertices": [[0, 0.8, 0], [0.7, -0.4, 0.4], [-0.7, -0.4, 0.4], [0, -0.4, -0.8]]},
        {"type": "convex", "halfspaces": [[1, 0, 0, 0.5], [-2, 0, 0, 1.0], [0, 1, 0.5, 0.6], [0, -1, 0, 0.4],
                                          [0, 0, 1, 0.7], [0, 0.2, -1, 0.6]]},
    ],
    "triangle": [
        {"type": "triangle", "v0": [-0.8, -0.5, 0.2], "v1": [0.9, -0.4, -0.3], "v2": [0.1, 0.8, 0.5]},
        {"type": "triangle", "v0": [-1, 0, 0], "v1": [1, 0, 0], "v2": [0, 0.01, 0]},
    ],
    "rectangle": [
        {"type": "rectangle", "center": [0.1, -0.1, 0.2], "u": [1.2, 0.3, -0.4], "v": [0.5, 0.9, 0.6]},
        {"type": "rectangle", "center": [0, 0, 0], "u": [2, 0, 0], "v": [0, 0.01, 0]},
    ],
    "disk": [
        {"type": "disk", "center": [0.1, 0.2, -0.1], "normal": [1, 2, -1], "radius": 0.8},
        {"type": "disk", "center": [0, -30, 0], "normal": [0, -1, 0.001], "radius": 40},
    ],
    "plane": [
        {"type": "plane", "point": [0.1, -0.3, 0.2], "normal": [0.2, 3, -0.4]},
        {"type": "plane", "point": [0, 0, 1000], "normal": [0, 0, -1]},
    ],
}  # fmt: skip
