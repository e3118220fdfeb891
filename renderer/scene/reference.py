"""The reference page of the scene format and its JSON Schema, made from the declarations that also validate.

`python -m renderer.scene.reference` writes docs/scene-format.md and docs/scene.schema.json anew; a test compares.
"""

from __future__ import annotations

import json
from pathlib import Path

from renderer.scene import aliases, materials, schema
from renderer.scene.aliases_light import ANY_APERTURE, SIZE_ALONE
from renderer.scene.aliases_material import NO_BRDF
from renderer.scene.reference_paths import PATHS
from renderer.scene.quantities import Checkerboard

RECORDS = (
    schema.Scene, schema.Camera, schema.World,
    *(record.node for kinds in (schema.LIGHT_KINDS, schema.SHAPE_KINDS) for record in kinds.values()),
    schema.Step, schema.Rotation, materials.Material, *materials.BSDF_RECORDS, Checkerboard,
)
TITLES = {"Scene": "The file", "Camera": "`camera`", "World": "`scene`", "Step": "Step of a `transform`",
          "Rotation": "`rotate`", "Material": "`material`", "Checkerboard": "Texture `checkerboard`"}
TITLES |= {record.node.__name__: f"Light `{name}`" for name, record in schema.LIGHT_KINDS.items()}
TITLES |= {record.__name__: f"`bsdf` `{record.__name__.lower()}`" for record in materials.BSDF_RECORDS}

HEAD = """# The scene file

A scene file is a JSON object: a superset of the format of the 'Automagic' rendering coursework. This page and the
[JSON Schema](scene.schema.json) are generated from the declarations in `renderer/scene/schema.py`, by which files
are checked. For completion and checks while typing, point an editor at the schema; `python -m renderer schema`
prints it.

A smallest file:

```json
{
  "camera": {"position": [0, 0, 0], "lookAt": [0, 0, 1]},
  "scene": {
    "lightsources": [{"type": "pointlight", "position": [0, 2, 0], "intensity": [0.6, 0.6, 0.6]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 3], "radius": 1}]
  }
}
```

Mistakes are reported all at once, each with its line, column and key. A key that is not listed here is reported and
ignored; with `--strict` it is a mistake, as is everything else that would be left out. Shapes without any extent (a
triangle whose corners lie on a line, a flat box, an empty convex volume) are dropped with a warning. Numbers may not
be beyond 1e18 in size, because the renderer computes with squares of lengths in 32-bit floats. NaN, Infinity,
comments and keys given twice are no JSON and are refused.
"""

CONVENTIONS = """## Conventions

* **Units.** Lengths are in scene units of your choice, angles in degrees, colours linear RGB, 1 being white.
* **Picture.** To the right is `upVector` x forward: looking along +z with +y up, +x is on the right. `fov` is the
  vertical field of view. Row 0 is on top. With `samples` 1, one ray goes through the centre of each pixel (but in mode
  `pathtracer`).
* **Cylinder.** `height` is *half* the length; both ends are capped.
* **Mode `binary`.** What is hit is red, the rest is black.
* **Mode `phong`.** Per light, with N facing the viewer and H halfway between the light and the viewer:
  `intensity * (kd * diffusecolor * max(N.L, 0) + ks * specularcolor * max(N.H, 0) ^ specularexponent)`, nothing where
  N.L <= 0 or where another shape is between the point and the light; no fall-off with distance. To the sum comes
  `ambientlight * diffusecolor`.
* **Mirrors and glass.** With `isreflective` or `isrefractive`, the result is `(1 - reflectivity) * local +
  reflectivity * other`. For a mirror, the other share is what is seen in the reflected direction. For glass
  (`isrefractive`, whatever `isreflective` says), Fresnel's equations for unpolarised light divide it between the
  reflected and the refracted direction, both followed up to `nbounces` times; total reflection sends all into the
  first. A ray that runs out of bounces or hits nothing sees `backgroundcolor`.
* **Nested glass.** The surface of a closed refractive shape separates its `refractiveindex` from that of the smallest
  closed refractive shape that wholly contains it, or from 1. An air bubble in glass is a shape of index 1 inside it.
* **Meshes.** An OBJ or PLY file, ASCII or binary. Polygons are cut into fans of triangles, groups and objects make one
  mesh, materials in the file are not read. Mistakes in a file are told with its line. A mesh is a sheet, as a triangle
  is: it need not be closed, and it surrounds nothing. Transformation steps are applied in their order: `[{"scale": 2},
  {"translate": [0, 1, 0]}]` doubles the mesh around the origin and then lifts it. See [meshes](meshes.md).
* **Lamps in phong mode.** An `arealight` or `disklight` is a point light at a random one of its points for every
  sample, so that shadows are soft with `samples` > 1, and is not seen. `roughness` blurs a mirror likewise. An
  `environment` is what rays see that hit nothing. `emission`, `bsdf` and maps of normals and heights count in mode
  `pathtracer` only.
* **Debug modes.** `depth` (distance along the ray, near is white), `normals` (0.5 + 0.5 n, outward), `uv` (fractions
  of u and v in red and green), `albedo` (diffuse colour or texture), `shapes` (a colour for each index in `shapes`).
* **Exposure.** Radiance times `exposure` / 0.1 goes through the curve `tonemap`; `linear` clamps at 1. Binary and
  phong pictures are written without gamma. EXR files hold linear radiance without exposure.
* **Textures.** v = 0 is the top row of the image. The image is looked up at (u * `scaleU`, v * `scaleV`); 8-bit
  values are divided by 255, without decoding. A checkerboard shows `color1` where floor(scale u) + floor(scale v) is
  even. A file name is relative to the scene file; a folder `textures` beside it is tried next.
* **Texture coordinates.** An image is upright, and is not mirrored, for who looks at a shape from outside with +y up.
  For an axis or normal n, t = unit(n x [0, 1, 0]), or unit(n x [0, 0, 1]) where |n.y| >= 0.9, and b = n x t: t runs
  to the right and b down. Sphere, d = p - center: u = atan2(d.z, d.x) / 2 pi mod 1, v = acos(d.y / radius) / pi.
  Cylinder, in the frame of its axis a: u = atan2(-d.b, d.t) / 2 pi mod 1, v = (height - d.a) / (2 height) on the
  side, and on the caps the distance from the axis over `radius`. Triangle: interpolated between `uv0`, `uv1` and
  `uv2`. Plane: u = (p - point).t, v = (p - point).b, in scene units. Mesh: interpolated between those of the file's
  vertices; of OBJ files, whose v runs upwards, 1 - v is taken. Where a file has none, the corners of each triangle
  have (0, 0), (1, 0) and (0, 1). Box: one whole texture a face; u runs along +z on the face at max.x and along -z at
  min.x, along -x at max.z and along +x on the others; v runs along -y on the sides, along -z on the top and along +z
  on the bottom. Convex: u = p.t, v = p.b in the frame of each facet's normal, in scene units. Rectangle: from 0 to 1
  along `u` and `v`. Disk: u is the angle in turns, as on the upper cap of a cylinder, v the distance from the middle
  over `radius`.
"""

ALIASES = """## Other spellings

Files in circulation spell their extensions in many ways. Besides the spellings below, a key that differs from ours
only in case, blanks, hyphens or underscores is understood. Everything understood is told in a note.
"""


def reference_page():
    """Return docs/scene-format.md."""
    parts = [HEAD]
    for record in RECORDS:
        parts.append(f"## {TITLES.get(record.__name__, f'Shape `{record.__name__.lower()}`')}\n\n{record.__doc__}\n")
        parts.append(_key_table(record))
    return "\n".join([*parts, CONVENTIONS, PATHS, ALIASES, _alias_table(), _left_out_table()])


def _table(head, rows):
    """Return a Markdown table."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def _key_table(record):
    rows = []
    for name, key in record.keys.items():
        default = "required" if key.required else _told(key.default)
        rows.append((f"`{name}`", key.kind.words(), key.unit or "-", default, key.description))
    return _table(("key", "value", "unit", "default", "meaning"), rows)


def _told(default):
    """Return a default value as a file would say it."""
    if isinstance(default, schema.Material):
        return "all defaults"
    return "none" if default is None else f"`{json.dumps(_plain(default))}`"


def _plain(value):
    """Return a default with lists for tuples and whole numbers without a fraction."""
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _alias_table():
    rows = [(where, f"`{spelling}`", f"`{ours}`")
            for where, renames in aliases.RENAMED.items() for spelling, ours in renames.items()]
    rows += [("file", f"rendermode `{spelling}`", f"rendermode `{ours}`") for spelling, ours in aliases.MODES.items()]
    rows += [("light", f"type `{spelling}`", f"type `{ours}`") for spelling, ours in aliases.LIGHT_TYPES.items()]
    rows += [("shape", f"type `{spelling}`", f"type `{ours}`") for spelling, ours in aliases.SHAPE_TYPES.items()]
    return _table(("where", "spelling", "understood as"), rows + list(aliases.STRUCTURAL))


def _left_out_table():
    rows = [("camera", "`aperture` in other places", ANY_APERTURE), ("light `arealight`", "`size` alone", SIZE_ALONE),
            ("material", "any other `brdfType`", NO_BRDF)]
    for where, words in aliases.UNRENDERED.items():
        rows += [(where, _coded(names), why) for why, names in _by_reason(words).items()]
    left_out = _by_reason(aliases.SHAPES_LEFT_OUT)
    rows += [("shape", f"type {_coded(names)}", f"left out: {why}") for why, names in left_out.items()]
    head = "These are recognised, but not rendered; the rest of the scene is (with `--strict`, they are mistakes):\n\n"
    return head + _table(("where", "spelling", "what happens"), rows)


def _by_reason(words):
    """Return {reason: names} of {name: reason}."""
    reasons = {}
    for name, why in words.items():
        reasons.setdefault(why, []).append(name)
    return reasons


def _coded(names):
    return ", ".join(f"`{name}`" for name in names)


def schema_json():
    """Return the JSON Schema (draft 2020-12) of scene files, as text."""
    definitions = {record.__name__: _definition(record) for record in RECORDS}
    top = definitions.pop("Scene")
    top["properties"] = {"$schema": {"type": "string"}} | top["properties"]
    document = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "Scene", **top,
                "$defs": definitions}
    return json.dumps(document, indent=1) + "\n"


def _definition(record):
    """Return the schema of one record."""
    properties = {}
    for name, key in record.keys.items():
        unit = f" ({key.unit})" if key.unit else ""
        described = {**key.kind.json_schema(), "description": key.description + unit}
        if not key.required and key.default is not None and not isinstance(key.default, schema.Material):
            described["default"] = _plain(key.default)
        properties[name] = described
    made = {"description": record.__doc__, "type": "object", "properties": properties, "additionalProperties": False}
    required = [name for name, key in record.keys.items() if key.required]
    if record in schema.EXACTLY_ONE:
        made["oneOf"] = [{"required": [name]} for name in schema.EXACTLY_ONE[record]]
    return made | ({"required": required} if required else {})


def write(folder):
    """Write the page and the schema into the folder `docs`."""
    (Path(folder) / "scene-format.md").write_text(reference_page(), encoding="utf-8")
    (Path(folder) / "scene.schema.json").write_text(schema_json(), encoding="utf-8")


if __name__ == "__main__":
    write(Path(__file__).parents[2] / "docs")
