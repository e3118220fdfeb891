"""Strangers' spellings of materials that path tracing knows; see aliases.py."""

from __future__ import annotations

from renderer.scene.aliases_mesh import folded, is_vector
from renderer.scene.findings import WARNING, quoted
from renderer.scene.materials import Material

LAMBERTIAN = ("lambertian", "lambert", "diffuse")
NO_BRDF = "this version has no such BRDF; see bsdf"


class MaterialSpellings:
    """The part of a translation that knows emission and foreign BRDFs."""

    def _emission(self, shape, material, path):
        """Move the emission of a material to its shape."""
        inner = (*path, "material")
        for name in [name for name in material if folded(name) in ("emission", "emissioncolor", "emissive")]:
            if "emission" not in shape:
                self._move((inner, material), name, (path, shape), "emission", "emission of the shape")
        if type(shape.get("emission")) in (int, float):
            self._note((*path, "emission"), "understood one number as the same in every channel")
            shape["emission"] = [shape["emission"]] * 3

    def _brdf(self, material, path):
        """Understand a metallic material as principled, and a Lambertian one as diffuse."""
        plain = {folded(name): name for name in material}
        colour = material.get("texture") or material.get("diffusecolor") or list(Material.defaults["diffusecolor"])
        usable = not is_vector(colour) or all(0 <= x <= 1 for x in colour)
        metallic, kind = plain.get("metallic"), plain.get("brdftype")
        if metallic and "bsdf" not in material and usable:
            own = {name: material[name] for name in ("roughness",) if name in material}
            self._bsdf(material, metallic, path, {"type": "principled", "basecolor": colour,
                                                  "metallic": material[metallic], **own})
        elif kind and "bsdf" not in material:
            word = material[kind]
            if type(word) is str and folded(word) in LAMBERTIAN and usable:
                self._bsdf(material, kind, path, {"type": "diffuse", "reflectance": colour})
            else:
                self._note((*path, kind), NO_BRDF, WARNING)
                del material[kind]

    def _bsdf(self, material, name, path, bsdf):
        """Replace a key by a BSDF."""
        self._note((*path, name), f"understood {quoted(name)} as bsdf {quoted(bsdf['type'])}")
        origin = self._original((*path, name))
        self.moved[(*path, "bsdf")] = origin
        for key in bsdf:
            source = {"basecolor": "diffusecolor", "reflectance": "diffusecolor"}.get(key, key)
            there = self._original((*path, source)) if source in material else origin
            self.moved[(*path, "bsdf", key)] = origin if key == "metallic" else there
        del material[name]
        material["bsdf"] = bsdf
