"""Lamps of any size.

Lamps from 1e-6 to 1e6 across, seen from 0.01 to 100 times that far: nothing here has a fixed length, so irradiance must
not depend on the scale. It is taken over a regular grid of random numbers, which leaves no noise, and held against
closed forms. Shadow rays must end before the lamp that they are aimed at, or it hides itself, and not before what
stands close in front of it.
"""

import math
import tempfile
from pathlib import Path

import drjit as dr
import numpy as np

from renderer.core.backend import Bool, Float, Vector2f, Vector3f
from renderer.core.records import Ray
from tests.lights.room import Room
from tests.stability.case import Case, mitsuba, relative

SCALES = [1e-6, 1e-3, 1.0, 1e3, 1e6]
GRID = 512  # random numbers along each side
TRIANGLES = 64  # cells along each side of a mesh
FIXED = 1e-4  # scene units, of the naive formulas
CORNER = math.atan(math.sqrt(0.5)) / math.sqrt(2)  # irradiance under the corner of a square as large as it is high
EXPECTED = {"rectangle": CORNER, "disk": math.pi / 5, "sphere": math.pi / 4, "mesh": CORNER}
POINTS = 20_000


def lamp(kind, s):
    """Return a shape of size s over the origin, of radiance 1 downwards."""
    shapes = {
        "rectangle": {"center": [s / 2, s, s / 2], "u": [s, 0, 0], "v": [0, 0, s]},
        "disk": {"center": [0, 2 * s, 0], "normal": [0, -1, 0], "radius": s},
        "sphere": {"center": [0, 2 * s, 0], "radius": s},
        "mesh": {"filename": "lamp.obj"},
    }
    return {"type": kind, "emission": [1, 1, 1], **shapes[kind]}


def room(*shapes):
    """Return the Room of shapes."""
    with tempfile.TemporaryDirectory() as folder:
        for shape in shapes:
            if shape["type"] == "mesh":
                Path(folder, "lamp.obj").write_text(square_mesh(shape.pop("size")))
        return Room(Path(folder), shapes)


def square_mesh(s):
    """Return an OBJ file of the rectangle of size s, in TRIANGLES^2 cells of two triangles that face down."""
    places = [s * k / TRIANGLES for k in range(TRIANGLES + 1)]
    lines = [f"v {x!r} {s!r} {z!r}" for x in places for z in places]
    for x in range(TRIANGLES):
        for z in range(TRIANGLES):
            a = 1 + x * (TRIANGLES + 1) + z
            b = a + TRIANGLES + 1
            lines += [f"f {a} {b} {b + 1}", f"f {a} {b + 1} {a + 1}"]
    return "\n".join([*lines, ""])


def grid():
    """Return random numbers: one, and two in a grid."""
    middles = (np.arange(GRID) + 0.5) / GRID
    x, y = (axis.ravel().astype(np.float32) for axis in np.meshgrid(middles, middles))
    turned = (np.arange(GRID**2) * 0.754877666246693) % 1  # fills [0, 1) evenly also within each part of the grid
    return turned.astype(np.float32), x, y


def arriving(shape):
    """Return the renderer's irradiance at the origin on a surface that faces up."""
    u, x, y = grid()
    found = room(shape).lighting.sample(dr.zeros(Vector3f, GRID**2), Float(u), Vector2f(x, y))
    pdf_sa = np.asarray((found.pdf_sa + dr.zeros(Float, GRID**2)).numpy(), float)
    return (found.radiance.x.numpy() * np.maximum(found.wo.y.numpy().astype(float), 0) / pdf_sa).mean()


def irradiances(kinds, arriving):
    """Return a callable: relative errors of irradiances from lamps of all sizes, by a function."""

    def measure():
        return [relative(arriving(lamp(kind, s) | ({"size": s} if kind == "mesh" else {})), EXPECTED[kind])
                for kind in kinds for s in SCALES]  # fmt: skip

    return measure


def regularised(shape):
    """Return the irradiance from a rectangle by the textbook's form, the squared distance kept away from 0."""
    _, x, y = grid()
    s = np.float32(shape["center"][1])
    q = np.stack([x * s, np.full_like(x, s), y * s])
    squared = (q * q).sum(axis=0) + np.float32(FIXED)
    cosine = q[1] / np.sqrt(squared)
    return float((cosine * cosine / squared * s * s).mean(dtype=float))


def short_normals(shape):
    """Return the irradiance from the mesh where squares of normals are kept away from 0, one triangle for all."""
    s = np.float32(shape["size"])
    cross = (s / np.float32(TRIANGLES)) ** 2
    return CORNER / max(float(cross / np.sqrt(np.maximum(cross * cross, np.float32(1e-30)))), 1e-30)


def mitsubas_scene(*shapes):
    """Return Mitsuba's scene of flat lamps and spheres, and of black rectangles."""
    mi = mitsuba()
    made = {"type": "scene"}
    for number, shape in enumerate(shapes):
        t = mi.ScalarTransform4f
        if shape["type"] == "sphere":
            own = {"type": "sphere", "center": shape["center"], "radius": shape["radius"]}
        elif shape["type"] == "disk":
            x, y, z = shape["center"]
            r = shape["radius"]
            own = {"type": "disk", "to_world": t([[r, 0, 0, x], [0, 0, -r, y], [0, r, 0, z], [0, 0, 0, 1]])}
        else:
            u, v = (0.5 * np.array(shape[edge], float) for edge in "uv")
            n = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
            matrix = np.eye(4)
            matrix[:3] = np.stack([u, v, n, shape["center"]], axis=1)
            own = {"type": "rectangle", "to_world": t(matrix)}
        if "emission" in shape:
            own["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}
        made[f"shape{number}"] = own
    return mi.load_dict(made)


def mitsubas_arriving(shape):
    """Return Mitsuba's irradiance at the origin on a surface that faces up."""
    mi = mitsuba()
    _, x, y = grid()
    si = dr.zeros(mi.SurfaceInteraction3f, GRID**2)
    ds, weight = mitsubas_scene(shape).sample_emitter_direction(si, mi.Point2f(x, y), False)
    return (weight.x.numpy().astype(float) * np.maximum(ds.d.y.numpy(), 0)).mean()


def views(s):
    """Return a tilted lamp of size s, a rectangle before it, and points (3, N) whose rays to the lamp cross that."""
    rng = np.random.default_rng(3)
    u, v = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
    n = np.cross(u, v)
    center = s * rng.normal(size=3) * 3
    shapes = [{"type": "rectangle", "center": [*center], "u": [*(s * u)], "v": [*(s * v)], "emission": [1, 1, 1]},
              {"type": "rectangle", "center": [*(center + 0.02 * s * n)], "u": [*(4 * s * u)], "v": [*(4 * s * v)]}]
    height = s * 10 ** rng.uniform(-1, 2, POINTS)
    aside = height * rng.uniform(-3, 3, (2, POINTS))
    p = center[:, None] + height * n[:, None] + aside[0] * u[:, None] + aside[1] * v[:, None]
    return shapes, p.astype(np.float32)


def shadows(blocked):
    """Return a callable: which answers are wrong of a function that tells whether lamps are hidden from points.

    At first nothing is in the way, and then everything is.
    """

    def measure():
        wrong = []
        for s in SCALES:
            shapes, p = views(s)
            wrong += [blocked(shapes[:1], p), ~blocked(shapes, p)]
        return np.concatenate(wrong)

    return measure


def lamp_numbers():
    """Return random numbers for POINTS lamps: one, and two more, (3, POINTS) float32."""
    return np.random.default_rng(4).random((3, POINTS), np.float32)


def ours_blocked(shapes, p):
    """Return the renderer's answer."""
    u, x, y = lamp_numbers()
    own, p = room(*shapes), Vector3f(*p)
    found = own.lighting.sample(p, Float(u), Vector2f(x, y))
    return own.geometry.occluded(Ray(p, found.wo), found.distance, Bool(True)).numpy()


def naive_blocked(shapes, p):
    """Return the textbook's answer: hits between FIXED and FIXED before the lamp's point count."""
    _, x, y = lamp_numbers()
    (center, u, v), *_ = flat = [[np.array(shape[key], np.float32)[:, None] for key in ("center", "u", "v")]
                                 for shape in shapes]  # fmt: skip
    d = center + (x - np.float32(0.5)) * u + (y - np.float32(0.5)) * v - p
    distance = np.sqrt((d * d).sum(axis=0))
    d = d / distance
    hidden = np.zeros(POINTS, bool)
    for center, u, v in flat:
        n = np.cross(u[:, 0], v[:, 0])[:, None]
        t = (n * (center - p)).sum(axis=0) / (n * d).sum(axis=0)
        hidden |= (t > np.float32(FIXED)) & (t < distance - np.float32(FIXED))
    return hidden


def mitsubas_blocked(shapes, p):
    """Return Mitsuba's answer at points of surfaces that face the lamp."""
    mi = mitsuba()
    _, x, y = lamp_numbers()
    si = dr.zeros(mi.SurfaceInteraction3f, POINTS)
    si.p = mi.Point3f(*p)
    si.n = dr.normalize(mi.Vector3f(*map(float, shapes[0]["center"])) - si.p)
    _, weight = mitsubas_scene(*shapes).sample_emitter_direction(si, mi.Point2f(x, y), True)
    return weight.x.numpy() == 0


GRID_LEAVES = "the grid leaves 1.4e-6 of a disk's integral, and rounding five times 6e-8 in each sample"
CASES = (
    Case("irradiance from lamps 1e-6 to 1e6 across", "relative", 2e-6, GRID_LEAVES,
         irradiances(("rectangle", "disk", "sphere"), arriving), irradiances(("rectangle",), regularised),
         "of a rectangle, 1e-4 added to squared distances",
         irradiances(("rectangle", "disk", "sphere"), mitsubas_arriving)),
    Case("irradiance from meshes 1e-6 to 1e6 across", "relative", 2e-4,
         "measured x 2, of the set of points, the same at every size",
         irradiances(("mesh",), arriving), irradiances(("mesh",), short_normals),
         "squares of normals kept above 1e-30", None, "takes points of meshes from other numbers"),
    Case("lamps 1e-6 to 1e6 across, and shadows close to them", "share", 0, "none is wrong", shadows(ours_blocked),
         shadows(naive_blocked), "a fixed distance of 1e-4", shadows(mitsubas_blocked),
         "shadow rays end 9e-4 of their length before the lamp, and start 9e-5 (1 + |p|) off the surface"),
)  # fmt: skip
