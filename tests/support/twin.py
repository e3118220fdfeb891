"""A slow float64 renderer in numpy: the third opinion when the renderer and Mitsuba disagree.

Independent of both: closed-form intersections, one array operation a step, recursion for mirrors and glass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image
from scipy.spatial import ConvexHull

T_MIN = 1e-7  # scene units: a ray does not hit the surface it starts from
INSIDE_SLACK = 1e-6  # scene units
POINTS = 3000  # random surface points that decide whether one shape contains another
MISS = -1


def _unit(v):
    """Return vectors (..., 3) at length 1."""
    return np.asarray(v, float) / np.linalg.norm(v, axis=-1, keepdims=True)


def _frame(n):
    """Return the scene format's two axes beside a unit normal."""
    t = _unit(np.cross(n, [0.0, 1, 0] if abs(n[1]) < 0.9 else [0.0, 0, 1]))
    return t, np.cross(n, t)


def _dot(a, b):
    """Return the dot products of vectors (..., 3)."""
    return (np.asarray(a) * b).sum(axis=-1)


def halfspaces(shape):
    """Return unit normals (H, 3) and offsets (H,) of a box or convex shape."""
    if shape.type == "box":
        return np.concatenate([np.eye(3), -np.eye(3)]), np.concatenate([shape.max, np.negative(shape.min)])
    if shape.vertices is not None:
        equations = ConvexHull(np.array(shape.vertices)).equations
        return equations[:, :3], -equations[:, 3]
    rows = np.array(shape.halfspaces, float)
    length = np.linalg.norm(rows[:, :3], axis=1)
    return rows[:, :3] / length[:, None], rows[:, 3] / length


def _first_beyond(candidates):
    """Return the least t > T_MIN among (K, N) candidates, inf where there is none."""
    candidates = np.where(candidates > T_MIN, candidates, np.inf)
    return candidates.min(axis=0)


def _sphere(s, o, d):
    """Return t, outward normal and uv of rays at a sphere; so do the functions below."""
    b, c = _dot(o - s.center, d), _dot(o - s.center, o - s.center) - s.radius**2
    root = np.sqrt(b * b - c)
    t = _first_beyond(np.stack([-b - root, -b + root]))
    n = (o + np.where(np.isfinite(t), t, 0)[:, None] * d - s.center) / s.radius
    uv = np.stack([np.arctan2(n[:, 2], n[:, 0]) / (2 * np.pi) % 1, np.arccos(np.clip(n[:, 1], -1, 1)) / np.pi], -1)
    return t, n, uv


def _cylinder(s, o, d):
    """See `_sphere`: side and caps, whichever comes first."""
    a = _unit(np.array(s.axis, float))
    t1, t2 = _frame(a)
    local = np.stack([(o - s.center) @ v for v in (t1, t2, a)], -1)
    ld = np.stack([d @ v for v in (t1, t2, a)], -1)
    qa, qb = _dot(ld[:, :2], ld[:, :2]), _dot(local[:, :2], ld[:, :2])
    root = np.sqrt(qb * qb - qa * (_dot(local[:, :2], local[:, :2]) - s.radius**2))
    side = np.stack([(-qb - root) / qa, (-qb + root) / qa])
    side = np.where(np.abs(local[:, 2] + side * ld[:, 2]) <= s.height, side, np.inf)
    caps = np.stack([(h - local[:, 2]) / ld[:, 2] for h in (s.height, -s.height)])
    rho = np.hypot(*[local[:, k] + caps * ld[:, k] for k in (0, 1)])
    caps = np.where(rho <= s.radius, caps, np.inf)
    t = _first_beyond(np.concatenate([side, caps]))
    p = local + np.where(np.isfinite(t), t, 0)[:, None] * ld
    on_cap = _first_beyond(caps) <= _first_beyond(side)
    radial = (p[:, :1] * t1 + p[:, 1:2] * t2) / s.radius
    n = np.where(on_cap[:, None], np.sign(p[:, 2:]) * a, radial)
    v = np.where(on_cap, np.hypot(p[:, 0], p[:, 1]) / s.radius, (s.height - p[:, 2]) / (2 * s.height))
    return t, n, np.stack([np.arctan2(-p[:, 1], p[:, 0]) / (2 * np.pi) % 1, v], -1)


def _triangle(s, o, d):
    """See `_sphere`: barycentric coordinates by cross products."""
    v0, v1, v2 = (np.array(v, float) for v in (s.v0, s.v1, s.v2))
    e1, e2 = v1 - v0, v2 - v0
    n = np.cross(e1, e2)
    t = -((o - v0) @ n) / (d @ n)
    p = o + np.where(np.isfinite(t), t, 0)[:, None] * d - v0
    b1, b2 = np.cross(p, e2) @ n / (n @ n), np.cross(e1, p) @ n / (n @ n)
    t = np.where((b1 >= 0) & (b2 >= 0) & (b1 + b2 <= 1) & (t > T_MIN), t, np.inf)
    uv = (1 - b1 - b2)[:, None] * s.uv0 + b1[:, None] * s.uv1 + b2[:, None] * s.uv2
    return t, np.broadcast_to(_unit(n), d.shape), uv


def _plane(s, o, d):
    """See `_sphere`: uv are distances from the plane's point."""
    n = _unit(np.array(s.normal, float))
    t = -((o - s.point) @ n) / (d @ n)
    t = np.where(t > T_MIN, t, np.inf)
    p = o + np.where(np.isfinite(t), t, 0)[:, None] * d - s.point
    return t, np.broadcast_to(n, d.shape), np.stack([p @ v for v in _frame(n)], -1)


def _convex(s, o, d):
    """See `_sphere`: a box or convex volume, between the last way in and the first way out."""
    normals, offsets = halfspaces(s)
    speed, gap = d @ normals.T, offsets - o @ normals.T
    crossing = gap / speed
    enter = np.where(speed < 0, crossing, np.where((speed == 0) & (gap < 0), np.inf, -np.inf))
    leave = np.where(speed > 0, crossing, np.inf)
    near, far = enter.max(axis=1), leave.min(axis=1)
    outside = near > T_MIN
    facet = np.where(outside, enter.argmax(axis=1), leave.argmin(axis=1))
    t = np.where((near <= far) & (far > T_MIN), np.where(outside, near, far), np.inf)
    n, p = normals[facet], o + np.where(np.isfinite(t), t, 0)[:, None] * d
    if s.type == "box":
        x, y, z = ((p - s.min) / np.subtract(s.max, s.min)).T
        on, sign = np.abs(normals).argmax(-1)[facet], normals.sum(-1)[facet]
        u = np.where(on == 0, np.where(sign > 0, z, 1 - z), np.where((on == 2) & (sign > 0), 1 - x, x))
        uv = np.stack([u, np.where(on == 1, np.where(sign > 0, 1 - z, z), 1 - y)], -1)
    else:
        frames = np.array([_frame(v) for v in normals])
        uv = np.einsum("rk,rak->ra", p, frames[facet])
    return t, n, uv


_INTERSECT = {"sphere": _sphere, "cylinder": _cylinder, "triangle": _triangle, "plane": _plane, "box": _convex,
              "convex": _convex}


def _contains(shape, p):
    """Return whether points (N, 3) lie in a closed shape."""
    if shape.type == "sphere":
        return np.linalg.norm(p - shape.center, axis=1) <= shape.radius + INSIDE_SLACK
    if shape.type == "cylinder":
        along = (p - shape.center) @ _unit(np.array(shape.axis, float))
        beside = np.linalg.norm(np.cross(p - shape.center, _unit(np.array(shape.axis, float))), axis=1)
        return (np.abs(along) <= shape.height + INSIDE_SLACK) & (beside <= shape.radius + INSIDE_SLACK)
    if shape.type in ("triangle", "plane"):
        return np.zeros(len(p), bool)
    normals, offsets = halfspaces(shape)
    return (p @ normals.T <= offsets + INSIDE_SLACK).all(axis=1)


def _middle(shape):
    """Return a point inside a closed shape; half-spaces of tests contain the origin."""
    if shape.type in ("sphere", "cylinder"):
        return shape.center
    if shape.type == "box":
        return np.add(shape.min, shape.max) / 2
    return np.mean(shape.vertices, axis=0) if shape.vertices is not None else (0.0, 0.0, 0.0)


@dataclass
class Hits:
    """What rays met: arrays over hits."""

    p: np.ndarray  # (N, 3)
    n: np.ndarray  # (N, 3), turned to the viewer
    wo: np.ndarray  # (N, 3), unit, to the viewer
    inside: np.ndarray  # (N,), whether the viewer is
    index: np.ndarray  # (N,), of the shape in the list
    uv: np.ndarray  # (N, 2)
    materials: list  # of all shapes

    def of(self, name):
        """Return a parameter of the materials that were met, (N[, 3])."""
        return np.array([getattr(m, name) for m in self.materials], float)[self.index]


class Twin:
    """The scene, ready to be traced one ray through each pixel centre."""

    def __init__(self, loaded):
        self.loaded, self.world = loaded, loaded.description.scene
        self.shapes = [s for _, s in loaded.shapes]
        self.images = {k: np.asarray(Image.open(loaded.resolve(s.material.texture)).convert("RGB")) / 255.0
                       for k, s in enumerate(self.shapes) if isinstance(s.material.texture, str)}
        self.outside = [self._outside(k) for k in range(len(self.shapes))]

    def _surface_points(self, shape):
        """Return points on a closed shape, found by shooting rays from far away at its middle."""
        if shape.type in ("triangle", "plane"):
            return None
        rng = np.random.default_rng(1)
        middle = np.array(_middle(shape))
        towards = _unit(rng.normal(size=(POINTS, 3)))
        t = _INTERSECT[shape.type](shape, middle + 0 * towards, towards)[0]
        return (middle + t[:, None] * towards)[np.isfinite(t)]

    def _outside(self, k):
        """Return the index around shape k: of the refractive shape that contains its points and least of the rest."""
        shape, best, least = self.shapes[k], 1.0, np.inf
        points = self._surface_points(shape) if shape.material.isrefractive else None
        for j, other in enumerate(self.shapes):
            if j == k or points is None or not other.material.isrefractive or not _contains(other, points).all():
                continue
            around = self._surface_points(other)
            size = np.linalg.norm(around - around.mean(axis=0), axis=1).mean()
            if size < least:
                best, least = other.material.refractiveindex, size
        return best

    def camera_rays(self):
        """Return origins and unit directions, (H * W, 3), row 0 on top."""
        c = self.loaded.description.camera
        forward = _unit(np.subtract(c.lookAt, c.position))
        right = _unit(np.cross(c.upVector, forward))
        up, half = np.cross(forward, right), np.tan(np.radians(c.fov) / 2)
        row, column = np.mgrid[: c.height, : c.width] + 0.5
        x, y = (2 * column / c.width - 1) * half * c.width / c.height, (1 - 2 * row / c.height) * half
        d = _unit(forward + x[..., None] * right + y[..., None] * up).reshape(-1, 3)
        return np.broadcast_to(np.array(c.position, float), d.shape), d

    def intersect(self, o, d):
        """Return t, list index of the shape (MISS where none), outward normal and uv of the nearest hit."""
        t, index = np.full(len(d), np.inf), np.full(len(d), MISS)
        n, uv = np.zeros((len(d), 3)), np.zeros((len(d), 2))
        with np.errstate(all="ignore"):
            for k, shape in enumerate(self.shapes):
                tk, nk, uvk = _INTERSECT[shape.type](shape, o, d)
                nearer = tk < t
                t, index = np.where(nearer, tk, t), np.where(nearer, k, index)
                n, uv = np.where(nearer[:, None], nk, n), np.where(nearer[:, None], uvk, uv)
        return t, index, n, uv

    def albedo(self, index, uv):
        """Return the texture's colour or diffusecolor at the hits, (N, 3)."""
        result = np.zeros((len(index), 3))
        for k, shape in enumerate(self.shapes):
            here, m = index == k, shape.material
            scaled = uv[here] * (m.scaleU, m.scaleV)
            if k in self.images:
                result[here] = _lookup(self.images[k], scaled, m.texturefilter, m.texturewrap)
            elif m.texture is not None:
                even = np.floor(m.texture.scale * scaled).sum(axis=1) % 2 == 0
                result[here] = np.where(even[:, None], m.texture.color1, m.texture.color2)
            else:
                result[here] = m.diffusecolor
        return result

    def radiance(self, o, d, bounces):
        """Return the linear colour of rays, (N, 3), with both branches followed to the last bounce."""
        out = np.broadcast_to(np.array(self.world.backgroundcolor, float), d.shape).copy()
        t, index, n, uv = self.intersect(o, d)
        hit = np.flatnonzero(index != MISS)
        if len(hit) == 0:
            return out
        inside = _dot(n[hit], d[hit]) > 0
        met = Hits(o[hit] + t[hit, None] * d[hit], np.where(inside[:, None], -n[hit], n[hit]), -d[hit], inside,
                   index[hit], uv[hit], [s.material for s in self.shapes])
        switched = (met.of("isreflective") > 0) | (met.of("isrefractive") > 0)
        share = np.where(switched, met.of("reflectivity"), 0)[:, None]
        second = self._mirror_or_glass(met, share[:, 0] > 0, bounces) if bounces > 0 else out[hit]
        out[hit] = (1 - share) * self._local(met) + share * second
        return out

    def _local(self, met):
        """Return the ambient light and that of the lights, (N, 3), without mirror and glass."""
        p, n, wo, of = met.p, met.n, met.wo, met.of
        albedo = self.albedo(met.index, met.uv)
        out = np.array(self.world.ambientlight) * albedo
        for light in self.world.lightsources:
            way = np.array(light.position) - p
            distance = np.linalg.norm(way, axis=1)
            l, h = _unit(way), _unit(_unit(way) + wo)
            lit = (_dot(n, l) > 0) & (self.intersect(p + 1e-9 * n, l)[0] >= distance)
            shine = np.maximum(_dot(n, h), 0) ** of("specularexponent")
            term = (of("kd") * _dot(n, l))[:, None] * albedo + (of("ks") * shine)[:, None] * of("specularcolor")
            out = out + np.where(lit[:, None], term * np.array(light.intensity), 0)
        return out

    def _mirror_or_glass(self, met, active, bounces):
        """Return what mirror or glass shows where `active`, (N, 3), and 0 elsewhere."""
        n, wo = met.n, met.wo
        eta = met.of("refractiveindex") / np.array(self.outside)[met.index]
        eta = np.where(met.inside, 1 / eta, eta)
        ci = _dot(n, wo)
        st2 = (1 - ci * ci) / eta**2
        ct = np.sqrt(np.maximum(1 - st2, 0))
        with np.errstate(invalid="ignore", divide="ignore"):
            rs, rp = (ci - eta * ct) / (ci + eta * ct), (eta * ci - ct) / (eta * ci + ct)
        glass = met.of("isrefractive") > 0
        fresnel = np.where(glass, np.where(st2 >= 1, 1.0, (rs**2 + rp**2) / 2), 1.0)
        reflected = 2 * ci[:, None] * n - wo
        refracted = n * (ci / eta - ct)[:, None] - wo / eta[:, None]
        result = np.zeros_like(met.p)
        both = (active & (fresnel > 0), reflected, fresnel), (active & (fresnel < 1), refracted, 1 - fresnel)
        for mask, way, weight in both:
            if mask.any():
                result[mask] += weight[mask, None] * self.radiance(met.p[mask], _unit(way[mask]), bounces - 1)
        return result


def _lookup(image, uv, kind, wrap):
    """Return texels nearest to, or interpolated at, uv; texel (i, j) covers [i/W, (i+1)/W] x [j/H, (j+1)/H]."""
    height, width = image.shape[:2]
    fix = (lambda i, n: i % n) if wrap == "repeat" else (lambda i, n: np.clip(i, 0, n - 1))
    at = lambda i, j: image[fix(j, height), fix(i, width)]  # noqa: E731
    if kind == "nearest":
        i, j = np.floor(uv * (width, height)).astype(int).T
        return at(i, j)
    x, y = (uv * (width, height) - 0.5).T
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - i)[:, None], (y - j)[:, None]
    top, bottom = (at(i, k) * (1 - fx) + at(i + 1, k) * fx for k in (j, j + 1))
    return top * (1 - fy) + bottom * fy


def render(loaded):
    """Return the same dictionary as `converters.whitted.reference` in phong mode, in float64."""
    twin, c = Twin(loaded), loaded.description.camera
    o, d = twin.camera_rays()
    t, index, n, uv = twin.intersect(o, d)
    hit, size = index != MISS, (c.height, c.width)
    numbers = np.array([*(k for k, _ in loaded.shapes), 0xFFFFFFFF], dtype=np.uint32)
    image = lambda v: np.where(hit if v.ndim == 1 else hit[:, None], v, 0).reshape(*size, *v.shape[1:])  # noqa: E731
    return {"hit": hit.reshape(size), "shape": numbers[index].reshape(size), "depth": image(t), "normal": image(n),
            "uv": image(uv), "albedo": image(twin.albedo(index, uv)),
            "rgb": twin.radiance(o, d, loaded.description.nbounces).reshape(*size, 3)}
