"""Pictures do not depend on what finds the shapes; and surfaces of meshes are left as those of solids are.

Solids in the structure run the formulas that they run outside of it, on the same numbers: their pictures are the same
to the last bit. Triangles outside are met in their plane, and within EDGE_TOLERANCE of their edges; inside by the
watertight test. So distances differ by rounding, and a ray within 16 roundoffs of an outline may go either way.
"""

import numpy as np
import pytest

from renderer.core.backend import Bool, Float
from renderer.core.records import NO_SHAPE, Ray
from renderer.core.rows import UNROLL_LIMIT
from renderer.engine import queries
from renderer.engine.render import render
from renderer.scene.geometry import leave
from renderer.scene.schema import PATHTRACER, RENDER_MODES
from renderer.scene.tables import compile_scene
from tests.support.alone import run_alone
from tests.support.scenes import MATT, loaded, point_light
from tests.support.soups import ball, cube, unit, vectors, write_obj

SIZE = {"width": 160, "height": 120}
LIGHTS = [point_light([2, 3, -4]), point_light([-3, 1, -3], [0.3, 0.2, 0.1])]
MIRROR = MATT | {"isreflective": True, "reflectivity": 0.5}
GLASS = MATT | {"isrefractive": True, "refractiveindex": 1.4, "reflectivity": 0.9}
FLOOR = {"type": "plane", "point": [0, -1.6, 0], "normal": [0, 1, 0], "material": MATT}
SOLIDS = ("sphere", "cylinder", "box", "convex")
MODES = [mode for mode in RENDER_MODES if mode != PATHTRACER]  # its way is another: tests/integrators/test_path.py
ROUNDING = 4e-6  # relative: 16 roundoffs of the coordinates, four times magnified by slanting triangles
OUTLINES = 2e-4  # share of pixels whose rays pass an outline, or the edge of a shadow, within rounding


@pytest.fixture
def rng():
    """A generator that every test starts from the same state."""
    return np.random.default_rng(20240229)


def shape(kind, rng):
    """Return a random shape of a kind."""
    c, r = rng.uniform(-1.5, 1.5, 3), rng.uniform(0.1, 0.35)
    if kind == "sphere":
        return {"type": kind, "center": c.tolist(), "radius": r}
    if kind == "cylinder":
        axis, height = rng.normal(size=3).tolist(), r * rng.uniform(0.3, 2)
        return {"type": kind, "center": c.tolist(), "axis": axis, "radius": r, "height": height}
    if kind == "box":
        low, high = c - r * rng.uniform(0.3, 1, 3), c + r * rng.uniform(0.3, 1, 3)
        return {"type": kind, "min": low.tolist(), "max": high.tolist()}
    if kind == "convex":
        return {"type": kind, "vertices": (c + r * rng.normal(size=(8, 3))).tolist()}
    return {"type": kind} | {f"v{k}": (c + 2 * r * rng.normal(size=3)).tolist() for k in range(3)}


def crowd(rng, kinds, count=65, materials=(MATT, MATT | {"ks": 0.3})):
    """Return shapes of kinds in turn, of random colours."""
    shapes = []
    for k in range(count):
        material = materials[rng.integers(len(materials))] | {"diffusecolor": rng.random(3).tolist()}
        shapes.append(shape(kinds[k % len(kinds)], rng) | {"material": material})
    return shapes


def both(folder, shapes, **keys):
    """Return the channels of a picture, (height, width, N) each, with a hierarchy and without."""
    scene = loaded(folder, shapes, LIGHTS, camera=SIZE, **keys)
    names = {"phong": "RGB", "binary": "R"}.get(keys["rendermode"])
    pictures = []
    for accel in ("bvh", "none"):
        channels = render(scene, accel=accel).channels()
        chosen = names or [name for name in channels if name not in "RGB"]
        pictures.append(np.stack([channels[name].astype(np.float64) for name in chosen], -1))
    return pictures


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("kinds", [*((kind,) for kind in SOLIDS), SOLIDS], ids="-".join)
def test_solids_look_the_same_to_the_last_bit(tmp_path, rng, kinds, mode):
    """In every mode."""
    with_it, without = both(tmp_path, crowd(rng, kinds), rendermode=mode)
    assert np.array_equal(with_it, without)
    assert np.ptp(without) > 0


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("kinds", [("triangle",), (*SOLIDS, "triangle")], ids=["triangles", "mixed"])
def test_triangles_look_the_same_but_for_rounding(tmp_path, rng, kinds, mode):
    """Rounding of depths and points everywhere, and another shape or shadow in a few pixels on outlines."""
    with_it, without = both(tmp_path, crowd(rng, kinds), rendermode=mode)
    error = (np.abs(with_it - without) / np.maximum(1, np.abs(without))).max(-1)
    # uv is known to the rounding of the point over the height of its triangle
    bound = {"uv": 32 * ROUNDING}.get(mode, ROUNDING)
    assert np.quantile(error, 1 - OUTLINES) <= (0 if mode in ("binary", "shapes", "albedo") else bound)


@pytest.mark.parametrize("kinds", [SOLIDS, (*SOLIDS, "triangle")], ids=["solids", "mixed"])
def test_mirrors_and_glass_look_the_same(tmp_path, rng, kinds):
    """A hierarchy beside unrolled code, which rounds otherwise: bounces between curved shapes magnify that."""
    shapes = [*crowd(rng, kinds, UNROLL_LIMIT - 1, (MATT, MIRROR, GLASS)), FLOOR]
    with_it, without = both(tmp_path, shapes, rendermode="phong", nbounces=5)
    error = np.abs(with_it - without).max(-1)
    assert np.median(error) <= 1e-7 and (error > 1e-4).mean() < 2e-3


MANY = """
import pathlib
import numpy as np
from renderer.core import llvm; llvm.prepare()
from renderer.engine.render import render
from tests.engine.test_structures import FLOOR, GLASS, LIGHTS, SIZE, crowd
from tests.support.scenes import loaded
shapes = [*crowd(np.random.default_rng(0), {kinds}, 60, (GLASS,)), FLOOR]
render(loaded(pathlib.Path({folder!r}), shapes, LIGHTS, camera=SIZE, rendermode={mode!r}), accel={accel!r})
"""


@pytest.mark.parametrize("mode", ["phong", "normals"])
@pytest.mark.parametrize("kinds, accel", [
    (("sphere",), "none"), (("sphere",), "bvh"),
    (("sphere",) * 8 + ("convex", "triangle"), "bvh"),
])  # fmt: skip
def test_many_shapes_render(tmp_path, root, kinds, accel, mode):
    """The kernel compiles; in a process of its own, which LLVM ends otherwise."""
    code = MANY.format(kinds=kinds, folder=str(tmp_path), accel=accel, mode=mode)
    run_alone(code, root)


# Rays in arrays


def compare_arrays(folder, rng, kinds, count, coherent):
    """Fail unless rays in arrays meet what the query in a kernel meets, closest and any."""
    write_obj(folder / "ball.obj", *ball(10, 0.1))
    shapes = [*crowd(rng, kinds), {"type": "mesh", "filename": "ball.obj"}, FLOOR]
    scene = compile_scene(loaded(folder, shapes), "bvh")
    ray = Ray(vectors(rng.uniform(-2, 2, (count, 3))), vectors(unit(rng.normal(size=(count, 3)))))
    hit, found = scene.intersect(ray), queries.closest(scene, ray, coherent)
    assert np.array_equal(hit.index.numpy(), found.index.numpy()) and np.array_equal(hit.t.numpy(), found.t.numpy())
    end = Float(np.float32(rng.uniform(0.1, 3, count)))
    blocked = scene.occluded(ray, end, Bool(True)).numpy()
    assert np.array_equal(blocked, queries.occluded(scene, ray, end, coherent).numpy())
    assert count < 5000 or 0.1 < blocked.mean() < 0.95 and 0.3 < (found.index.numpy() != NO_SHAPE).mean() < 1


@pytest.mark.parametrize("count", [1, 2, 3, 17, 5000])
@pytest.mark.parametrize("coherent", [True, False])
def test_rays_in_arrays_meet_the_same(tmp_path, rng, count, coherent):
    """In turns or side by side, and however few: what a leaf's record holds, and triangles."""
    compare_arrays(tmp_path, rng, ("sphere", "cylinder", "box", "triangle"), count, coherent)


ARRAYS = """
import pathlib
import numpy as np
from renderer.core import llvm; llvm.prepare()
from tests.engine.test_structures import compare_arrays
compare_arrays(pathlib.Path({folder!r}), np.random.default_rng(0), ("sphere", "convex"), 5000, False)
"""


def test_rays_in_arrays_meet_what_no_record_holds(tmp_path, root):
    """In a process of its own, which reading outside of the rows ends."""
    code = ARRAYS.format(folder=str(tmp_path))
    run_alone(code, root)


# Leaving the surfaces of meshes

# scale, and offset in scene units; coordinates at 1e5 are multiples of 1/128
PLACES = [(1.0, 0.0), (1e-4, 0.0), (1e4, 0.0), (1.0, 1e5), (64.0, 1e5)]
CHECKS = {"type": "checkerboard", "scale": 1, "color1": [0.2, 0.7, 0.3], "color2": [0.8, 0.7, 0.6]}


def put(points, place):
    """Return points of the plain scene in a place, as lists."""
    scale, offset = place
    return (scale * np.asarray(points, float) + offset).tolist()


def camera(place, position=(2.1, 1.7, -4.3)):
    """Return a camera in a place."""
    return SIZE | {"position": put(position, place), "lookAt": put([0, -0.1, 0], place), "fov": 40}


def mesh(name, place, material, normals="flat"):
    """Return a mesh shape in a place."""
    scale, offset = place
    steps = [{"scale": scale}, {"translate": [offset] * 3}]
    return {"type": "mesh", "filename": name, "transform": steps, "normals": normals, "material": material}


def picture(folder, shapes, lights, place, eye=(2.1, 1.7, -4.3), names="RGB", **keys):
    """Return the picture of a scene in a place, (height, width, 3)."""
    lit = [point_light(put(position, place)) for position in lights]
    scene = loaded(folder, shapes, lit, camera=camera(place, eye), **keys)
    channels = render(scene, accel="bvh").channels()
    return np.stack([channels[name] for name in names], -1)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("name, normals, least", [
    ("ball", "flat", 0.35), ("cube", "flat", 0.35), ("ball", "smooth", 0.75),
])  # fmt: skip
def test_a_lit_mesh_has_no_black_pixels(tmp_path, place, name, normals, least):
    """Convex meshes do not shadow their lit side.

    That is where the cosine between the triangle's normal and the light's direction is above `least`: the light is five
    units away from points within one of the middle, and smooth normals of a coarse ball are up to 25 degrees off.
    """
    rows = 3 if place[1] else 16  # at 1e5 finer triangles would be dented by the rounding of their corners
    write_obj(tmp_path / "a.obj", *(ball(rows) if name == "ball" else cube()))
    shapes = [mesh("a.obj", place, MATT, normals)]
    eye, light = (2.1, 1.7, -4.3), (4.0, 3.0, -1.0)
    keys = {"ambientlight": [0, 0, 0], "backgroundcolor": [0, 0, 0]}
    seen = picture(tmp_path, shapes, [eye], place, eye, **keys)[..., 0]
    hit = picture(tmp_path, shapes, [], place, eye, "R", rendermode="binary")[..., 0] > 0
    assert hit.mean() > 0.05 and (seen[hit] > 0).all(), "a light at the eye shines on all that is seen"

    n = picture(tmp_path, shapes, [], place, eye, ("N.X", "N.Y", "N.Z"), rendermode="normals")
    toward = np.asarray(light) / np.linalg.norm(light)
    facing = hit & (n @ toward > least)
    seen = picture(tmp_path, shapes, [light], place, eye, **keys)[..., 0]
    assert facing.sum() > 100 and (seen[facing] > 0).all()
    assert not seen[hit & (n @ toward < -0.35)].any() or normals == "smooth"


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("floor", ["plane", "mesh"])
def test_contact_stays_dark(tmp_path, place, rng, floor):
    """A box of triangles that stands on a floor hides the light from every point below it, up to its very edges."""
    write_obj(tmp_path / "cube.obj", *cube())
    square = np.array([[-9, -1, -9], [9, -1, -9], [9, -1, 9], [-9, -1, 9.0]])
    write_obj(tmp_path / "floor.obj", square, np.array([[0, 2, 1], [0, 3, 2]]))
    ground = {"type": "plane", "point": put([0, -1, 0], place), "normal": [0, 1, 0]} if floor == "plane" else mesh(
        "floor.obj", place, MATT)
    scene = compile_scene(loaded(tmp_path, [mesh("cube.obj", place, MATT), ground]), "bvh")
    # camera rays to the floor from below, where nothing is in their way
    edge = rng.uniform(-1, 1, (20_000, 2))
    edge[:10_000] = np.sign(edge[:10_000]) * (1 - 10.0 ** rng.uniform(-6, -1, (10_000, 2)))
    target = np.column_stack([edge[:, 0], np.full(len(edge), -1), edge[:, 1]])
    o = np.float32(put(target + [0.1, -3, 0.2], place)).astype(float)
    target = np.array(put(target, place))
    ray = Ray(vectors(o), vectors(unit(target - o)))
    hit = scene.intersect(ray)
    surface = scene.surface(ray, hit, with_uv=False)
    light = np.array(put([0.3, 5, -0.2], place))
    p = surface.p.numpy().T.astype(float)
    leaving = leave(surface, hit.index, vectors(unit(light - p)))
    distance = Float(np.float32(np.linalg.norm(light - p, axis=1)))
    blocked = scene.occluded(leaving, distance, hit.valid).numpy()
    low, high = put([-1] * 3, place)[0], put([1] * 3, place)[0]
    # what float32 aimed beside the box does not count
    below = (p[:, [0, 2]] > low).all(1) & (p[:, [0, 2]] < high).all(1)
    assert below.sum() > 5000 and blocked[below].all()


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("material", [MATT, MIRROR, GLASS], ids=["matt", "mirror", "glass"])
def test_a_cube_of_triangles_looks_like_a_box(tmp_path, place, material):
    """Shadows, reflections, and refraction through both sides."""
    write_obj(tmp_path / "cube.obj", *cube())
    scale, _ = place
    checks = MATT | {"texture": CHECKS, "scaleU": 1 / scale, "scaleV": 1 / scale}
    # below the cube: where a face lies in the floor, rounding decides which of them a ray inside of the glass meets
    ground = {"type": "plane", "point": put([0, -1.3, 0], place), "normal": [0, 1, 0], "material": checks}
    box = {"type": "box", "min": put([-1] * 3, place), "max": put([1] * 3, place), "material": material}
    lights = [(2, 3, -4), (-3, 4, -3)]
    of_triangles, of_faces = (
        picture(tmp_path, [cuboid, ground], lights, place, nbounces=6)
        for cuboid in (mesh("cube.obj", place, material), box)
    )
    error = np.abs(of_triangles - of_faces).max(-1)
    assert np.median(error) <= 2e-6
    if place == (1.0, 1e5):
        # points are known to 1/128: the edges of the floor's squares move by a third of a pixel, to either side
        assert np.abs((of_triangles - of_faces).mean((0, 1))).max() < 2e-3
    else:
        assert (error > 1e-2).mean() < 2e-3
    assert np.ptp(of_faces) > 0.3


def test_acne_would_be_noticed(tmp_path, monkeypatch):
    """Without the number of the triangle that was left, and without moving off it, pixels turn black."""
    from renderer.integrators import phong
    from renderer.scene import geometry

    write_obj(tmp_path / "a.obj", *ball(16))
    monkeypatch.setattr(phong, "leave", lambda surface, index, d: Ray(surface.p, d, None, None))
    monkeypatch.setattr(geometry, "LEAVE_ULPS", 0.0)
    seen = picture(tmp_path, [mesh("a.obj", PLACES[0], MATT)], [(2.1, 1.7, -4.3)], PLACES[0], ambientlight=[0, 0, 0],
                   backgroundcolor=[1, 1, 1])  # fmt: skip
    assert (seen == 0).any()
