"""Meshes: what our readers, transformations, hierarchy and shading make of a file, and what Mitsuba's own do."""

import json

import numpy as np
import pytest

from benchmarks import mesh_scenes
from tests.oracle.conftest import GEOMETRY
from tests.support import oracle as sides
from tests.support.documents import GLASS, GROUND, MIRROR, SHAPES, SHINY, WHITE, scene, shape, write_texture
from tests.support.meshes import Model, lump, mesh, write

pytestmark = pytest.mark.oracle

FORMATS = {"a.ply": {"encoding": "ascii"}, "l.ply": {"encoding": "little"}, "b.ply": {"encoding": "big"}, "a.obj": {}}
TEXTURED = {**SHINY, "texture": "texture.png", "scaleU": 1.7, "scaleV": 1.3, "texturefilter": "bilinear"}
CHECKER = {**SHINY, "texture": {"type": "checkerboard", "scale": 4.0}}
TURN = {"rotate": {"axis": [0.3, 1.0, -0.5], "angle": 70.0}}
STRETCH = {"scale": [0.5, 1.1, 0.8]}
MOVES = {
    "turned": [TURN],
    "stretched_then_turned": [STRETCH, TURN],
    "turned_then_stretched": [TURN, STRETCH, {"translate": [0.2, -0.1, 0.3]}],
    "mirrored": [TURN, {"scale": [-0.8, 0.6, 1.0]}],
    "mirrored_twice": [{"scale": [-0.8, 1.0, 1.0]}, TURN, {"scale": [0.9, -0.6, 1.0]}],
    "inverted": [STRETCH, {"scale": -0.9}],
    "sheared": [{"matrix": [0.8, 0.4, 0, 0.1, 0, 0.7, 0, 0, 0, -0.3, 0.9, 0.2, 0, 0, 0, 1]}],
}
BALL = {"type": "sphere", "center": [-1.3, 0.1, -0.6], "radius": 0.5, "material": {"diffusecolor": [0.2, 0.5, 0.9]}}
BACK = {"type": "sphere", "center": [0.3, 0.2, 0.1], "radius": 8.0, "material": {"texture": "texture.png", "ks": 0.0}}


def some(model, with_normals, with_uv=True):
    """Return the model with or without its normals and texture coordinates."""
    return model.but(normals=model.normals if with_normals else None, uv=model.uv if with_uv else None)


@pytest.mark.parametrize("name", FORMATS)
def test_mesh_flat(agree, tmp_path, name):
    """A file without normals has those of its triangles, in every encoding."""
    write(tmp_path / name, some(lump(), False), **FORMATS[name])
    agree(scene(mesh(name, SHINY), GROUND))


@pytest.mark.parametrize("name", FORMATS)
def test_mesh_normals_of_file(agree, tmp_path, name):
    """Normals of the file, of any length, are interpolated, and shade; hits and sides stay the triangles'."""
    write(tmp_path / name, lump(), **FORMATS[name])
    agree(scene(mesh(name, SHINY), GROUND))


@pytest.mark.parametrize("with_normals", [True, False])
@pytest.mark.parametrize("name", ["a.ply", "a.obj"])
def test_mesh_normals_computed(agree, tmp_path, name, with_normals):
    """Computed normals are weighted by angle, as Mitsuba's, whether or not the file brings others."""
    write(tmp_path / name, some(lump(), with_normals))
    agree(scene(mesh(name, SHINY, normals="smooth"), GROUND))


@pytest.mark.parametrize("normals", ["file", "smooth"])
def test_mesh_with_creases(agree, tmp_path, normals):
    """Where the faces of an OBJ file share positions and not normals, neither smooths across the edge."""
    lines = [f"v {x} {y} {z}" for x in (-0.6, 0.5) for y in (-0.5, 0.6) for z in (-0.7, 0.4)]
    lines += ["vn -1 0 0.1", "vn 1 0 0", "vn 0 -1 0", "vn 0.1 1 0", "vn 0 0.2 -1", "vn 0 0 1"]
    faces = (1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)
    lines += ["f " + " ".join(f"{v}//{n}" for v in face) for n, face in enumerate(faces, 1)]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    agree(scene(mesh("a.obj", SHINY, TURN, normals=normals), GROUND))


@pytest.mark.parametrize("name", ["a.ply", "a.obj"])
def test_mesh_flat_in_spite_of_normals(agree, tmp_path, name):
    """The file's normals can be put aside."""
    write(tmp_path / name, lump())
    agree(scene(mesh(name, SHINY, normals="flat"), GROUND))


@pytest.mark.parametrize("normals", ["file", "smooth", "flat"])
@pytest.mark.parametrize("move", MOVES)
def test_mesh_transform(agree, tmp_path, move, normals):
    """Steps are applied in their order; normals stay perpendicular, and point outwards also where mirrored."""
    write(tmp_path / "a.ply", lump())
    agree(scene(mesh("a.ply", CHECKER, *MOVES[move], normals=normals), GROUND))


@pytest.mark.parametrize("settings", [{"texturefilter": "nearest"}, {}, {"texturewrap": "clamp"}])
@pytest.mark.parametrize("name", ["a.ply", "a.obj"])
def test_mesh_texture(agree, tmp_path, name, settings):
    """A picture lies on a mesh as the file's texture coordinates say, upright in either format."""
    write(tmp_path / name, lump())
    agree(scene(mesh(name, {**TEXTURED, **settings}, TURN), GROUND))


@pytest.mark.parametrize("steps", [[], [{"scale": [-1, 1, 1]}]])
@pytest.mark.parametrize("beside", [True, False])
def test_mesh_texture_without_coordinates(agree, tmp_path, steps, beside):
    """Each triangle of a mesh without texture coordinates has those of a triangle, whatever other meshes have."""
    write(tmp_path / "a.ply", some(lump(), True, False))
    write(tmp_path / "b.ply", lump(100))
    large = {**TEXTURED, "scaleU": 0.7, "scaleV": 0.5}  # a triangle is small, and has much of the texture
    other = [mesh("b.ply", TEXTURED, {"scale": 0.5}, {"translate": [-1.3, 0, 0]})] if beside else []
    agree(scene(mesh("a.ply", large, {"scale": 0.8}, *steps), *other))


def test_mesh_of_polygons(agree, tmp_path):
    """Quads and a pentagon of an OBJ file are fans around their first corners; flat ones, because fans may differ."""
    corners = [(-1, -0.6, 0.2), (0.1, -0.7, -0.3), (0.2, 0.5, 0.1), (-0.9, 0.6, 0.5), (1.1, -0.5, 0.4), (1.3, 0.3, 0.2),
               (0.8, 0.9, 0.0)]  # fmt: skip
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f 1 2 3 4", "f 2 5 6 7 3"]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    agree(scene(mesh("a.obj", SHINY), GROUND))


@pytest.mark.parametrize("normals", ["file", "flat"])
def test_mesh_with_degenerate_faces(agree, tmp_path, normals):
    """Faces that repeat a corner, lie on a line or on another face change nothing.

    Not for computed normals: Mitsuba 3.9.1 gives up a vertex, as (1, 0, 0), around which there are several such faces.
    """
    model = lump()
    ends = model.faces[:10, :2]
    middles = len(model.vertices) + np.arange(len(ends))
    more = model.faces[:20, [0, 0, 1]], model.faces[:10, [0, 1, 1]], np.column_stack([ends, middles]), model.faces[:5]
    grown = (np.concatenate([rows, rows[ends].mean(axis=1)]) for rows in (model.vertices, model.normals, model.uv))
    vertices, bent, uv = grown
    write(tmp_path / "a.ply", Model(vertices, np.concatenate([model.faces, *more]), bent, uv))
    agree(scene(mesh("a.ply", SHINY, normals=normals), GROUND))


def test_mesh_seen_from_inside(agree, tmp_path):
    """From inside, normals still point outwards, and the inner side is lit."""
    write(tmp_path / "a.ply", lump())
    camera = {"position": [0.1, 0.1, -0.1], "lookAt": [0.7, 0.3, 0.5], "fov": 90.0}
    agree(scene(mesh("a.ply", SHINY), camera=camera, lights=[([0.0, 0.15, 0.05], [1.0, 0.9, 0.8])]))


def test_mesh_that_is_open(agree, tmp_path):
    """A sheet is lit from both sides, and its windings tell which is its front."""
    model = lump(800)
    near = (model.vertices[model.faces].mean(axis=1) @ [0.2, 0.3, 1.0]) > 0.1  # half of it, cut off at the front
    write(tmp_path / "a.ply", model.but(faces=model.faces[near]))
    agree(scene(mesh("a.ply", SHINY), GROUND))


@pytest.mark.parametrize("normals", ["file", "smooth", "flat"])
def test_mesh_as_mirror(agree, tmp_path, normals):
    """A mesh mirrors what is around it, itself included."""
    write(tmp_path / "a.ply", lump())
    agree(scene(mesh("a.ply", MIRROR, TURN, normals=normals), BALL, BACK, nbounces=2), ("rgb",))


@pytest.mark.parametrize("normals", ["file", "flat"])
def test_mesh_as_glass(agree, tmp_path, normals):
    """A closed mesh as glass splits and bends light; where interpolated normals serve, so does their side."""
    write(tmp_path / "a.ply", lump())
    glass = {**GLASS, "refractiveindex": 1.2}
    agree(scene(mesh("a.ply", glass, TURN, normals=normals), BALL, BACK, nbounces=3), ("rgb",))


def test_mesh_beside_other_shapes(agree, tmp_path):
    """Every kind of shape, two meshes and a mesh used twice, in and behind each other, in mixed order."""
    write(tmp_path / "a.ply", lump())
    write(tmp_path / "b.obj", some(lump(800), False))
    others = [shape(name, {**WHITE, "diffusecolor": [0.1 * k, 0.5, 1 - 0.1 * k]}) for k, name in enumerate(SHAPES)]
    small = {"scale": 0.45}
    meshes = [mesh("a.ply", SHINY, small, {"translate": [-1.2, 0.3, -0.6]}),
              mesh("b.obj", MIRROR, small, {"translate": [1.2, -0.1, -0.9]}),
              mesh("a.ply", TEXTURED, small, STRETCH, {"translate": [0.3, 1.0, -0.3]})]
    agree(scene(meshes[0], *others[:3], meshes[1], *others[3:], meshes[2], GROUND))


def triangles(model, material):
    """Return a model as the documents of loose triangles."""
    uv = np.full((len(model.vertices), 2), 0.5) if model.uv is None else model.uv
    return [{"type": "triangle", **{f"v{k}": model.vertices[v].tolist() for k, v in enumerate(face)},
             **{f"uv{k}": uv[v].tolist() for k, v in enumerate(face)}, "material": material} for face in model.faces]


def loose(count):
    """Return many triangles at any angle, in three materials, the last of which is textured."""
    vertices, faces = mesh_scenes.soup(count)
    uv = np.random.default_rng(1).uniform(-0.5, 1.5, (len(vertices), 2))
    documents = triangles(Model(vertices.astype(np.float64), faces, uv=uv), SHINY)
    for k, document in enumerate(documents):
        document["material"] = (SHINY, WHITE, TEXTURED)[k % 3]
    return documents


def test_soup_of_triangles(agree):
    """Some thousand triangles of a scene file: each hit, number, distance, texture and shadow."""
    agree(scene(*loose(3000), GROUND))


def test_soup_among_other_shapes(agree, tmp_path):
    """Triangles, solids and a mesh share a hierarchy, and keep their numbers."""
    write(tmp_path / "a.ply", lump(100))
    balls = [{"type": "sphere", "center": p.tolist(), "radius": 0.08, "material": SHINY}
             for p in np.random.default_rng(3).uniform(-1, 1, (40, 3))]
    soup = loose(500)
    agree(scene(*soup[:200], *balls, mesh("a.ply", WHITE, {"scale": 0.4}), *soup[200:], shape("cylinder"), GROUND))


def test_loose_triangles_are_the_mesh(tmp_path):
    """A mesh as loose triangles gives the same picture, up to rounding of texture coordinates."""
    model = lump()
    write(tmp_path / "a.ply", model)
    write_texture(tmp_path / "texture.png")
    pictures = []
    for shapes in ([mesh("a.ply", TEXTURED, normals="flat")], triangles(model, TEXTURED)):
        loaded = sides.prepare(sides.write(tmp_path, scene(*shapes, GROUND)))
        pictures.append(sides.observe(loaded, "rgb"))
    assert np.abs(pictures[0] - pictures[1]).max() < 1e-4


def test_teapot(root):
    """The teapot scene: 12,432 triangles with analytic normals, half a mirror, on a floor that mirrors a little."""
    loaded = sides.prepare(root / "scenes" / "teapot.json", 300, 200)
    oracle = sides.oracle(loaded)
    for name in (*GEOMETRY, "rgb"):
        oracle.check(name, sides.observe(loaded, name))


def test_scene_files_name_meshes_that_are_there(root):
    """No scene that ships needs a file from elsewhere."""
    for path in (root / "scenes").rglob("*.json"):
        for document in json.loads(path.read_text()).get("scene", {}).get("shapes", ()):
            if document["type"] == "mesh":
                assert (path.parent / document["filename"]).is_file(), path
