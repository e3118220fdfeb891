"""The exact counterpart of the binary, phong and debug modes, through Mitsuba's Python interface.

Mitsuba finds the intersections, knows Fresnel's equations and looks up textures; the shading rules are written here
from the scene format's definition. Nothing is shared with `renderer`.
Stock Mitsuba has neither lights without fall-off nor Blinn-Phong, hence a loop of our own over a wavefront of rays.

Normals to shade with are those of the vertices, interpolated, where a mesh has them and they face the viewer; else the
surface's own. On which side of a surface a ray goes on is decided by the surface's own normal, always.
Secondary rays start a little off the surface (OFFSET). Along contact lines of two shapes, and within that distance of
a shadow's start, the picture therefore differs from one with exact offsets.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from converters.counterpart import Counterpart

NO_SHAPE = 0xFFFFFFFF
# How far from its surface a secondary ray starts, relative to 1 + the greatest coordinate or distance. Mitsuba's own
# 9e-5 shows in curved mirrors and glass; errors fall in proportion down to 2e-6, where surfaces shadow themselves.
OFFSET = 3e-6
NEGLIGIBLE = 1e-7  # a ray that contributes less than this share of its pixel is not followed
UNCERTAIN = 1e-3  # pixels: how far a ray may be off by rounding of the camera's frame and of float32 directions
EDGE_ANGLE = 0.05  # difference of unit normals within UNCERTAIN from which a pixel sees an edge


def _start(counterpart, hit, direction):
    """Return where rays of the given directions start: at the hit, moved off the surface to the ray's side."""
    # The coordinates and the distance travelled both bound the rounding of the hit point.
    distance = counterpart.offset * (1 + dr.maximum(dr.max(dr.abs(hit.p)), hit.t))
    return mi.Point3f(hit.p + dr.mulsign(mi.Vector3f(hit.n), dr.dot(hit.n, direction)) * distance)


def _facing(hit, to_viewer):
    """Return the normals to shade with, turned to the viewer, and whether he is inside."""
    inside = dr.dot(hit.n, to_viewer) < 0
    shading = dr.select(inside, -hit.n_shading, hit.n_shading)
    own = dr.select(inside, -hit.n, hit.n)
    return dr.select(dr.dot(shading, to_viewer) > 0, shading, own), inside


def _shadow_ray(counterpart, hit, light):
    """Return the rays to a light, which end short of it."""
    start = _start(counterpart, hit, light.direction(hit.p)[0])
    direction, distance = light.direction(start)
    if distance is None:
        return mi.Ray3f(start, direction)
    return mi.Ray3f(start, direction, distance * (1 - counterpart.offset), 0.0, [])


def _local_shading(counterpart, hit, normal, to_viewer):
    """Return the light reflected towards the viewer without mirror and glass; `normal` faces the viewer."""
    kd, ks = counterpart.value("kd", hit), counterpart.value("ks", hit)
    exponent, specular = counterpart.value("specularexponent", hit), counterpart.value("specularcolor", hit)
    result = counterpart.ambient * hit.albedo
    for light in counterpart.lights:
        to_light, _ = light.direction(hit.p)
        half = dr.normalize(to_light + to_viewer)
        cosine = dr.dot(normal, to_light)
        lit = hit.valid & (cosine > 0)
        lit &= ~counterpart.scene.ray_test(_shadow_ray(counterpart, hit, light), lit)
        # power(0, 0) is NaN in Dr.Jit, whereas an exponent of 0 means a constant highlight.
        highlight = dr.power(dr.maximum(dr.dot(normal, half), 1e-8), exponent)
        term = kd * hit.albedo * cosine + ks * specular * highlight
        result += dr.select(lit, term * light.brightness(to_light), 0)
    return result


def _radiance(counterpart, moved=(0.0, 0.0)):
    """Return (H, W, 3) float64 linear colour of the phong mode, one ray through each pixel centre moved by pixels."""
    origin, direction = counterpart.camera_rays(moved)
    width = dr.width(direction)
    out = [dr.zeros(mi.Float, width) for _ in range(3)]
    weight, pixel = mi.Color3f(dr.full(mi.Float, 1, width)), dr.arange(mi.UInt32, width)

    def add(mask, value):
        for channel, component in zip(out, value):
            dr.scatter_reduce(dr.ReduceOp.Add, channel, component, pixel, mask)

    bounces = counterpart.description.nbounces
    for depth in range(bounces + 1):
        hit = counterpart.intersect(origin, direction)
        add(~hit.valid, weight * counterpart.background(direction))
        if counterpart.scene is None:
            break
        to_viewer = -direction
        normal, inside = _facing(hit, to_viewer)
        share = counterpart.value("share", hit)
        add(hit.valid & (share < 1), weight * (1 - share) * _local_shading(counterpart, hit, normal, to_viewer))
        if depth == bounces:
            mirrored = 2 * dr.dot(normal, to_viewer) * normal - to_viewer
            add(hit.valid & (share > 0), weight * share * counterpart.background(mirrored))
            break
        branches = _branches(counterpart, hit, normal, inside, to_viewer, weight * share, pixel)
        dr.eval(out)
        if branches is None:
            break
        origin, direction, weight, pixel = branches
    dr.eval(out)
    size = counterpart.camera.height, counterpart.camera.width
    return np.stack([np.array(channel, dtype=np.float64).reshape(size) for channel in out], axis=-1)


def _branches(counterpart, hit, normal, inside, to_viewer, weight, pixel):
    """Return origins, directions, weights and pixels of the reflected and refracted rays that matter, or None."""
    eta = counterpart.value("refractiveindex", hit) / counterpart.value("outside", hit)
    eta = dr.select(inside, 1 / eta, eta)  # index ahead over index behind
    cosine = dr.dot(normal, to_viewer)
    glass = counterpart.value("glass", hit) > 0
    fresnel = dr.select(glass, mi.fresnel(cosine, eta)[0], 1)
    cosine_in = dr.sqrt(dr.maximum(1 - (1 - cosine * cosine) / (eta * eta), 0))
    reflected = 2 * cosine * normal - to_viewer
    refracted = normal * (cosine / eta - cosine_in) - to_viewer / eta
    kept = []
    both = (hit.valid, reflected, weight * fresnel), (hit.valid & glass, refracted, weight * (1 - fresnel))
    for mask, ahead, share in both:
        index = dr.compress(mask & (dr.max(share) > NEGLIGIBLE))
        if len(index):
            start = _start(counterpart, hit, ahead)
            kept.append((dr.gather(mi.Point3f, start, index), dr.gather(mi.Vector3f, mi.Vector3f(ahead), index),
                         dr.gather(mi.Color3f, mi.Color3f(share), index), dr.gather(mi.UInt32, pixel, index)))
    if len(kept) < 2:
        return kept[0] if kept else None
    joined = tuple(type(a)(*(dr.concat([a[c], b[c]]) for c in range(3))) for a, b in zip(kept[0][:3], kept[1][:3]))
    joined = (*joined, dr.concat([kept[0][3], kept[1][3]]))
    dr.eval(joined)
    return joined


def first_hits(loaded, offset=(0.0, 0.0)):
    """Return what the camera sees first, a dict of (H, W[, 3]) arrays; rays may be moved by `offset` pixels.

    `hit` (bool), `depth` (scene units along the unit ray), `normal` (outward, geometric), `uv`, `albedo` (linear),
    `shape` (uint32, index in the file, NO_SHAPE where nothing is hit), `part` (uint32, primitive within the shape).
    """
    counterpart = Counterpart(loaded, OFFSET)
    return _first_hits(counterpart, offset)


def _first_hits(counterpart, offset):
    """Return the arrays of `first_hits` of a Counterpart."""
    hit = counterpart.intersect(*counterpart.camera_rays(offset))
    size = (counterpart.camera.height, counterpart.camera.width)
    mask = np.array(hit.valid).reshape(size)
    numbers = np.array([*counterpart.numbers, NO_SHAPE], dtype=np.uint32)
    shape = numbers[np.where(mask, np.array(hit.shape).reshape(size), len(numbers) - 1)]
    result = {"hit": mask, "shape": shape}
    names = {"depth": ("t", 1), "normal": ("n", 3), "uv": ("uv", 2), "albedo": ("albedo", 3), "part": ("part", 1)}
    for name, (attribute, channels) in names.items():
        where = mask if channels == 1 else mask[..., None]
        if counterpart.scene is None:
            result[name] = np.zeros(size if channels == 1 else (*size, channels))
            continue
        value = np.array(getattr(hit, attribute))
        value = value.reshape(size) if channels == 1 else value.T.reshape(*size, channels)
        result[name] = np.where(where, value, 0)
    return result


def reference(loaded, mode=None):
    """Return Mitsuba's version of the scene: first_hits' arrays, and in binary and phong mode `rgb` (H, W, 3) linear.

    `mode` overrides the scene's; binary is red (1, 0, 0) where something is hit.
    """
    counterpart = Counterpart(loaded, OFFSET)
    mode = mode or loaded.description.rendermode
    result = _first_hits(counterpart, (0.0, 0.0))
    if mode == "binary":
        result["rgb"] = result["hit"][..., None] * np.array([1.0, 0.0, 0.0])
    elif mode == "phong":
        result["rgb"] = _radiance(counterpart)
    return result


CORNERS = ((-1, -1), (1, -1), (-1, 1), (1, 1))


def neighbours(loaded, eps_px=UNCERTAIN):
    """Return first_hits for rays moved by `eps_px` towards the four corners of the pixel: what rounding may do."""
    counterpart = Counterpart(loaded, OFFSET)
    return [_first_hits(counterpart, (x * eps_px, y * eps_px)) for x, y in CORNERS]


def mask_uncertain(loaded, eps_px=UNCERTAIN, edges=False):
    """Return (H, W) bool: pixels whose shape is not the same for all rays within `eps_px` of their centre.

    With `edges` also those that see an edge within one shape (another primitive, or a bent normal).
    """
    centre = first_hits(loaded)
    uncertain = np.zeros(centre["hit"].shape, dtype=bool)
    for moved in neighbours(loaded, eps_px):
        uncertain |= moved["shape"] != centre["shape"]
        if edges:
            uncertain |= moved["part"] != centre["part"]
            uncertain |= np.abs(moved["normal"] - centre["normal"]).max(axis=-1) > EDGE_ANGLE
    return uncertain


def colour_uncertainty(loaded, eps_px=UNCERTAIN):
    """Return (H, W): how much the phong colour changes for rays within `eps_px`, and for secondary rays that start
    three times as far off their surface. Where this is large, Mitsuba's colour decides nothing.
    """
    exact, far = Counterpart(loaded, OFFSET), Counterpart(loaded, 3 * OFFSET)
    centre = _radiance(exact)
    varied = [_radiance(far), *(_radiance(exact, (x * eps_px, y * eps_px)) for x, y in CORNERS)]
    return np.abs(np.array(varied) - centre).max(axis=(0, -1))
