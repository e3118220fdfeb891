"""From the validated description to device arrays and the list of what the scene has."""

from __future__ import annotations

from renderer.cameras import kind_of
from renderer.core.backend import UInt32
from renderer.core.errors import SceneError
from renderer.core.rows import SELECT_LIMIT, Rows
from renderer.io.image import read_texture
from renderer.lights import KINDS as LIGHTS
from renderer.scene.arrange import AUTO, arrange
from renderer.scene.compiled import NOT_TEXTURED, CompiledScene, LightGroup
from renderer.scene.media import exterior_indices
from renderer.textures.bitmap import Atlas, Image
from renderer.textures.checkerboard import Checkerboards

CHECKERBOARD, ENVIRONMENT = "checkerboard", "environment"
PLAIN = (0, 0, 0, NOT_TEXTURED)


def compile_scene(loaded, accel=AUTO):
    """Return the CompiledScene of a LoadedScene, its shapes in the structure that `accel` names (see arrange.py).

    Raises SceneError for texture and mesh files that cannot be read.
    """
    world = loaded.description.scene
    ordered, geometry = arrange(loaded, accel)
    shapes = [shape for _, shape in ordered]
    materials = [shape.material for shape in shapes]
    records = [*map(_material, shapes, exterior_indices(shapes))]
    random = loaded.description.spp > 1
    alphas = [_alpha(material) for material in materials]
    rough = random and any(alphas)
    if rough:
        records = [[*record, alpha] for record, alpha in zip(records, alphas)]
    texture_records, textures = _textures(loaded, ordered)
    looks, records, texture_records = _distinct(records, texture_records)
    return CompiledScene(
        **geometry,
        lights=tuple(_light_groups(world.lightsources)),
        world=Rows([[*world.backgroundcolor, *world.ambientlight]]),
        looks=Rows(looks, UInt32) if looks else None,
        materials=Rows(records) if records else None,
        texture_rows=Rows(texture_records, UInt32) if textures else None,
        file_indices=Rows([[index] for index, _ in ordered], UInt32) if shapes else None,
        textures=textures,
        has_mirrors=any(m.isreflective or m.isrefractive for m in materials),
        has_glass=any(m.isrefractive for m in materials),
        has_rough_mirrors=rough,
        environment=_environment(loaded),
        random=random,
    )


def _environment(loaded):
    """Return the image around a phong scene, None where there is none."""
    description = loaded.description
    if description.rendermode != "phong" or all(light.type != ENVIRONMENT for light in description.scene.lightsources):
        return None
    from renderer.scene.light_sources import environment_of  # other scenes start faster without

    return environment_of(loaded, sampled=False)


def compile_camera(description):
    """Return the kind of the camera and its record."""
    kind = kind_of(description)
    return kind, Rows([kind.pack(description)])[0]


def _light_groups(lights):
    for name in dict.fromkeys(light.type for light in lights if light.type in LIGHTS):
        kind = LIGHTS[name]
        yield LightGroup(kind, Rows([kind.pack(light) for light in lights if light.type == name]))


def _distinct(materials, textures):
    """Return for each shape [its place in the tables], and the tables with every pair of records once.

    Among a few shapes a table of their own is read faster; None then stands for the places.
    """
    pairs = [(tuple(material), texture) for material, texture in zip(materials, textures)]
    places = {pair: place for place, pair in enumerate(dict.fromkeys(pairs))}
    if len(pairs) <= SELECT_LIMIT or len(places) == len(pairs):
        return None, materials, textures
    return [[places[pair]] for pair in pairs], *(list(table) for table in zip(*places))


def _material(shape, exterior):
    """Return the record of a shape's material, in the columns of compiled.py; `exterior` is the index around it."""
    m = shape.material
    share = m.reflectivity if m.isreflective or m.isrefractive else 0.0
    eta = m.refractiveindex / exterior if m.isrefractive else 1.0
    specular = [m.ks * component for component in m.specularcolor]
    squares = 1.0 if m.texture is None or isinstance(m.texture, str) else m.texture.scale
    scale = (m.scaleU * squares, m.scaleV * squares)
    return [*m.diffusecolor, m.kd, *specular, m.specularexponent, share, float(m.isrefractive), eta, *scale]


def _alpha(material):
    """Return the roughness of a material's mirror, 0 for glass and where there is none."""
    return material.roughness if material.isreflective and not material.isrefractive else 0.0


def _textures(loaded, ordered):
    """Return the texture records by shape and the lookups that they name."""
    materials = [shape.material for _, shape in ordered]
    files, boards, lookups = {}, [], []
    for (index, _), material in zip(ordered, materials):
        if isinstance(material.texture, str) and material.texture not in files:
            files[material.texture] = _read(loaded, index, material.texture)
        elif material.texture and not isinstance(material.texture, str):
            boards.append(material.texture)
    atlas = Atlas(files.values()) if files else None
    places = dict(zip(files, atlas.offsets)) if files else {}
    rows, boards_met = [], 0
    for material in materials:
        if material.texture is None:
            rows.append(PLAIN)
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
    return rows, tuple(samplers)


def _read(loaded, index, filename):
    """Return the Image in a texture file that a shape names."""
    try:
        return Image(*read_texture(loaded.resolve(filename)))
    except SceneError as error:
        raise loaded.refused(error, "scene", "shapes", index, "material", "texture") from error
