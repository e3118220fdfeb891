"""Directions behind surfaces, and ways through many of them.

Refraction: the law of Snell and the length of what comes out. Then rays through eight shells of glass within one
another, and a hundred bounces between two mirrors, followed by the integrators of both modes and, on the same numbers,
in double precision.
"""

import functools
import json
import tempfile
from pathlib import Path

import drjit as dr
import numpy as np

from renderer.core.backend import Bool, Float, UInt32, Vector2f
from renderer.core.fresnel import dielectric, refract
from renderer.integrators import integrator_of
from renderer.scene.loader import load
from renderer.scene.paths import compile_paths
from renderer.scene.tables import compile_scene
from tests.stability.case import ULP, Case, mitsuba
from tests.stability.microfacets import lanes, unit, vectors

COUNT = 20_000
ONE = np.float32(1)
EPSILON = np.float32(1e-4)  # by which the usual renderer moves the origins of rays
INDICES = 1.5, 1.25, 1.75, 1.375, 1.625, 1.1875, 1.875, 1.4375  # from the outermost shell inwards
MATCHED = (1.0,) * 8
CENTER = np.array([0.5, -0.25, 2.0])
RADII = np.arange(8, 0, -1) / 8
BOUNCES, KEPT = 100, 0.99
NORMAL = unit(np.array([[0.3, 0.8, -0.5]]))[0]  # of both mirrors, which are 1 apart
CAMERA = {"type": "pinhole", "width": 4, "height": 4, "position": [0, 0, -4], "lookAt": [0, 0, 0],
          "upVector": [0, 1, 0], "fov": 40.0}  # fmt: skip


class Last:
    """Draws: numbers that choose refraction."""

    def u2(self, dimension):
        """Return the greatest number for the choice of a lobe."""
        return Vector2f(0.5, 1 - 2.0**-24)

    def u1(self, dimension):
        """Return a number that no roulette ends at."""
        return Float(0)


def followed(shapes, mode, o, d, steps):
    """Return (origin, direction, throughput) of rays after so many surfaces, by the integrator of a mode."""
    document = {"nbounces": 64, "rendermode": mode, "roulette": False, "camera": CAMERA,
                "scene": {"backgroundcolor": [0, 0, 0], "lightsources": [], "shapes": shapes}}  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.json"
        path.write_text(json.dumps(document))
        loaded = load(str(path))
    scene = compile_scene(loaded, "none") if mode == "phong" else compile_paths(loaded, "none")
    integrator = integrator_of(mode)(scene, steps + 1)
    count = len(o)
    state = integrator.restart(integrator.start(count), Bool(True), lanes(o), lanes(d))

    def onward(step, state):
        return step + 1, integrator.step(state, Last())[2]

    limit = dr.opaque(UInt32, steps)
    _, state = dr.while_loop((dr.zeros(UInt32, count), state), lambda step, state: step < limit, onward)
    end = state.now if mode == "phong" else state
    worth = end.weight if mode == "phong" else end.throughput.x
    dr.eval(end.o, end.d, worth)
    return end.o.numpy().T, end.d.numpy().T, worth.numpy()


def mirrored(d, n):
    """Return directions mirrored at normals."""
    return d - 2 * (d * n).sum(1, keepdims=True) * n


def bent(d, n, eta):
    """Return directions refracted at normals that face them; eta is the index behind over that in front."""
    cos_i = -(d * n).sum(1, keepdims=True)
    cos_t = np.sqrt(1 - (1 - cos_i * cos_i) / eta**2)
    return d / eta + n * (cos_i / eta - cos_t)


@functools.cache
def rays():
    """Return float32 (d, n, eta): unit to rounding, at all angles; from below at angles that refract."""
    draw = np.random.default_rng(81)
    n = unit(draw.normal(size=(COUNT, 3)))
    eta = draw.choice([1.0001, 1.33, 1.5, 2.4, 1 / 1.33, 1 / 1.5, 1 / 2.4], COUNT).astype(np.float32)
    sin = np.minimum(eta.astype(float), 1) * np.where(np.arange(COUNT) % 2, draw.uniform(0, 1, COUNT),
                                                      10 ** draw.uniform(-6, 0, COUNT)) * (1 - 1e-6)  # fmt: skip
    across = unit(np.cross(n, draw.normal(size=(COUNT, 3))))
    d = sin[:, None] * across - np.sqrt(1 - sin**2)[:, None] * n
    return d.astype(np.float32), n.astype(np.float32), eta


def ours_refracted(d, n, eta):
    """Return directions by the renderer."""
    d, n, eta = lanes(d), lanes(n), Float(eta)
    cos_i = -dr.dot(n, d)
    return refract(d, n, cos_i, dielectric(cos_i, eta)[1], eta).numpy().T


def textbook_refracted(d, n, eta):
    """Return directions by sines: sin = sqrt(1 - cos^2), in float32."""
    cos_i = -(d * n).sum(1)
    sin_i = np.sqrt(np.maximum(ONE - cos_i * cos_i, 0))
    across = (d + cos_i[:, None] * n) / np.maximum(sin_i, np.float32(1e-30))[:, None]
    sin_t = sin_i / eta
    return (across * sin_t[:, None] - np.sqrt(np.maximum(ONE - sin_t * sin_t, 0))[:, None] * n).astype(np.float32)


def their_refracted(d, n, eta):
    """Return directions by Mitsuba, in its local frames."""
    mi = mitsuba()
    frame = mi.Frame3f(mi.Normal3f(vectors(mi, n)))
    wi = frame.to_local(-vectors(mi, d))
    _, cos_t, _, eta_ti = mi.fresnel(mi.Frame3f.cos_theta(wi), mi.Float(eta))
    return frame.to_world(mi.refract(wi, cos_t, eta_ti)).numpy().T


def snell(side):
    """Return by how much sin_i / eta and sin_t differ."""
    d, n, eta = (part.astype(float) for part in rays())
    t = side(*rays()).astype(float)
    return np.linalg.norm(np.cross(unit(n), unit(t)) - np.cross(unit(n), unit(d)) / eta[:, None], axis=1)


def lengths(side):
    """Return by how much the lengths of directions differ from 1."""
    return np.linalg.norm(side(*rays()).astype(float), axis=1) - 1


@functools.cache
def beams():
    """Return float32 origins and directions of rays through the innermost shell, the first ones through its middle."""
    draw = np.random.default_rng(82)
    d = unit(draw.normal(size=(COUNT, 3)))
    aside = unit(np.cross(d, draw.normal(size=(COUNT, 3)))) * draw.uniform(0, 0.11, (COUNT, 1))
    aside[:100] = 0
    return (CENTER + aside - 3 * d).astype(np.float32), d.astype(np.float32)


def through(indices, kind, moved=0):
    """Return (origin, direction) behind the shells, in the precision `kind`; origins are moved off surfaces."""
    o, d = (part.astype(kind) for part in beams())
    center, around = CENTER.astype(kind), (1.0, *indices)
    if kind is np.float64:
        d = unit(d)
    for k, inside in [*((k, True) for k in range(8)), *((k, False) for k in range(7, -1, -1))]:
        radius, eta = kind(RADII[k]), kind(around[k + 1] / around[k] if inside else around[k] / around[k + 1])
        b, c = ((o - center) * d).sum(1), ((o - center) ** 2).sum(1) - radius * radius
        root = np.sqrt(b * b - c)
        o = o + (-b - root if inside else -b + root)[:, None] * d
        n = (o - center) / radius * kind(1 if inside else -1)
        d, o = bent(d, n, eta).astype(kind), o - kind(moved) * n
    return o, d


def shells(indices, mode):
    """Return the shapes of a scene of spheres within one another."""
    def glass(ior):
        plain = {"isrefractive": True, "refractiveindex": ior, "reflectivity": 1.0}
        return plain if mode == "phong" else {"bsdf": {"type": "dielectric", "ior": ior}}
    return [{"type": "sphere", "center": list(CENTER), "radius": r, "material": glass(ior)}
            for r, ior in zip(RADII, indices)]  # fmt: skip


def their_way(scene, o, d, steps, sample):
    """Return (origin, direction) of Mitsuba's rays after so many surfaces."""
    mi = mitsuba()
    ray = mi.Ray3f(mi.Point3f(vectors(mi, o)), vectors(mi, d))
    for _ in range(steps):
        si = scene.ray_intersect(ray)
        bs, _ = si.bsdf().sample(mi.BSDFContext(), si, mi.Float(sample), mi.Point2f(0.5))
        end, ray = si.p, si.spawn_ray(si.to_world(bs.wo))
        dr.eval(end, ray)
    return end.numpy().T, ray.d.numpy().T


def their_shells(indices):
    """Return where Mitsuba's rays leave the shells."""
    around = (1.0, *indices)
    glass = [{"type": "dielectric", "int_ior": inside, "ext_ior": outside} for inside, outside in zip(indices, around)]
    scene = {f"shell{k}": {"type": "sphere", "center": list(CENTER), "radius": float(RADII[k]), "bsdf": glass[k]}
             for k in range(8)}  # fmt: skip
    return their_way(mitsuba().load_dict({"type": "scene", **scene}), *beams(), 16, 1 - 2.0**-24)


def astray(found, indices):
    """Return how far from the exact ones points and directions behind the shells are."""
    o, d = through(indices, np.float64)
    return np.linalg.norm(found[0] - o, axis=1) + np.linalg.norm(found[1] - d, axis=1)


@functools.cache
def corridor():
    """Return float32 rays that start halfway between the mirrors, at 18 to 72 degrees to their normal."""
    draw = np.random.default_rng(83)
    across = unit(np.cross(NORMAL, draw.normal(size=(COUNT, 3))))
    cos = draw.uniform(0.3, 0.95, (COUNT, 1))
    d = draw.choice([-1, 1], (COUNT, 1)) * cos * NORMAL + np.sqrt(1 - cos * cos) * across
    return np.zeros((COUNT, 3), np.float32), d.astype(np.float32)


def bounced(kind, moved=0):
    """Return (point, direction) at the last of the bounces, in the precision `kind`; origins are moved off surfaces."""
    o, d = (part.astype(kind) for part in corridor())
    normal = NORMAL.astype(kind)
    if kind is np.float64:
        d = unit(d)
    for _ in range(BOUNCES):
        along = d @ normal
        side = np.sign(along)[:, None]
        o = o + ((kind(0.5) * side[:, 0] - o @ normal) / along)[:, None] * d
        end, o, d = o, o - kind(moved) * side * normal, mirrored(d, -side * normal)
    return end, d


def mirrors(mode):
    """Return the shapes of a scene of two mirrors."""
    plain = {"kd": 0.0, "ks": 0.0, "isreflective": True, "reflectivity": KEPT}
    material = plain if mode == "phong" else {"bsdf": {"type": "mirror", "reflectance": [KEPT] * 3}}
    return [{"type": "plane", "point": list(side * 0.5 * NORMAL), "normal": list(NORMAL), "material": material}
            for side in (-1, 1)]  # fmt: skip


def their_mirrors():
    """Return where Mitsuba's rays meet the last mirror."""
    mi = mitsuba()

    def sheet(side):
        origin, target = list(side * 0.5 * NORMAL), list(side * 1.5 * NORMAL)
        place = mi.ScalarTransform4f().look_at(origin=origin, target=target, up=[0, 0, 1])
        return {"type": "rectangle", "to_world": place @ mi.ScalarTransform4f().scale(500),
                "bsdf": {"type": "twosided", "bsdf": {"type": "conductor", "material": "none"}}}  # fmt: skip

    scene = mi.load_dict({"type": "scene", "a": sheet(-1), "b": sheet(1)})
    return their_way(scene, *corridor(), BOUNCES, 0.5)


def off_course(found):
    """Return how far from the exact ones the last points are over the way there, and the directions."""
    p, d = bounced(np.float64)
    way = (BOUNCES - 0.5) / np.abs(corridor()[1].astype(float) @ NORMAL)
    return np.linalg.norm(found[0] - p, axis=1) / way + np.linalg.norm(found[1] - d, axis=1)


def shell_case(name, indices, mode):
    """Return the Case of rays through shells."""
    each, frames = (12, "") if mode == "phong" else (20, ", of them 8 into the local frame and back")
    because = f"{each} roundings at each of 16 surfaces{frames}"
    return Case(f"{name}, mode {mode}", "of the radius", 16 * each * ULP, because,
                lambda: astray(followed(shells(indices, mode), mode, *beams(), 16), indices),
                lambda: astray(through(indices, np.float32, EPSILON), indices), "rays start 1e-4 off surfaces",
                lambda: astray(their_shells(indices), indices))  # fmt: skip


def corridor_case(mode):
    """Return the Case of many bounces."""
    return Case(f"100 bounces between two mirrors, mode {mode}", "of the way", 2 * BOUNCES * ULP,
                "2 roundings of the direction at each, the normal's among them",
                lambda: off_course(followed(mirrors(mode), mode, *corridor(), BOUNCES)),
                lambda: off_course(bounced(np.float32, EPSILON)), "rays start 1e-4 off surfaces",
                lambda: off_course(their_mirrors()))  # fmt: skip


SINES = "sin = sqrt(1 - cos^2)"
CASES = (
    Case("refracted directions, Snell's law", "of the sine", 10 * ULP, "10 roundings of vectors up to 2.4 long",
         lambda: snell(ours_refracted), lambda: snell(textbook_refracted), SINES, lambda: snell(their_refracted)),
    Case("refracted directions, length", "of 1", 3 * ULP, "rsqrt 1.9 roundings, and one",
         lambda: lengths(ours_refracted), lambda: lengths(textbook_refracted), SINES, lambda: lengths(their_refracted)),
    *(shell_case(f"eight shells of {what}", indices, mode)
      for what, indices in (("index 1", MATCHED), ("glass", INDICES)) for mode in ("phong", "pathtracer")),
    *(corridor_case(mode) for mode in ("phong", "pathtracer")),
)
