"""Strangers' spellings of lights and lenses, and what all translations have in common; see aliases.py."""

from __future__ import annotations

from renderer.core.vectors import frame, length
from renderer.scene import schema
from renderer.scene.aliases_mesh import folded, is_vector
from renderer.scene.findings import WARNING, quoted

THIN_LENSES = ("thinlens", "aperture", "lens")
PINHOLES = ("perspective", "pinhole")
DIAMETERS = ("diameter", "aperturesize")
ANY_APERTURE = "this may be a radius or a diameter; write apertureRadius, and type \"thinlens\""
SIZE_ALONE = "left out: a size does not say where an area light faces; give its edges u and v"


def undecided(light):
    """Return why a light is left out whose place cannot be told from its keys, None if it can."""
    names = {folded(name) for name in light}
    told = {"u", "uaxis", "edge1", "normal", "corner"} & names
    area = type(light.get("type")) is str and folded(light["type"]) in ("area", "arealight")
    return SIZE_ALONE if area and "size" in names and not told else None


class LightSpellings:
    """The part of a translation that knows lights and lenses."""

    def _light(self, light, path):
        strength, colour = light.get("intensity"), light.get("color")
        if type(strength) in (int, float) and (colour is None or is_vector(colour)):
            self._note((*path, "intensity"), "understood one number as the same in every channel"
                                             + (", times color" if colour is not None else ""))
            light["intensity"] = [strength * channel for channel in light.pop("color", [1.0, 1.0, 1.0])]
        record = schema.LIGHT_KINDS.get(light.get("type")) if type(light.get("type")) is str else None
        self._keys(light, path, "light", record.node.keys if record else schema.PointLight.keys)
        if light.get("type") == "arealight":
            self._area(light, path)

    def _area(self, light, path):
        """Understand an area light whose place is given by a corner, by directions and sizes, or by a normal."""
        plain = {folded(name): name for name in light}
        vectors = {name: light[key] for name, key in plain.items() if is_vector(light[key])}
        if {"corner", "edge1", "edge2"} <= vectors.keys():
            corner, u, v = (vectors[name] for name in ("corner", "edge1", "edge2"))
            middle = [c + 0.5 * (a + b) for c, a, b in zip(corner, u, v)]
            self._placed(light, path, [plain[name] for name in ("corner", "edge1", "edge2")], middle, u, v)
            return
        sizes = [light.get(plain.get(name)) for name in ("width", "height")]
        given = [size for size in sizes if size is not None]
        if not given or not all(type(size) in (int, float) for size in given) or "position" not in vectors:
            return
        width, height = (1.0 if size is None else size for size in sizes)
        axes = (vectors.get("u"), vectors.get("v"))
        if "normal" in vectors and not any(axes) and any(vectors["normal"]):
            axes = frame([x / length(vectors["normal"]) for x in vectors["normal"]])
        if all(axis is not None and any(axis) for axis in axes):
            u, v = ([x * size / length(axis) for x in axis] for axis, size in zip(axes, (width, height)))
            used = [plain[name] for name in ("width", "height", "normal") if name in plain]
            self._placed(light, path, used, vectors["position"], u, v)

    def _placed(self, light, path, used, position, u, v):
        """Give an area light its place instead of the keys in `used`."""
        origin = self._original((*path, used[0]))
        for name in used:
            self._note((*path, name), f"understood {quoted(name)} as part of position, u and v")
            del light[name]
        for name, value in (("position", position), ("u", u), ("v", v)):
            if light.get(name) != value:
                self.moved.setdefault((*path, name), origin)
                light[name] = value

    def _lens(self, camera, path):
        """Understand a lens by its type, its radius or its diameter."""
        kind = camera.get("type")
        if type(kind) is str and kind not in ("pinhole", "thinlens"):
            new = "thinlens" if folded(kind) in THIN_LENSES else "pinhole" if folded(kind) in PINHOLES else None
            if new:
                self._note((*path, "type"), f"understood camera type {quoted(kind)} as {new}", anchor="value")
                camera["type"] = new
        before = "apertureRadius" in camera
        focus_like_d = "focusdistance" in camera  # where that spelling is found, `aperture` is the lens's diameter
        for name in [name for name in camera if name not in schema.Camera.keys]:
            plain = folded(name)
            diameter = plain in DIAMETERS or plain == "aperture" and focus_like_d
            if "apertureRadius" in camera or not (diameter or plain == "aperture"):
                continue
            if not diameter and camera.get("type") != "thinlens":
                self._note((*path, name), ANY_APERTURE, WARNING)
                del camera[name]
            else:
                told = "apertureRadius, which is half of it" if diameter else None
                self._move((path, camera), name, (path, camera), "apertureRadius", told)
                if diameter and type(camera["apertureRadius"]) in (int, float):
                    camera["apertureRadius"] /= 2
        self._keys(camera, path, "camera", schema.Camera.keys)
        radius = camera.get("apertureRadius")
        if not before and type(radius) in (int, float) and radius > 0 and camera.get("type", "pinhole") == "pinhole":
            self._note((*path, "apertureRadius"), 'understood a camera with a lens as type "thinlens"')
            camera["type"] = "thinlens"
