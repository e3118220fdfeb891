"""Things of every kind that a scene may have, and that do not change its picture: for what they add to the kernel.

Shapes are black, a ten thousandth of the scene in size, and lie behind the camera. Lights are a billion times weaker
than what is seen, and the lens is a billionth wide. Around everything lies an image that has the background's colour,
and far below an infinite plane that shows it too; scenes with an image of their own do without the plane, which would
hide half of it. A path may meet such a shape, or choose such a light, by a chance far below the noise of any picture.
"""

from __future__ import annotations

import copy

import numpy as np

from benchmarks.path_scenes import write_radiance
from renderer.io import mesh_ply
from renderer.scene.schema import PATHTRACER, World

PARTS = ("shapes", "lights", "materials", "textures", "surroundings", "lens")
MESH = "a mesh"  # the one part that changes how shapes are found: through a hierarchy
BELOW = 1e6  # scene units down to the plane
WEAK = 1e-9  # intensities, radiances, and the aperture
SIZE, BEHIND, APART = 1e-4, 0.02, 1e-3  # of the distance between the camera and what it looks at
TEXELS = 4  # sides of images
BLACK = [0.0, 0.0, 0.0]
AMBIENT = World().ambientlight  # where a file has none
GLOW = [WEAK] * 3


def with_parts(document, folder, parts):
    """Return a scene's document with the inert things of some PARTS, which need files in `folder`."""
    document = copy.deepcopy(document)
    paths, world, place = document["rendermode"] == PATHTRACER, document["scene"], _places(document["camera"])
    shapes = _shapes(place) if "shapes" in parts else []
    own_image = any(light["type"] == "environment" for light in world.get("lightsources", []))
    materials = _materials(paths) if "materials" in parts else []
    if "textures" in parts:
        materials += _textures(folder, paths)
    for k, material in enumerate(materials):  # on the shapes that are there, then on more spheres
        if k == len(shapes):
            shapes.append(_sphere(next(place)))
        shapes[k]["material"] = material
    lights = list(world.get("lightsources", []))
    if "lights" in parts:
        lights += _lights(place)
        shapes += _glowing(place) if paths else []
    if "shapes" in parts and not own_image:
        shapes.append(_plane(world, paths))
    if "surroundings" in parts and not own_image:
        lights.append(_surroundings(folder, world.get("backgroundcolor", BLACK)))
    if MESH in parts:
        shapes.append(_mesh(folder, next(place)))
    if "lens" in parts and document["camera"].get("type", "pinhole") == "pinhole":
        document["camera"] |= {"type": "thinlens", "apertureRadius": WEAK}
    for shape in shapes:
        shape.setdefault("material", {"bsdf": _diffuse(BLACK)} if paths else {"diffusecolor": BLACK, "ks": 0.0})
    document["scene"] = world | {"shapes": [*world["shapes"], *shapes], "lightsources": lights}
    return document


def _places(camera):
    """Yield points behind the camera (x, y, z) and the size of what may lie there, side by side, without an end."""
    eye, middle = np.array(camera["position"], float), np.array(camera["lookAt"], float)
    forward = middle - eye
    scale = np.linalg.norm(forward)
    side = np.cross(forward, [0.0, 1.0, 0.0] if abs(forward[1]) < 0.9 * scale else [1.0, 0.0, 0.0])
    step = 0
    while True:
        yield eye - BEHIND * forward + step * APART * scale * side / np.linalg.norm(side), float(SIZE * scale)
        step += 1


def _at(place, *offset):
    """Return a point beside a place, at an offset in sizes."""
    return (place[0] + place[1] * np.array(offset)).tolist()


def _edge(place, axis):
    """Return an edge along an axis."""
    return [place[1] * (k == axis) for k in range(3)]


def _sphere(place):
    """Return a sphere."""
    return {"type": "sphere", "center": _at(place, 0, 0, 0), "radius": place[1]}


def _triangle(place):
    """Return a triangle."""
    return {"type": "triangle", "v0": _at(place, 0, 0, 0), "v1": _at(place, 1, 0, 0), "v2": _at(place, 0, 1, 0)}


def _box(place):
    """Return a box."""
    return {"type": "box", "min": _at(place, 0, 0, 0), "max": _at(place, 1, 1, 1)}


def _tetrahedron(place):
    """Return its corners."""
    return [_at(place, *corner) for corner in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))]


def _shapes(place):
    """Return a shape of each kind but meshes, solids first; what lies askew keeps its directions as values."""
    middle, size = here = next(place)
    return [
        {"type": "cylinder", "center": middle.tolist(), "axis": [1, 2, 3], "radius": size, "height": size},
        _sphere(next(place)), _box(next(place)), {"type": "convex", "vertices": _tetrahedron(next(place))},
        {"type": "rectangle", "center": _at(next(place), 0, 0, 0), "u": _edge(here, 0), "v": _edge(here, 2)},
        {"type": "disk", "center": _at(next(place), 0, 0, 0), "normal": [3, 2, 1], "radius": size},
        _triangle(next(place)),
    ]  # fmt: skip


def _plane(world, paths):
    """Return a plane in the background's colour: it emits it or, in phong mode, reflects ambient light alone."""
    colour, ambient = world.get("backgroundcolor", BLACK), world.get("ambientlight", AMBIENT)
    plane = {"type": "plane", "point": [0, -BELOW, 0], "normal": [0.1, 1, 0.2]}
    if paths:
        return plane | {"emission": colour}
    shown = [wanted / given if given else 0.0 for wanted, given in zip(colour, ambient)]
    return plane | {"material": {"kd": 0.0, "ks": 0.0, "diffusecolor": shown}}


def _materials(paths):
    """Return materials of each kind, with all the lobes and branches that one can have; glass, for solids, first."""
    mirror = {"diffusecolor": BLACK, "isreflective": True, "reflectivity": 0.5}
    coursework = [mirror, mirror | {"roughness": 0.2}]
    glass = [{"diffusecolor": BLACK, "isrefractive": True, "reflectivity": 0.5, "refractiveindex": 1.3}]
    if not paths:
        return glass + coursework
    tinted = {"reflectance": [0.9, 0.8, 0.7]}
    glass += [{"bsdf": {"type": "dielectric", **tinted}},
              {"bsdf": {"type": "roughdielectric", "alpha": 0.2, "distribution": "beckmann", **tinted}}]  # fmt: skip
    lobes = dict.fromkeys(("metallic", "speculartint", "anisotropic", "sheen", "sheentint", "clearcoat"), 0.5)
    bsdfs = [_diffuse(BLACK), {"type": "mirror"}, {"type": "conductor"}, {"type": "roughconductor", "alpha": 0.2},
             {"type": "plastic"}, {"type": "principled", **lobes}]  # fmt: skip
    return glass + coursework + [{"bsdf": bsdf} for bsdf in bsdfs]


def _textures(folder, paths):
    """Return materials with images by either filter and wrap, a checkerboard and, in path tracing, both maps."""
    from PIL import Image

    Image.fromarray(np.zeros((TEXELS, TEXELS, 3), np.uint8)).save(folder / "black.png")
    Image.fromarray(np.full((TEXELS, TEXELS, 3), (128, 128, 255), np.uint8)).save(folder / "flat.png")
    board = {"type": "checkerboard", "color2": BLACK}
    looks = [{"texturefilter": kind, "texturewrap": wrap}
             for kind, wrap in (("bilinear", "repeat"), ("nearest", "clamp"))]  # fmt: skip
    if not paths:
        return [{"texture": "black.png", "ks": 0.0, **look} for look in looks] + [{"texture": board, "ks": 0.0}]
    maps = {"normalmap": "flat.png", "bumpmap": "flat.png"}
    return [*({"bsdf": _diffuse("black.png"), **look} for look in looks), {"bsdf": _diffuse(board), **maps}]


def _diffuse(reflectance):
    """Return a matt BSDF."""
    return {"type": "diffuse", "reflectance": reflectance}


def _lights(place):
    """Return a light of each kind but the environment."""
    spots = [_at(next(place), 0, 0, 0) for _ in range(4)]
    here = next(place)
    return [
        {"type": "pointlight", "position": spots[0], "intensity": GLOW},
        {"type": "spot", "position": spots[1], "direction": [1, 2, 3], "intensity": GLOW},
        {"type": "directional", "direction": [1, -2, 3], "intensity": GLOW},
        {"type": "arealight", "position": spots[2], "u": _edge(here, 0), "v": _edge(here, 2), "intensity": GLOW},
        {"type": "disklight", "position": spots[3], "normal": [1, 2, 3], "radius": here[1], "intensity": GLOW},
    ]


def _glowing(place):
    """Return shapes that shine: a sphere, which is sampled, and a box, which is not."""
    return [make(next(place)) | {"emission": GLOW} for make in (_sphere, _box)]


def _surroundings(folder, colour):
    """Return an environment of one colour."""
    pixels = np.broadcast_to(np.maximum(np.float32(colour), np.float32(WEAK)), (TEXELS, 2 * TEXELS, 3))
    write_radiance(folder / "surroundings.exr", pixels)
    return {"type": "environment", "filename": "surroundings.exr"}


def _mesh(folder, place):
    """Return a mesh: a tetrahedron."""
    faces = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
    mesh_ply.write(folder / "inert.ply", np.array(_tetrahedron(place)), faces)
    return {"type": "mesh", "filename": "inert.ply"}
