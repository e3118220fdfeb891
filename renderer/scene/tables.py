"""From the validated description to device arrays and the list of what the scene has."""

from __future__ import annotations

from renderer.cameras import kind_of
from renderer.core.backend import UInt32
from renderer.core.rows import SELECT_LIMIT, Rows
from renderer.lights import KINDS as LIGHTS
from renderer.scene.arrange import AUTO, arrange
from renderer.scene.compiled import CompiledScene, LightGroup
from renderer.scene.media import exterior_indices
from renderer.scene.texturing import AS_WRITTEN, Texturing, use_of

ENVIRONMENT = "environment"


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
    uses = [use_of(material, material, "texture") for material in materials]
    looks, records, uses = _distinct(records, uses)
    return CompiledScene(
        **geometry,
        lights=tuple(_light_groups(world.lightsources)),
        world=Rows([[*world.backgroundcolor, *world.ambientlight]]),
        looks=Rows(looks, UInt32) if looks else None,
        materials=Rows(records) if records else None,
        texture=Texturing(loaded, ordered, paths=False).slot(uses, AS_WRITTEN),
        file_indices=Rows([[index] for index, _ in ordered], UInt32) if shapes else None,
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


def _distinct(materials, uses):
    """Return for each shape [its place in the tables], and both lists with every pair of a material and a texture once.

    Among a few shapes a table of their own is read faster; None then stands for the places.
    """
    pairs = [(tuple(material), use) for material, use in zip(materials, uses)]
    places = {pair: place for place, pair in enumerate(dict.fromkeys(pairs))}
    if len(pairs) <= SELECT_LIMIT or len(places) == len(pairs):
        return None, materials, uses
    return [[places[pair]] for pair in pairs], *map(list, zip(*places))


def _material(shape, exterior):
    """Return the record of a shape's material, in the columns of compiled.py; `exterior` is the index around it."""
    m = shape.material
    share = m.reflectivity if m.isreflective or m.isrefractive else 0.0
    eta = m.refractiveindex / exterior if m.isrefractive else 1.0
    specular = [m.ks * component for component in m.specularcolor]
    return [*m.diffusecolor, m.kd, *specular, m.specularexponent, share, float(m.isrefractive), eta]


def _alpha(material):
    """Return the roughness of a material's mirror, 0 for glass and where there is none."""
    return material.roughness if material.isreflective and not material.isrefractive else 0.0
