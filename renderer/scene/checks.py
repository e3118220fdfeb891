"""What no single key can show: cameras that see nothing, shapes that are none, files that are not there.

Pure Python in double precision, so that a scene without convex volumes needs no numerical library to be checked.
"""

from __future__ import annotations

import os

from renderer.core.vectors import cross, length, subtract, unit
from renderer.scene import schema
from renderer.scene.checks_lights import check_lights
from renderer.scene.checks_shapes import CHECKS, FLAT, PARALLEL
from renderer.scene.findings import NOTE, WARNING, Finding, linked, nearest_file, quoted
from renderer.scene.loaded import resolve
from renderer.scene.materials import TEXTURABLE_KEYS, textures_of

NOT_ABOVE_ONE = "is a reflectance or a fraction here, so its colours must not be greater than 1"


def check(description, directory, findings):
    """Return `[(index, shape)]` of what can be rendered; append what is wrong or odd to `findings`.

    Parts of the description that had mistakes are None and are passed over.
    """
    if description.camera is not None:
        _check_camera(description.camera, findings)
    world, kept = description.scene, []
    if world is None or world.shapes is None:
        return kept
    materials, textures, meshes, shapes_at = {}, {}, {}, linked(("scene", "shapes"))
    for index, shape in enumerate(world.shapes):
        if shape is None:
            continue
        at = (shapes_at, index)
        before = len(findings)
        CHECKS[shape.type](shape, at, findings)
        if id(shape.material) not in materials:  # many shapes share one
            materials[id(shape.material)] = shape.material
            _check_material(shape.material, (at, "material"), textures, findings)
        if shape.type == "mesh":
            meshes.setdefault(shape.filename, (at, "filename"))
        if len(findings) == before:
            kept.append((index, shape))
    _check_files("texture", textures, directory, findings)
    _check_files("mesh", meshes, directory, findings)
    _check_files("environment", _environments(world.lightsources), directory, findings)
    check_lights(description, kept, findings)
    _note_unused(description, findings)
    if not kept and None not in world.shapes:
        why = "has no shapes" if not world.shapes else "has no shapes left that could be seen"
        findings.append(Finding(linked(("scene",)), f"{why}; only the background is rendered", severity=NOTE))
    return kept


def too_many_pixels(width, height):
    """Return the complaint about a picture that is too large."""
    most = schema.MAX_PIXELS
    return f"width times height must be at most {most:,} pixels, got {width} x {height} = {width * height:,}"


def _check_camera(camera, findings):
    """Find pictures that are too large, cameras without a direction, and settings of a lens that is not there."""
    at = (None, "camera")
    if camera.width * camera.height > schema.MAX_PIXELS:
        findings.append(Finding((at, "width"), too_many_pixels(camera.width, camera.height)))
    if camera.type != "thinlens" and camera.apertureRadius > 0:
        message = f"type {camera.type} has no lens, so all is sharp; set type to \"thinlens\" for depth of field"
        findings.append(Finding((at, "apertureRadius"), message, severity=WARNING))
    if camera.type == "thinlens" and camera.apertureRadius == 0:
        findings.append(Finding((at, "type"), "a lens with apertureRadius 0 shows all sharp", severity=NOTE))
    if camera.type != "orthographic" and camera.viewHeight is not None:
        message = f"type {camera.type} shows what fov says; set type to \"orthographic\" for parallel rays"
        findings.append(Finding((at, "viewHeight"), message, severity=WARNING))
    view = subtract(camera.lookAt, camera.position)
    scale = max(map(abs, camera.lookAt + camera.position))
    if length(view) <= FLAT * scale or not any(view):
        findings.append(Finding((at, "lookAt"), "must differ from position: the camera needs a direction to look in",
                                list(camera.lookAt)))
        return
    if not any(camera.upVector):
        findings.append(Finding((at, "upVector"), "must not be [0, 0, 0]: the picture needs an up direction"))
    elif length(cross(unit(view), unit(camera.upVector))) < PARALLEL:
        message = "must not be parallel to the direction of view (lookAt - position): the picture has no up then"
        findings.append(Finding((at, "upVector"), message))


def _check_material(material, at, textures, findings):
    """Add the files that a material names to {name: place of the first mention}; find boards of impossible colours."""
    for path, source in [*textures_of(material, paths=False), *textures_of(material, paths=True)]:
        here = at
        for step in path:
            here = (here, step)
        if isinstance(source, str):
            textures.setdefault(source, here)
    for name in TEXTURABLE_KEYS.get(type(material.bsdf), ()):
        board = getattr(material.bsdf, name)
        if getattr(board, "type", None) == "checkerboard" and max(board.color1 + board.color2) > 1:
            findings.append(Finding(((at, "bsdf"), name), NOT_ABOVE_ONE))


def _environments(lights):
    """Return {file name: place} of the first mention of each environment."""
    found = {}
    for index, light in enumerate(lights or ()):
        if light is not None and light.type == "environment":
            found.setdefault(light.filename, (linked(("scene", "lightsources", index)), "filename"))
    return found


def _check_files(what, names, directory, findings):
    """Find files that cannot be opened; `names` has the first mention of each."""
    for name, at in names.items():
        path = resolve(directory, name)
        if not os.path.isfile(path):
            why = "is a directory" if os.path.isdir(path) else f"no such file{nearest_file(path)}"
            findings.append(Finding(at, f"{what} {quoted(name)}: {why} (tried {_printable(path.absolute())})"))
        elif not os.access(path, os.R_OK):
            findings.append(Finding(at, f"{what} {quoted(name)}: may not be read ({_printable(path.absolute())})"))


def _printable(path):
    """Return a path as text that any terminal takes."""
    return str(path).encode("utf-8", "replace").decode("utf-8")


def _note_unused(description, findings):
    """Tell once what counts in mode pathtracer only, where the mode is phong."""
    if description.rendermode != "phong":
        return
    shapes_at = linked(("scene", "shapes"))
    told = set()
    for index, shape in enumerate(description.scene.shapes):
        if shape is None:
            continue
        material = shape.material
        if "emission" not in told and any(shape.emission):
            told.add("emission")
            _note_paths_only(((shapes_at, index), "emission"), "the shape does not shine", findings)
        if "bsdf" not in told and material.bsdf is not None:
            told.add("bsdf")
            _note_paths_only((((shapes_at, index), "material"), "bsdf"), "the keys of phong mode count", findings)
        if "maps" not in told and (material.normalmap or material.bumpmap):
            told.add("maps")
            name = "normalmap" if material.normalmap else "bumpmap"
            _note_paths_only((((shapes_at, index), "material"), name), "the surface is smooth", findings)


def _note_paths_only(at, instead, findings):
    findings.append(Finding(at, f'counts in mode "{schema.PATHTRACER}" only; here {instead}', severity=NOTE))
