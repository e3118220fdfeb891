"""From the validated description to device arrays and the list of what the scene has."""

from __future__ import annotations

from renderer.cameras import KINDS as CAMERAS
from renderer.core.backend import UInt32
from renderer.core.errors import SceneError
from renderer.core.rows import Rows
from renderer.io.image import read_texture
from renderer.lights import KINDS as LIGHTS
from renderer.scene.compiled import NOT_TEXTURED, CompiledScene, LightGroup, ShapeGroup
from renderer.scene.media import exterior_indices
from renderer.shapes import KINDS as SHAPES
from renderer.textures.bitmap import Atlas, Image
from renderer.textures.checkerboard import Checkerboards

CHECKERBOARD = "checkerboard"


def compile_scene(loaded):
    """Return the CompiledScene of a LoadedScene; raises SceneError for texture files that cannot be read."""
    world = loaded.description.scene
    ordered = sorted(loaded.shapes, key=lambda item: item[1].type)  # stable: the file's order within a kind
    shapes = [shape for _, shape in ordered]
    materials = [shape.material for shape in shapes]
    texture_rows, textures = _textures(loaded, ordered)
    return CompiledScene(
        shapes=tuple(_shape_groups(shapes)),
        lights=tuple(_light_groups(world.lightsources)),
        world=Rows([[*world.backgroundcolor, *world.ambientlight]]),
        materials=Rows([*map(_material, shapes, exterior_indices(shapes))]) if shapes else None,
        file_indices=Rows([[index] for index, _ in ordered], UInt32) if shapes else None,
        texture_rows=texture_rows,
        textures=textures,
        has_mirrors=any(m.isreflective or m.isrefractive for m in materials),
        has_glass=any(m.isrefractive for m in materials),
    )


def compile_camera(description):
    """Return the kind of the camera and its record."""
    kind = CAMERAS[description.type]
    return kind, Rows([kind.pack(description)])[0]


def _shape_groups(shapes):
    first = 0
    for name in dict.fromkeys(shape.type for shape in shapes):
        kind, members = SHAPES[name], [shape for shape in shapes if shape.type == name]
        columns = kind.columns(members) if kind.columns else None
        records = [kind.pack(shape, columns) for shape in members]
        yield ShapeGroup(kind, Rows(records, directions=kind.directions), first)
        first += len(members)


def _light_groups(lights):
    for name in dict.fromkeys(light.type for light in lights):
        kind = LIGHTS[name]
        yield LightGroup(kind, Rows([kind.pack(light) for light in lights if light.type == name]))


def _material(shape, exterior):
    """Return the record of a shape's material, in the columns of compiled.py; `exterior` is the index around it."""
    m = shape.material
    share = m.reflectivity if m.isreflective or m.isrefractive else 0.0
    eta = m.refractiveindex / exterior if m.isrefractive else 1.0
    specular = [m.ks * component for component in m.specularcolor]
    squares = 1.0 if m.texture is None or isinstance(m.texture, str) else m.texture.scale
    scale = (m.scaleU * squares, m.scaleV * squares)
    return [*m.diffusecolor, m.kd, *specular, m.specularexponent, share, float(m.isrefractive), eta, *scale]


def _textures(loaded, ordered):
    """Return the texture records by shape index and the lookups that they name; (None, ()) without textures."""
    materials = [shape.material for _, shape in ordered]
    files, boards, lookups = {}, [], []
    for (index, _), material in zip(ordered, materials):
        if isinstance(material.texture, str) and material.texture not in files:
            files[material.texture] = _read(loaded, index, material.texture)
        elif material.texture and not isinstance(material.texture, str):
            boards.append(material.texture)
    if not files and not boards:
        return None, ()
    atlas = Atlas(files.values()) if files else None
    places = dict(zip(files, atlas.offsets)) if files else {}
    rows, boards_met = [], 0
    for material in materials:
        if material.texture is None:
            rows.append((0, 0, 0, NOT_TEXTURED))
            continue
        if isinstance(material.texture, str):
            image, use = files[material.texture], (material.texturefilter, material.texturewrap)
            values = (places[material.texture], image.width, image.height)
        else:
            use, values, boards_met = CHECKERBOARD, (boards_met, 0, 0), boards_met + 1
        if use not in lookups:
            lookups.append(use)
        rows.append((*values, lookups.index(use) + 1))
    checkerboards = Checkerboards(boards) if boards else None
    samplers = (checkerboards.sample if use is CHECKERBOARD else atlas.sampler(*use) for use in lookups)
    return Rows(rows, UInt32), tuple(samplers)


def _read(loaded, index, filename):
    """Return the Image in a texture file that a shape names."""
    try:
        return Image(*read_texture(loaded.resolve(filename)))
    except SceneError as error:
        message = "; ".join(f"{problem.file}: {problem.message}" for problem in error.problems)
        place = ("scene", "shapes", index, "material", "texture")
        raise SceneError(loaded.source.problem(message, *place)) from error
