"""Strangers' spellings of scene keys, translated to ours, and foreign features that are recognised and left out.

Public solutions of the coursework extended its format in many ways. A file that uses their words still renders: what
is understood is translated with a note, what this version does not render is said in words. Only files in which
something unknown was found come here. The tables below are also the alias table of the reference page.
"""

from __future__ import annotations

from renderer.scene import schema
from renderer.scene.aliases_light import DIAMETERS, THIN_LENSES, LightSpellings, undecided
from renderer.scene.aliases_material import MaterialSpellings
from renderer.scene.aliases_mesh import MESH_FILES, MeshSpellings, folded, is_vector
from renderer.scene.findings import AT_KEY, NOTE, NOTHING, WARNING, Finding, linked, nearest, quoted

# Besides these, a key that differs from ours only in case, blanks, hyphens or underscores is understood.
RENAMED = {
    "file": {"camera samples": "samples", "spp": "samples", "samplesPerPixel": "samples", "maxBounces": "nbounces",
             "maxDepth": "nbounces", "mode": "rendermode"},
    "camera": {"up": "upVector", "target": "lookAt", "eye": "position", "verticalFov": "fov",
               "lensRadius": "apertureRadius", "focalDistance": "focusDistance"},
    "scene": {"lights": "lightsources", "objects": "shapes", "background": "backgroundcolor",
              "ambient": "ambientlight", "ambientcolor": "ambientlight"},
    "light": {"color": "intensity", "radiance": "intensity", "u_axis": "u", "v_axis": "v", "path": "filename",
              "file": "filename", "texture": "filename", "texturepath": "filename"},
    "shape": {"centre": "center", "uv_0": "uv0", "uv_1": "uv1", "uv_2": "uv2"},
    "material": {"texturefile": "texture", "texturepath": "texture", "textureFilename": "texture",
                 "color": "diffusecolor", "ior": "refractiveindex", "shininess": "specularexponent"},
}
CURVE = "this version has no such tone mapping setting; see tonemap and exposure"
MOTION = "animation is not rendered by this version; rendered at rest"
FALL_OFF = "a light falls off with the square of the distance in mode pathtracer, and not at all in phong mode"
SHADOW_RAYS = "every sample of a pixel sends its own shadow rays; see samples"
LENGTH = "the lens of this version is given by apertureRadius and focusDistance; fov tells the rest"
BRDF = "this version has no such weight; see bsdf"
MAPPING = "the mapping of this texture cannot be changed in this version, except by scaleU and scaleV"
UNRENDERED = {
    "file": {"shadow samples": SHADOW_RAYS, "frames": MOTION, "animation path": MOTION, "animations": MOTION,
             "animated objects": MOTION},
    "camera": {"focalLength": LENGTH, "gamma": CURVE, "Lw": CURVE},
    "scene": {},
    "light": {"kc": FALL_OFF, "kl": FALL_OFF, "kq": FALL_OFF, "samples": SHADOW_RAYS},
    "shape": {"uvsphere": MAPPING, "uvcylinder": MAPPING, "euler": MAPPING, "alias": MOTION},
    "material": dict.fromkeys(("transmittance", "dissolve", "reflectance", "fuzz"), BRDF)
    | {"ka": "the ambient weight is not rendered by this version; ambientlight counts in full"},
}
MODES = {"preview": "phong", "pathtracing": "pathtracer", "path": "pathtracer"}
LIGHT_TYPES = {"point": "pointlight", "area": "arealight", "spotlight": "spot", "directionallight": "directional",
               "sun": "directional", "envmap": "environment", "environmentmap": "environment"}
SHAPE_TYPES = {"ply": "mesh", "obj": "mesh"}
SHAPES_LEFT_OUT = {
    "cubemap": "images of cubes are not rendered by this version; see the light environment",
    "sphericalmap": "how its image lies around the scene cannot be told; see the light environment",
    "medium": "participating media are not rendered by this version",
}
MATERIAL_WORDS = {"hastexture", "transparency", "metallic", "brdftype", "emissioncolor", "emissive"}  # folded
# What takes more than a new name, for the reference page: (where, spelling, what is understood).
STRUCTURAL = (
    ("file", "lights, objects (no scene)", "scene.lightsources, scene.shapes"),
    ("camera", "look_at", "a direction: lookAt = position + look_at"),
    ("camera", f"type {', '.join(THIN_LENSES)}; a lens beside type pinhole", "type thinlens"),
    ("camera", f"{', '.join(DIAMETERS)}; aperture beside focusdistance", "a diameter: apertureRadius is half of it"),
    ("camera", "aperture beside type thinlens", "apertureRadius"),
    ("light `arealight`", "corner, edge1, edge2", "position = corner + (edge1 + edge2) / 2, u, v"),
    ("light `arealight`", "width, height beside directions u and v", "edges of these lengths; 1 for the missing one"),
    ("light `arealight`", "normal, width, height", "edges along the axes of textures of a plane with this normal"),
    ("light", 'type "ambient"', "its intensity is added to scene.ambientlight"),
    ("light", "intensity as one number", "the same in every channel, times color if that is given"),
    ("shape", "keys of a material", "moved into material"),
    ("shape", "position of a sphere", "center"),
    ("shape `mesh`", ", ".join(MESH_FILES), "filename"),
    ("shape `mesh`", "scale, euler, offset", "steps of transform: scale; rotate around x, y, z in degrees; translate"),
    ("shape `mesh`", "texturescale", "material.scaleU and material.scaleV"),
    ("shape, beside type", "reflectivity > 0 without isreflective", "isreflective"),
    ("material", "transparency > 0", "isrefractive, with reflectivity = transparency"),
    ("material", "emission, emissioncolor, emissive", "emission of the shape"),
    ("material", "metallic", "bsdf principled with the colour and roughness of the material"),
    ("material", "brdfType lambertian", "bsdf diffuse with the colour of the material"),
    ("material", "hasTexture false", "the texture is not used"),
    ("material", 'texture ""', "no texture"),
)
OWN = {"file": schema.Scene.keys, "camera": schema.Camera.keys, "scene": schema.World.keys,
       "light": {name: key for kind in schema.LIGHT_KINDS.values() for name, key in kind.node.keys.items()},
       "material": schema.Material.keys}


def translate(document, source):
    """Translate the document of a Source in place and return notes; its `moved` gets {path after: path in the file}."""
    return _Translation(document, source).notes


def replaced_mode(own, mode):
    """Return a remark on the file's own render mode if that is no word we know, though `mode` replaces it."""
    if type(own) is not str:
        return [Finding((None, "rendermode"), "must be a word", own)]
    if understood_mode(own) in schema.RENDER_MODES:
        return []
    message = f"unknown rendermode {quoted(own)}{nearest(own, schema.RENDER_MODES)}; rendered as {mode}, as asked"
    return [Finding((None, "rendermode"), message, severity=WARNING)]


def understood_mode(name):
    """Return the render mode that a spelling means, or the spelling itself where it means none."""
    mode = MODES.get(folded(name), folded(name))
    return mode if mode in schema.RENDER_MODES else name


class _Translation(LightSpellings, MaterialSpellings, MeshSpellings):
    """One walk over a document from the top down, so that every step knows where its values came from."""

    def __init__(self, document, source):
        self.moved, self._original, self.notes = source.moved, source.original, []
        self._layout(document)
        self._keys(document, (), "file", OWN["file"])
        self._mode(document)
        if type(document.get("camera")) is dict:
            self._camera(document["camera"])
        if type(document.get("scene")) is dict:
            self._scene(document["scene"])

    # Notes and moves

    def _note(self, path, message, severity=NOTE, anchor=AT_KEY):
        self.notes.append(Finding(linked(self._original(path)), message, NOTHING, anchor, severity, as_written=True))

    def _move(self, table, old, other, new, target):
        """Move key `old` of the object at the path `table` = (path, object) to key `new` of `other`, with a note."""
        path, source = table
        to_path, to = other
        told = ".".join(str(step) for step in (*to_path[len(path):], new))
        self._note((*path, old), f"understood {quoted(old)} as {target or told}")
        origin = self._original((*path, old))
        to[new] = source.pop(old)
        self.moved[(*to_path, new)] = origin

    def _keys(self, table, path, where, own):
        """Rename what is only spelt differently and take out what is not rendered."""
        plain = {folded(name): name for name in own}
        known = {folded(name): new for name, new in RENAMED[where].items()}
        left_out = {folded(name): why for name, why in UNRENDERED[where].items()}
        for name in [name for name in table if name not in own]:
            new = plain.get(folded(name)) or known.get(folded(name))
            if new in own and new not in table:
                self._move((path, table), name, (path, table), new, None)
            elif folded(name) in left_out:
                self._note((*path, name), left_out[folded(name)], WARNING)
                del table[name]

    # The parts of a file

    def _layout(self, document):
        """Gather a scene whose lights and objects lie at the top level."""
        document.pop("$schema", None)  # for editors
        if "scene" in document or not ("objects" in document or "shapes" in document):
            return
        document["scene"] = world = {}
        plain = {folded(name): name for name in OWN["scene"]} | RENAMED["scene"]
        for name in [name for name in document if name not in OWN["file"]]:
            new = plain.get(folded(name))
            if new is not None and new not in world:
                self._move(((), document), name, (("scene",), world), new, f"scene.{new}")

    def _mode(self, document):
        mode = document.get("rendermode")
        if type(mode) is not str or mode in schema.RENDER_MODES:
            return
        new = understood_mode(mode)
        if new in schema.RENDER_MODES:
            self._note(("rendermode",), f"understood rendermode {quoted(mode)} as {new}", anchor="value")
            document["rendermode"] = new

    def _camera(self, camera):
        path = ("camera",)
        towards, position = camera.get("look_at"), camera.get("position")
        if "lookAt" not in camera and is_vector(towards) and is_vector(position):
            self._move((path, camera), "look_at", (path, camera), "lookAt", "a direction: lookAt = position + look_at")
            camera["lookAt"] = [a + b for a, b in zip(position, towards, strict=True)]
        self._lens(camera, path)

    def _scene(self, world):
        self._keys(world, ("scene",), "scene", OWN["scene"])
        self._list(world, "lightsources", LIGHT_TYPES, {}, schema.LIGHT_KINDS)
        for index, light in enumerate(_objects(world.get("lightsources"))):
            if light is not None:
                self._light(light, ("scene", "lightsources", index))
        self._list(world, "shapes", SHAPE_TYPES, SHAPES_LEFT_OUT, schema.SHAPE_KINDS)
        for index, shape in enumerate(_objects(world.get("shapes"))):
            if shape is not None:
                self._shape(shape, ("scene", "shapes", index))

    def _list(self, world, name, types, left_out, own):
        """Take foreign kinds out of a list, keeping where the others stood in the file."""
        if type(world.get(name)) is not list:
            return
        kept, path = [], ("scene", name)
        for index, entry in enumerate(world[name]):
            kind = entry.get("type") if type(entry) is dict else None
            plain = folded(kind) if type(kind) is str else None
            if plain == "ambient" and name == "lightsources":
                self._ambient(world, entry, (*path, index))
            elif plain in left_out:
                self._note((*path, index), f"left out: {left_out[plain]}", WARNING)
            elif name == "lightsources" and plain and undecided(entry):
                self._note((*path, index), undecided(entry), WARNING)
            else:
                if plain is not None and kind not in own and types.get(plain, plain) in own:
                    entry["type"] = types.get(plain, plain)
                    self._note((*path, index, "type"), f"understood type {quoted(kind)} as {entry['type']}")
                if len(kept) != index:
                    self.moved[(*path, len(kept))] = self._original((*path, index))
                kept.append(entry)
        world[name] = kept

    def _ambient(self, world, light, path):
        colour = light.get("intensity", light.get("color", light.get("ambientlight")))
        colour = [colour] * 3 if type(colour) in (int, float) else colour
        if not is_vector(colour):
            self._note(path, "left out: an ambient light needs an intensity [r, g, b]", WARNING)
            return
        given = world.get("ambientlight", [0.0, 0.0, 0.0])
        if is_vector(given):
            self._note(path, "understood this ambient light as scene.ambientlight")
            self.moved[("scene", "ambientlight")] = self._original(path)
            world["ambientlight"] = [a + b for a, b in zip(given, colour, strict=True)]

    def _shape(self, shape, path):
        record = schema.SHAPE_KINDS.get(shape.get("type")) if type(shape.get("type")) is str else None
        if record is None:
            return
        own = record.node.keys
        if shape["type"] == "mesh":
            self._mesh(shape, path)
        self._keys(shape, path, "shape", own)
        if shape["type"] == "sphere" and "position" in shape and "center" not in shape:
            self._move((path, shape), "position", (path, shape), "center", None)
        material = shape.get("material", {})
        if type(material) is not dict:
            return
        inner = (*path, "material")
        known = MATERIAL_WORDS | {
            folded(name) for table in (OWN["material"], RENAMED["material"], UNRENDERED["material"]) for name in table
        }
        plain = {folded(name): new for name, new in RENAMED["material"].items()}
        plain |= {folded(name): name for name in OWN["material"]}
        for name in [name for name in shape if name not in own and folded(name) in known]:
            new = plain.get(folded(name), name)
            if new in material:
                continue
            self._move((path, shape), name, (inner, material), new, f"material.{new}")
            share = material[new]
            if new == "reflectivity" and "isreflective" not in material and type(share) in (int, float):
                material["isreflective"] = share > 0
        if material:
            shape["material"] = material
            self._material(material, inner)
        self._emission(shape, material, path)

    def _material(self, material, path):
        self._keys(material, path, "material", OWN["material"])
        if material.get("texture") == "":
            self._note((*path, "texture"), "understood an empty name as no texture")
            del material["texture"]
        for name in [name for name in material if folded(name) == "hastexture"]:
            used = material.pop(name)
            if used is False and material.pop("texture", None) is not None:
                self._note((*path, name), f"understood {name} false: the texture is not used")
        share = material.get("transparency")
        if type(share) in (int, float) and 0 <= share <= 1:
            self._note((*path, "transparency"), "understood as the share of glass: isrefractive with this reflectivity"
                       if share > 0 else "understood transparency 0 as no glass")
            del material["transparency"]
            if share > 0:
                material["isrefractive"], material["reflectivity"] = True, share
        self._brdf(material, path)


def _objects(entries):
    """Return the entries of a list that are objects, None for the others; nothing if it is no list."""
    return [entry if type(entry) is dict else None for entry in entries] if type(entries) is list else []
