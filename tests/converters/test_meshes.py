"""Mesh files in the export: Mitsuba reads the file itself, and gets each combination of normals and mirrors right."""

import importlib
import re
import shutil

import mitsuba as mi
import numpy as np
import pytest

from converters import meshes, whitted
from converters import mitsuba as export
from renderer.scene import schema, transform
from renderer.scene.loader import override
from tests.support import oracle as sides
from tests.support.documents import GROUND, SHINY, scene, write_texture
from tests.support.meshes import lump, mesh, write

pytestmark = pytest.mark.oracle

SIZE = 90, 60
TURN, MIRROR = {"rotate": {"axis": [0.3, 1.0, -0.5], "angle": 70.0}}, {"scale": [-0.8, 0.6, 1.0]}
MOVES = {"straight": [TURN], "mirrored": [TURN, MIRROR]}
CASES = [(name, brings, normals, move) for name in ("a.ply", "a.obj") for brings in (True, False)
         for normals in ("file", "smooth", "flat") for move in MOVES]  # fmt: skip
TEXTURED = {**SHINY, "texture": "texture.png"}


def prepare(folder, document, mode):
    """Return the loaded document at the size of these tests."""
    write_texture(folder / "texture.png")
    return override(sides.prepare(sides.write(folder, document), *SIZE, mode=mode), samples=1)


def case(folder, name, brings, normals, move, mode="normals"):
    """Return the loaded scene of a mesh that brings normals or not."""
    model = lump()
    write(folder / name, model if brings else model.but(normals=None))
    return prepare(folder, scene(mesh(name, TEXTURED, *MOVES[move], normals=normals), GROUND), mode)


def normals_of(described):
    """Return the geometric and the shading normals that Mitsuba sees in a scene of its own, (H, W, 3) each."""
    integrator = mi.load_dict({"type": "aov", "aovs": "geometric:geo_normal,shading:sh_normal"})
    picture = np.array(mi.render(described, integrator=integrator), dtype=np.float64)
    return picture[..., -6:-3], picture[..., -3:]


@pytest.mark.parametrize(("name", "brings", "normals", "move"), CASES)
def test_xml_is_the_dictionary(tmp_path, name, brings, normals, move):
    """The XML with its copy of the mesh has the dictionary's normals of either kind, and the exact counterpart's."""
    loaded = case(tmp_path, name, brings, normals, move)
    export.write_xml(loaded, tmp_path / "scene.xml")
    from_dict, from_xml = mi.load_dict(export.to_dict(loaded)), mi.load_file(str(tmp_path / "scene.xml"))
    where = ~whitted.mask_uncertain(loaded, edges=True)
    (ours, shading), (theirs, theirs_shading) = normals_of(from_dict), normals_of(from_xml)
    assert np.abs(ours - theirs)[where].max() < 1e-5 and np.abs(shading - theirs_shading)[where].max() < 1e-5
    assert np.abs(ours - whitted.reference(loaded)["normal"])[where].max() < 2e-3
    shaded_flat = normals == "flat" or normals == "file" and not brings
    difference = np.abs(ours - shading)[where]
    assert difference.max() < 1e-5 if shaded_flat else difference.max() > 0.1


@pytest.mark.parametrize(("name", "brings", "normals", "move"), CASES)
def test_normals_point_outwards(tmp_path, name, brings, normals, move):
    """Seen from outside, both kinds of normals of a closed mesh face the camera, mirrored or not."""
    loaded = case(tmp_path, name, brings, normals, move)
    geometric, shading = normals_of(mi.load_dict(export.to_dict(loaded)))
    reference = whitted.reference(loaded)
    on_mesh = reference["shape"] == 0
    rays = whitted.Counterpart(loaded, whitted.OFFSET).camera_rays()[1].numpy().T.reshape(SIZE[1], SIZE[0], 3)
    assert ((geometric * rays).sum(-1)[on_mesh] < 0).all()
    assert ((shading * rays).sum(-1)[on_mesh] < 0.1).mean() > 0.99


def test_xml_can_be_moved(tmp_path):
    """The mesh lies beside the XML: neither the scene's folder nor the current one counts."""
    loaded = case(tmp_path, "a.obj", True, "file", "straight", "albedo")
    export.write_xml(loaded, tmp_path / "out.xml")
    before = np.array(mi.render(mi.load_file(str(tmp_path / "out.xml"))))
    (tmp_path / "else").mkdir()
    shutil.move(tmp_path / "out.xml", tmp_path / "else")
    shutil.move(tmp_path / "out_files", tmp_path / "else")
    (tmp_path / "a.obj").unlink()
    assert np.array_equal(before, np.array(mi.render(mi.load_file(str(tmp_path / "else" / "out.xml")))))
    assert before.std() > 0.01


def test_a_mesh_used_twice_is_copied_once(tmp_path):
    """Also where several scenes' meshes have one name; different ones stay apart."""
    write(tmp_path / "a.ply", lump())
    (tmp_path / "other").mkdir()
    write(tmp_path / "other" / "a.ply", lump(50))
    shapes = [mesh("a.ply", SHINY), mesh("a.ply", SHINY, TURN), mesh("other/a.ply", SHINY)]
    export.write_xml(prepare(tmp_path, scene(*shapes), "normals"), tmp_path / "out.xml")
    assert sorted(path.name for path in (tmp_path / "out_files").iterdir()) == ["a.ply", "a_1.ply"]
    assert re.findall(r'filename" value="(\S+)"', (tmp_path / "out.xml").read_text()) == [
        "out_files/a.ply", "out_files/a.ply", "out_files/a_1.ply"]


@pytest.mark.parametrize(("pattern", "replacement"), [
    (r'name="face_normals" value="false"', 'name="face_normals" value="true"'),
    (r'name="flip_normals" value="true"', 'name="flip_normals" value="false"'),
    (r'(type="ply"(?:.*\n){2}.*<matrix value=")(\S+)', r"\g<1>0.1"),
])
def test_changed_xml_is_another_mesh(tmp_path, pattern, replacement):
    """The comparison above sees other normals, and another place."""
    loaded = case(tmp_path, "a.ply", True, "file", "mirrored")
    path = tmp_path / "scene.xml"
    export.write_xml(loaded, path)
    text, count = re.subn(pattern, replacement, path.read_text())
    assert count, "nothing was changed"
    path.write_text(text)
    pairs = zip(normals_of(mi.load_file(str(path))), normals_of(mi.load_dict(export.to_dict(loaded))))
    assert any((np.abs(a - b) > 0.01).mean() > 0.05 for a, b in pairs)


def test_placement_is_the_renderers():
    """Two ways to the matrix of random steps, which share nothing."""
    rng = np.random.default_rng(5)
    for _ in range(50):
        rotation = schema.Rotation(axis=tuple(rng.normal(size=3)), angle=float(rng.uniform(-400, 400)))
        steps = (schema.Step(scale=tuple(rng.uniform(-2, 2, 3))), schema.Step(translate=tuple(rng.normal(size=3))),
                 schema.Step(rotate=rotation),
                 schema.Step(matrix=(*rng.normal(size=12), 0.0, 0.0, 0.0, 1.0)))
        steps = tuple(steps[k] for k in rng.permutation(4))
        assert np.allclose(meshes.placement(steps), transform.matrix(steps), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("name", "text", "expected"), [
    ("a.obj", "v 0 0 0\nvn 0 0 1\nf 1//1 1//1 1//1\n", True),
    ("a.obj", "v 0 0 0\nvt 0 0\nvn 0 0 1\n  f 1/1/-1 1/1/1 1/1/1\n", True),
    ("a.obj", "v 0 0 0\nvt 0 0\nvn 0 0 1\nf 1/1 1/1 1/1\n", False),  # declared, but of no corner
    ("a.obj", "v 0 0 0\n# f 1//1 1//1 1//1\nf 1 1 1\n", False),
    ("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float nx\nend_header\n", True),
    ("a.PLY", "ply\r\nformat ascii 1.0\r\nelement vertex 1\r\nproperty double nx\r\nend_header\r\n", True),
    ("a.ply", "ply\nelement vertex 1\nproperty float x\nend_header\nproperty float nx\n", False),
])
def test_normals_of_a_file_are_noticed(tmp_path, name, text, expected):
    """Whatever else the file has."""
    (tmp_path / name).write_bytes(text.encode())
    assert meshes.mesh_file(schema.Mesh(filename=name), tmp_path.joinpath).has_normals is expected


def renumbered(shapes):
    """Return shape numbers in order of first appearance: Mitsuba numbers them as it happens to load them."""
    _, first, inverse = np.unique(shapes, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse.ravel()]


@pytest.mark.parametrize(("mode", "shapes"), [("uv", 2), ("normals", 2), ("albedo", 2), ("shapes", 100)])
def test_many_triangles_are_a_mesh_for_each_material(tmp_path, monkeypatch, mode, shapes):
    """They give the picture that they give one by one; numbers of shapes need them apart."""
    rng, soup = np.random.default_rng(2), []
    for k in range(100):
        corners = dict(zip(("v0", "v1", "v2"), (rng.uniform(-1, 1, 3) + rng.normal(size=(3, 3)) / 3).tolist()))
        uv = {"uv0": rng.uniform(size=2).tolist()}
        soup.append({"type": "triangle", **corners, **uv, "material": (SHINY, TEXTURED)[k % 2]})
    loaded = prepare(tmp_path, scene(*soup), mode)
    plan, pictures = importlib.import_module("converters.mitsuba.plan"), []  # the package has a function of that name
    for most, count in ((plan.SOUP, shapes), (1000, 100)):
        monkeypatch.setattr(plan, "SOUP", most)
        export.write_xml(loaded, tmp_path / "scene.xml")
        assert (tmp_path / "scene.xml").read_text().count("<shape ") == count
        picture = np.array(mi.render(mi.load_file(str(tmp_path / "scene.xml"))))
        pictures.append(renumbered(picture) if mode == "shapes" else picture)
    assert pictures[0].std() > 0.01 and np.array_equal(*pictures)


def test_a_remark_about_many_shapes_is_short(tmp_path):
    """It names the first places, and tells how many there are beside."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1.0, "material": SHINY}
    warnings = [str(w) for w in export.write_xml(prepare(tmp_path, scene(*[ball] * 30), "phong"), tmp_path / "a.xml")]
    assert sum("scene.shapes[7] and 22 more: " in warning for warning in warnings) == 1


def test_stock_picture_of_a_mesh_is_about_as_bright(root):
    """The light without fall-off is replaced by one that is as bright at the mesh's middle."""
    loaded = sides.prepare(root / "scenes" / "features" / "shape_mesh.json", *SIZE)
    stock, exact = np.array(mi.render(mi.load_dict(export.to_dict(loaded)))), whitted.reference(loaded)
    ratio = stock[exact["shape"] == 1].mean() / exact["rgb"][exact["shape"] == 1].mean()
    assert 0.6 < ratio < 1.6


def test_light_is_as_bright_at_the_mesh_as_it_was(tmp_path):
    """Where the transformation has brought it: 20 units away, the intensity is pi times 20 squared."""
    write(tmp_path / "a.ply", lump(800))
    placed = mesh("a.ply", SHINY, {"translate": [0, 0, 10]}, {"scale": 2})
    loaded = prepare(tmp_path, scene(placed, lights=[([0, 0, 0], [1, 1, 1])]), "phong")
    light = mi.traverse(mi.load_dict(export.to_dict(loaded)["light0"]))
    (intensity,) = {float(x) for x in np.ravel(light["intensity.value"])}
    assert intensity == pytest.approx(np.pi * 400, rel=0.02)
