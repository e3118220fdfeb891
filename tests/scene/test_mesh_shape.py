"""The `mesh` shape's description: its steps, its file, its mistakes, and how other authors write it."""

import json

import pytest

from renderer.core.errors import SceneError
from renderer.scene import aliases, aliases_mesh, media, schema
from renderer.scene.loader import from_dict, load
from renderer.scene.transform import matrix

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.fixture
def mesh_scene(tmp_path, document):
    """A function that returns a document with one mesh, whose file is there, and its directory."""
    (tmp_path / "a.obj").write_text(OBJ)

    def made(**keys):
        document["scene"]["shapes"] = [{"type": "mesh", "filename": "a.obj", **keys}]
        return document, tmp_path

    return made


def read(document, directory, **options):
    """Return the only shape of a document."""
    ((_, shape),) = from_dict(document, directory=directory, **options).shapes
    return shape


def refusal(document, directory):
    """Return the only problem of a document."""
    with pytest.raises(SceneError) as caught:
        from_dict(document, directory=directory)
    (problem,) = caught.value.problems
    return problem


def test_defaults(mesh_scene):
    """A file name is enough."""
    shape = read(*mesh_scene(), strict=True)
    assert shape == schema.Mesh(filename="a.obj", transform=(), normals="file", material=schema.Material())


def test_steps_are_read_in_their_order(mesh_scene):
    """One number scales all axes."""
    steps = [{"scale": 2}, {"rotate": {"axis": [0, 0, 1], "angle": 90}}, {"translate": [1, 2, 3]},
             {"scale": [1, -1, 3]}, {"matrix": [1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]
    shape = read(*mesh_scene(transform=steps), strict=True)
    assert [step.scale for step in shape.transform] == [(2.0, 2.0, 2.0), None, None, (1.0, -1.0, 3.0), None]
    assert matrix(shape.transform) == ((0, -2, 0, 6), (-2, 0, 0, -2), (0, 0, 6, 9), (0, 0, 0, 1))


UNIT = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
MISTAKES = [
    ({"transform": [{}]}, "transform[0]", "exactly one of translate, scale, rotate and matrix must be given, none is"),
    ({"transform": [{"scale": 1}, {"scale": 1, "translate": [0, 0, 0]}]}, "transform[1]", "translate and scale are"),
    ({"transform": {"scale": 1}}, "transform", "must be a list of transformation steps, got an object"),
    ({"transform": [{"scale": 0}]}, "transform[0].scale", "must not be 0"),
    ({"transform": [{"scale": [1, 0, 1]}]}, "transform[0].scale[1]", "must not be 0, which would make everything flat"),
    ({"transform": [{"scale": 1e-30}]}, "transform[0].scale", "must be at least 1e-18 in size"),
    ({"transform": [{"scale": 1e30}]}, "transform[0].scale", "must not be beyond 1e+18"),
    ({"transform": [{"scale": "2"}]}, "transform[0].scale", "number other than 0, or three of them [x, y, z], got the"),
    ({"transform": [{"scale": [1, 2]}]}, "transform[0].scale", "or three of them [x, y, z], got a list of 2 values"),
    ({"transform": [{"scale": [1, True, 2]}]}, "transform[0].scale[1]", "must be a number, got true"),
    ({"transform": [{"rotate": {"axis": [0, 0, 0], "angle": 3}}]}, "transform[0].rotate.axis", "needs a direction"),
    ({"transform": [{"rotate": {"axis": [0, 0, 1]}}]}, "transform[0].rotate.angle", "is missing"),
    ({"transform": [{"matrix": UNIT[:15]}]}, "transform[0].matrix", "16 numbers, got a list of 15"),
    ({"transform": [{"matrix": [*UNIT[:12], 0, 0, 1, 1]}]}, "transform[0].matrix", "must end in 0, 0, 0, 1"),
    ({"transform": [{"matrix": [1, 2, 3, 0, 2, 4, 6, 0, *UNIT[8:]]}]}, "transform[0].matrix", "must be invertible"),
    ({"transform": [{"matrix": [0, 0, 0, 0, *UNIT[4:]]}]}, "transform[0].matrix", "must be invertible"),
    ({"transform": [{"scale": 1e10}, {"scale": 1e10}]}, "transform", "leads beyond 1e+18 in size"),
    ({"transform": [{"scale": 1e18}] * 30 + [{"translate": [1, 1, 1]}]}, "transform", "leads beyond 1e+18 in size"),
    ({"normals": "round"}, "normals", "unknown normals 'round'"),
    ({"filename": ""}, "filename", "must be a file name, got an empty text"),
    ({"filename": "a\0.obj"}, "filename", "must be a file name"),
    ({"filename": 3}, "filename", "must be a file name, got 3"),
]


@pytest.mark.parametrize("keys, place, told", MISTAKES)
def test_a_mistake_is_told_with_its_place(mesh_scene, keys, place, told):
    """Once, and with what is allowed."""
    problem = refusal(*mesh_scene(**keys))
    assert problem.key_path == f"scene.shapes[0].{place}"
    assert told in problem.message


@pytest.mark.parametrize("factor", [1e-9, 1.0, 1e9])
def test_small_and_large_matrices_are_invertible(mesh_scene, factor):
    """What counts is whether directions collapse, not the size."""
    entries = [factor * entry for entry in UNIT[:12]]
    assert read(*mesh_scene(transform=[{"matrix": entries + UNIT[12:]}])).transform[0].matrix[0] == factor


def test_missing_file_is_told_with_the_path_tried(mesh_scene):
    """As for textures; once for a file that several meshes name."""
    document, directory = mesh_scene(filename="gone.ply")
    document["scene"]["shapes"] *= 2
    problem = refusal(document, directory)
    assert problem.key_path == "scene.shapes[0].filename"
    assert problem.message == f"mesh 'gone.ply': no such file (tried {directory / 'gone.ply'})"
    (directory / "gone.ply").mkdir()
    assert "is a directory" in refusal(document, directory).message


def test_file_is_relative_to_the_scene(mesh_scene, tmp_path):
    """Wherever the renderer was started."""
    document, _ = mesh_scene(filename="b/a.obj")
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "a.obj").write_text(OBJ)
    (tmp_path / "s.json").write_text(json.dumps(document))
    loaded = load(tmp_path / "s.json", strict=True)
    assert loaded.resolve(loaded.shapes[0][1].filename) == tmp_path / "b" / "a.obj"


def test_a_mesh_surrounds_nothing(mesh_scene):
    """Neither light nor glass is inside of one: it need not be closed."""
    shape = read(*mesh_scene(material={"isrefractive": True, "refractiveindex": 1.5}))
    ball = schema.Sphere(center=(0.0, 0.0, 0.0), radius=0.1, material=shape.material)
    around = schema.Sphere(center=(0.0, 0.0, 0.0), radius=9.0, material=shape.material)
    assert not media.encloses(shape, [(0.2, 0.2, 0.0)])
    assert media.exterior_indices([shape, ball]) == [1.0, 1.0]
    many = [ball] * (media.FEW + 1)
    assert media.exterior_indices([shape, *many, around]) == [1.0, *[1.5] * len(many), 1.0]


# Other authors' spellings


@pytest.mark.parametrize("kind", ["mesh", "Mesh", "obj", "ply", "PLY"])
@pytest.mark.parametrize("name", ["filename", "fileName", *aliases_mesh.MESH_FILES])
def test_file_is_found_under_every_name(mesh_scene, kind, name):
    """Also with strict, because nothing is lost."""
    document, directory = mesh_scene()
    document["scene"]["shapes"] = [{"type": kind, name: "a.obj"}]
    assert read(document, directory, strict=True).filename == "a.obj"
    notes = from_dict(document, directory=directory).warnings
    assert len(notes) == (kind != "mesh") + (name != "filename") and all(note.is_note for note in notes)


def test_placed_ply_is_understood(mesh_scene):
    """Scale first, then the angles around x, y and z, then the offset; the texture is repeated."""
    document, directory = mesh_scene()
    document["scene"]["shapes"] = [
        {"type": "ply", "path": "a.obj", "offset": [1, 2, 3], "scale": [2, 3, 4], "euler": [90, 0, 90],
         "texturescale": 4}]
    shape = read(document, directory, strict=True)
    # x, twice as long, turns around z to y; y, three times as long, around x to z; z around x to -y and around z to x
    assert matrix(shape.transform) == ((0, 0, 4, 1), (2, 0, 0, 2), (0, 3, 0, 3), (0, 0, 0, 1))
    assert (shape.material.scaleU, shape.material.scaleV) == (4, 4)
    told = {note.key_path.rsplit(".")[-1]: note.message for note in from_dict(document, directory=directory).warnings}
    assert set(told) == {"type", "path", "offset", "scale", "euler", "texturescale"}
    assert told["scale"] == "understood 'scale' as a step of transform"


@pytest.mark.parametrize("name, value, place", [
    ("scale", 0, "scale"), ("scale", [1, 0, 1], "scale[1]"), ("offset", [0, 0, 1e30], "offset[2]"),
])
def test_mistake_in_a_foreign_key_is_told_there(mesh_scene, name, value, place):
    """At the key that the file has."""
    problem = refusal(*mesh_scene(**{name: value}))
    assert problem.key_path.startswith(f"scene.shapes[0].{name}")


@pytest.mark.parametrize("name, value", [("scale", "big"), ("euler", 90), ("offset", [1, 2]), ("texturescale", "a")])
def test_foreign_key_that_is_not_understood_is_no_step(mesh_scene, name, value):
    """It is told; with strict it is a mistake."""
    document, directory = mesh_scene(**{name: value})
    assert read(document, directory).transform == ()
    with pytest.raises(SceneError):
        from_dict(document, directory=directory, strict=True)


def test_meshes_are_left_out_no_more():
    """They are rendered."""
    assert not {"mesh", "ply", "obj"} & set(aliases.SHAPES_LEFT_OUT)
