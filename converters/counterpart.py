"""A scene of the description in Mitsuba's hands: camera rays, and what they meet, in the scene format's terms.

Mitsuba finds the intersections and looks up textures; `converters.whitted` adds the shading rules.
"""

from __future__ import annotations

from types import SimpleNamespace

import drjit as dr
import mitsuba as mi

if mi.variant() is None:
    mi.set_variant("llvm_ad_rgb")

from converters import cameras  # noqa: E402
from converters.geometry import frame, unit  # noqa: E402
from converters.mitsuba.as_dict import dictionary, part_object, soup_object, texture_object  # noqa: E402
from converters.mitsuba.lamps import environment  # noqa: E402
from converters.nesting import outside_indices  # noqa: E402
from converters.phong_lights import lights  # noqa: E402
from converters.solids import parts  # noqa: E402

ATTRIBUTES = ("face_shape", "face_part")  # carried by every primitive; a soup has values for each triangle
SOUP = 64  # triangles; more of them become one mesh, because Mitsuba's kernels grow with the number of shapes


class Counterpart:
    """A scene in Mitsuba's hands: its objects stay alive as long as this does, as Mitsuba requires."""

    def __init__(self, loaded, offset):
        """Hold a loaded scene; `offset` is how far from its surface a secondary ray starts, see `whitted.OFFSET`."""
        self.offset = offset
        world = loaded.description.scene
        self.description, self.camera = loaded.description, loaded.description.camera
        self.numbers, self.shapes = [n for n, _ in loaded.shapes], [s for _, s in loaded.shapes]
        self._background, self.ambient = mi.Color3f(world.backgroundcolor), mi.Color3f(world.ambientlight)
        self.lights = lights(world)
        around = environment(loaded)
        self._environment = mi.load_dict(dictionary(around)) if around else None
        self._parts = [parts(shape, loaded.resolve) for shape in self.shapes]
        self._textures, self._texture_of = self._texture_tables(loaded)
        self._tables = self._material_tables() if self.shapes else {}
        self.scene = mi.load_dict({"type": "scene", **self._objects()}) if self.shapes else None
        self.sensor = mi.load_dict(self._sensor())

    def _objects(self):
        """Return the primitives, each carrying the number of its shape and of its part as attributes."""
        sheets = [k for k, shape in enumerate(self.shapes) if shape.type == "triangle"]
        result = {}
        if len(sheets) > SOUP:
            meshes = [self._parts[k][0].mesh for k in sheets]
            result["soup"] = soup_object(meshes, dict(zip(ATTRIBUTES, (sheets, [0] * len(sheets)))))
        alone = [k for k, shape in enumerate(self.shapes) if not result or shape.type != "triangle"]
        return result | {f"s{k}{part.name}": part_object(part, dict(zip(ATTRIBUTES, map(float, (k, j)))))
                         for k in alone for j, part in enumerate(self._parts[k])}

    def _texture_tables(self, loaded):
        """Return the different textures, and for each shape which of them it has, or their number where it has none."""
        keys = [(m.texture, m.texturefilter, m.texturewrap, m.scaleU, m.scaleV) if m.texture is not None else None
                for m in (shape.material for shape in self.shapes)]
        first = {key: shape.material for key, shape in zip(keys, self.shapes) if key}
        place = {key: k for k, key in enumerate(first)}
        return [texture_object(loaded, m) for m in first.values()], [place.get(key, len(first)) for key in keys]

    def _sensor(self):
        """Return the camera's dictionary, a pinhole in the place of a lens."""
        film = {"type": "hdrfilm", "width": self.camera.width, "height": self.camera.height, "rfilter": {"type": "box"}}
        kind, parameters = cameras.sensor(self.camera, with_lens=False)
        return {"type": kind, **parameters, "to_world": mi.ScalarTransform4f(parameters["to_world"]), "film": film}

    def _material_tables(self):
        """Return the materials' values as arrays over shapes."""
        materials = [s.material for s in self.shapes]
        scalar = {k: mi.Float([float(getattr(m, k)) for m in materials])
                  for k in ("kd", "ks", "specularexponent", "refractiveindex")}
        colour = {k: [mi.Float([getattr(m, k)[c] for m in materials]) for c in range(3)]
                  for k in ("diffusecolor", "specularcolor")}
        # reflectivity counts for nothing without one of the two switches.
        share = mi.Float([m.reflectivity if m.isreflective or m.isrefractive else 0.0 for m in materials])
        glass = mi.Float([float(m.isrefractive) for m in materials])
        return {**scalar, **colour, "share": share, "glass": glass, "outside": mi.Float(outside_indices(self.shapes))}

    def background(self, direction):
        """Return what is seen in unit directions (lanes) that meet nothing."""
        if self._environment is None:
            return self._background
        si = dr.zeros(mi.SurfaceInteraction3f, dr.width(direction))
        si.wi = -direction
        return mi.Color3f(self._environment.eval(si))

    def value(self, name, hit):
        """Return a material's scalar or colour at the hits (lanes)."""
        table = self._tables[name]
        if isinstance(table, list):
            return mi.Color3f(*(dr.gather(mi.Float, column, hit.shape, hit.valid) for column in table))
        return dr.gather(mi.Float, table, hit.shape, hit.valid)

    def camera_rays(self, offset=(0.0, 0.0)):
        """Return origins and unit directions through the pixel centres, moved by `offset` pixels; row 0 is the top."""
        width, height = self.camera.width, self.camera.height
        pixel = dr.arange(mi.UInt32, width * height)
        x, y = mi.Float(pixel % width) + 0.5 + offset[0], mi.Float(pixel // width) + 0.5 + offset[1]
        ray, _ = self.sensor.sample_ray(0.0, 0.0, mi.Point2f(x / width, y / height), mi.Point2f(0.5))
        direction = mi.Vector3f(ray.d) + dr.zeros(mi.Vector3f, width * height)  # one for all, if orthographic
        if self.camera.type == "orthographic":
            return ray.o - cameras.NEAR * direction, direction
        return mi.Point3f(self.camera.position) + dr.zeros(mi.Point3f, width * height), direction

    def intersect(self, origin, direction):
        """Return the nearest hits: Mitsuba's interaction, shape and part indices, texture coordinates and albedo."""
        if self.scene is None:
            nothing = dr.full(mi.Bool, False, dr.width(direction))
            return SimpleNamespace(valid=nothing, shape=dr.zeros(mi.UInt32, dr.width(direction)))
        si = self.scene.ray_intersect(mi.Ray3f(origin, direction))
        valid = si.is_valid()
        shape, part = (mi.UInt32(si.shape.eval_attribute_1(name, si, valid) + 0.5) for name in ATTRIBUTES)
        hit = SimpleNamespace(valid=valid, si=si, t=si.t, p=si.p, n=mi.Vector3f(si.n), shape=shape, part=part,
                              n_shading=mi.Vector3f(si.sh_frame.n))
        hit.uv = self._uv(hit)
        hit.albedo = self._albedo(hit)
        return hit

    def _uv(self, hit):
        """Return the scene format's texture coordinates: Mitsuba's own, mapped as solids.py says, and a plane's."""
        uv = mi.Vector2f(hit.si.uv)
        for k, (shape, primitives) in enumerate(zip(self.shapes, self._parts)):
            if shape.type in ("triangle", "mesh"):
                continue
            here = hit.valid & (hit.shape == k)
            for number, part in enumerate(primitives):
                if part.kind != "mesh" and part.uv_map is not None:
                    rows = part.uv_map[:2].tolist()
                    mapped = [a * hit.si.uv.x + b * hit.si.uv.y + c for a, b, c in rows]
                    uv = dr.select(here & (hit.part == number), mi.Vector2f(*mapped), uv)
            if shape.type == "plane":
                d = hit.p - mi.Point3f(shape.point)
                mapped = [dr.dot(d, mi.Vector3f(*map(float, axis))) for axis in frame(unit(shape.normal))]
                uv = dr.select(here, mi.Vector2f(*mapped), uv)
        return uv

    def _albedo(self, hit):
        """Return the texture's colour, or diffusecolor where there is no texture."""
        colour = self.value("diffusecolor", hit)
        if not self._textures:
            return colour
        own = dr.gather(mi.UInt32, mi.UInt32(self._texture_of), hit.shape, hit.valid)
        for k, texture in enumerate(self._textures):
            si = mi.SurfaceInteraction3f(hit.si)
            si.uv = mi.Point2f(hit.uv)
            here = hit.valid & (own == k)
            colour = dr.select(here, mi.Color3f(texture.eval(si, here)), colour)
        return colour
