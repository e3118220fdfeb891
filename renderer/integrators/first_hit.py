"""Debug modes: what the camera ray meets first, one value a pixel, for finding mistakes in scenes and renderers."""

from __future__ import annotations

import drjit as dr

from renderer.core.backend import Float, Vector3f
from renderer.core.numeric import FAR
from renderer.core.records import NO_SHAPE

PALETTE_STEP = (0.61803399, 0.75487767, 0.5698403)  # fractions of plastic and golden ratio: neighbours differ


def channels(mode, scene, ray, hit):
    """Return {EXR channel name: lanes} of a debug mode at the rays' closest hits, and its picture, a colour in [0, 1].

    Where nothing is hit the picture is black, depth is FAR, the shape NO_SHAPE and everything else 0.
    """
    return MODES[mode](scene, hit, scene.surface(ray, hit, with_uv=mode in ("uv", "albedo")))


def _named(prefix, suffixes, values, hit):
    masked = (dr.select(hit.valid, value, 0) for value in values)
    return {prefix + suffix: value for suffix, value in zip(suffixes, masked)}


def _depth(scene, hit, surface):
    """Distance along the ray; white is nearest, and the farthest hit is dark grey."""
    nearest = dr.min(dr.select(hit.valid, hit.t, FAR))
    farthest = dr.max(dr.select(hit.valid, hit.t, 0))
    grey = 1 - 0.9 * (hit.t - nearest) / dr.select(farthest > nearest, farthest - nearest, 1)
    return {"Z": hit.t}, Vector3f(dr.select(hit.valid, grey, 0))


def _normals(scene, hit, surface):
    """Outward geometric normal; the picture shows 0.5 + 0.5 n."""
    named = _named("N.", "XYZ", surface.n_geo, hit)
    return named, dr.select(hit.valid, 0.5 + 0.5 * surface.n_geo, Vector3f(0))


def _uv(scene, hit, surface):
    """Texture coordinates before scaling; the picture shows their fractional parts as red and green."""
    u, v = surface.uv
    picture = Vector3f(u - dr.floor(u), v - dr.floor(v), 0)
    return _named("", "UV", (u, v), hit), dr.select(hit.valid, picture, Vector3f(0))


def _albedo(scene, hit, surface):
    """Diffuse colour, from the texture where there is one."""
    if scene.empty:
        return _named("Albedo.", "RGB", Vector3f(0), hit), Vector3f(0)
    colour = scene.diffuse_colour(hit, surface, scene.material(hit))
    return _named("Albedo.", "RGB", colour, hit), dr.select(hit.valid, colour, Vector3f(0))


def _shapes(scene, hit, surface):
    """Index of the shape in the file; the picture gives each a colour of its own."""
    if scene.empty:
        return {"Shape": hit.index}, Vector3f(0)
    index = dr.select(hit.valid, scene.file_index(hit), NO_SHAPE)
    turns = Vector3f(*((Float(index) + 1) * step for step in PALETTE_STEP))
    picture = 0.25 + 0.75 * (turns - dr.floor(turns))
    return {"Shape": index}, dr.select(hit.valid, picture, Vector3f(0))


MODES = {"depth": _depth, "normals": _normals, "uv": _uv, "albedo": _albedo, "shapes": _shapes}
