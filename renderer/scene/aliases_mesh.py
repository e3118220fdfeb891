"""Strangers' spellings of meshes, and what all translations have in common; see aliases.py."""

from __future__ import annotations

from renderer.scene.findings import quoted

MESH_FILES = ("path", "file", "mesh", "model", "obj", "ply")


def folded(name):
    """Return a spelling without case, blanks, hyphens and underscores."""
    return name.lower().replace("_", "").replace("-", "").replace(" ", "")


def is_vector(value):
    """Return whether a value is a list of three numbers."""
    return type(value) is list and len(value) == 3 and all(type(x) in (int, float) for x in value)


class MeshSpellings:
    """The part of a translation that knows meshes."""

    def _mesh(self, shape, path):
        """Understand a mesh whose place is given by an offset, a scale and angles instead of steps."""
        plain = {folded(name): name for name in shape}
        for name in MESH_FILES:
            if name in plain and "filename" not in shape:
                self._move((path, shape), plain[name], (path, shape), "filename", None)
        steps = shape.get("transform", [])
        if type(steps) is list:
            for name, made in (("scale", _scale_steps), ("euler", _euler_steps), ("offset", _offset_steps)):
                added = made(shape.get(plain.get(name)))
                for step in added:
                    self.moved[(*path, "transform", len(steps))] = self._original((*path, plain[name]))
                    steps.append(step)
                if added:
                    self._note((*path, plain[name]), f"understood {quoted(plain[name])} as a step of transform")
                    self.moved.setdefault((*path, "transform"), self._original((*path, plain[name])))
                    del shape[plain[name]]
                    shape["transform"] = steps
        name, material = plain.get("texturescale"), shape.get("material", {})
        scales = shape.get(name)
        scales = [scales] * 2 if type(scales) in (int, float) else scales
        if type(scales) is list and len(scales) == 2 and type(material) is dict:
            self._note((*path, name), f"understood {quoted(name)} as material.scaleU and scaleV")
            for key, scale in zip(("scaleU", "scaleV"), scales, strict=True):
                self.moved[(*path, "material", key)] = self._original((*path, name))
                material.setdefault(key, scale)
            shape["material"] = material
            del shape[name]


def _scale_steps(value):
    """Return the steps of a foreign mesh's scale: one number or three; none for what is neither."""
    return [{"scale": value}] if type(value) in (int, float) or is_vector(value) else []


def _euler_steps(value):
    """Return the steps of angles in degrees around x, y and z, in this order."""
    axes = [1, 0, 0], [0, 1, 0], [0, 0, 1]
    return [{"rotate": {"axis": axis, "angle": angle}} for axis, angle in zip(axes, value)] if is_vector(value) else []


def _offset_steps(value):
    """Return the step of an offset."""
    return [{"translate": value}] if is_vector(value) else []
