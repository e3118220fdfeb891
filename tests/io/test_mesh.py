"""Meshes from good files, in every form that the formats allow; expected values are written out by hand."""

import itertools
import struct

import numpy as np
import pytest

from renderer.io import mesh_obj, mesh_ply
from renderer.io.mesh import LARGEST, read_mesh
from renderer.scene import values

POSITIONS = [[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0], [-1, 1.5, 0.25]]
NORMALS = [[0, 0, 1], [0, 1, 0], [1, 0, 0], [0, 0, -1], [0, 0.6, 0.8]]
UV = [[0, 0], [1, 0], [1, 0.75], [0, 0.75], [0.5, 0.5]]
POLYGONS = [[0, 1, 2, 3, 4], [4, 3, 2], [0, 1, 2, 3]]
SOME_POLYGONS = [POLYGONS, POLYGONS[:1], POLYGONS[1:2] * 3]
FANS = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [4, 3, 2], [0, 1, 2], [0, 2, 3]]
ORDERS = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}
ROWS = [[*position, *normal, *uv] for position, normal, uv in zip(POSITIONS, NORMALS, UV, strict=True)]
VERTEX = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]


def ply(polygons, file_format, kind="float", index="int", length="uchar", extra=False, vertex=VERTEX, rows=ROWS):
    """Return the bytes of a PLY file; `extra` puts elements and properties around what is read."""
    lines = ["ply", f"format {file_format} 1.0", "comment caf\xe9", f"element vertex {len(rows)}"]
    lines += [f"property {kind} {name}" for name in vertex]
    lines += ["element camera 2", "property short a", "property list uchar double b"] if extra else []
    lines += [f"element face {len(polygons)}"]
    lines += ["property uchar flag", "property list ushort float texcoord"] if extra else []
    lines += [f"property list {length} {index} vertex_indices"] + (["property double quality"] if extra else [])
    lines += ["end_header", ""]
    cameras = [[7, 1, 0.5], [8, 2, 0.5, 0.25]] if extra else []
    order = ORDERS[file_format]
    if order is None:
        body = "".join(" ".join(map(str, row)) + "\n" for row in [*rows, *cameras]).encode()
        for polygon in polygons:
            around = ("1 2 0.5 0.5 ", " 0.125") if extra else ("", "")
            body += f"{around[0]}{len(polygon)} {' '.join(map(str, polygon))}{around[1]}\n".encode()
        return "\n".join(lines).encode("latin-1") + body
    codes = {"float": "f", "double": "d", "int": "i", "uint": "I", "uchar": "B", "short": "h", "ushort": "H"}
    body = b"".join(struct.pack(f"{order}{len(vertex)}{codes[kind]}", *row) for row in rows)
    body += b"".join(struct.pack(f"{order}hB{len(row) - 2}d", *row) for row in cameras)
    for polygon in polygons:
        body += struct.pack(f"{order}BHff", 1, 2, 0.5, 0.5) if extra else b""
        body += struct.pack(f"{order}{codes[length]}{len(polygon)}{codes[index]}", len(polygon), *polygon)
        body += struct.pack(f"{order}d", 0.125) if extra else b""
    return "\n".join(lines).encode("latin-1") + body


@pytest.fixture
def read(tmp_path):
    """A function that reads the mesh in the given bytes or text, as a file of that extension."""

    def reading(extension, content):
        path = tmp_path / f"mesh{extension}"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_mesh(path)

    return reading


def assert_is(mesh, positions, faces, normals=None, uv=None):
    """Check a mesh against lists, and what MeshData promises of its types."""
    assert mesh.vertices.dtype in (np.float32, np.float64) and mesh.faces.dtype == np.uint32
    np.testing.assert_array_equal(mesh.vertices, positions)
    np.testing.assert_array_equal(mesh.faces, faces)
    for rows, expected in ((mesh.normals, normals), (mesh.uv, uv)):
        if expected is None:
            assert rows is None
        else:
            assert rows.dtype == np.float32
            np.testing.assert_array_equal(rows, np.float32(expected))


@pytest.mark.parametrize("extra", [False, True], ids=["plain", "with foreign elements and properties"])
@pytest.mark.parametrize("polygons", SOME_POLYGONS, ids=["mixed", "pentagon", "triangles"])
@pytest.mark.parametrize("file_format", ORDERS)
def test_ply_reads_as_written(read, file_format, polygons, extra):
    """Polygons of equal and of different lengths become fans; what is not ours is stepped over."""
    fans = {1: FANS[:3], 3: FANS if polygons is POLYGONS else [[4, 3, 2]] * 3}[len(polygons)]
    assert_is(read(".ply", ply(polygons, file_format, extra=extra)), POSITIONS, fans, NORMALS, UV)


@pytest.mark.parametrize("file_format, kind, index, length", [*itertools.product(
    ORDERS, ("float", "double"), ("int", "uint", "ushort"), ("uchar", "int"))])
def test_ply_types_are_honoured(read, file_format, kind, index, length):
    """Positions keep the precision of the file, whatever the types of the indices."""
    mesh = read(".ply", ply(POLYGONS, file_format, kind, index, length))
    assert_is(mesh, POSITIONS, FANS, NORMALS, UV)
    assert mesh.vertices.dtype == {"float": np.float32, "double": np.float64}[kind]


@pytest.mark.parametrize("names", mesh_ply.UV_NAMES)
def test_ply_names_of_uv_are_known(read, names):
    """Writers differ about the names of texture coordinates; v is taken as it is."""
    rows = [[*position, *uv] for position, uv in zip(POSITIONS, UV, strict=True)]
    content = ply(POLYGONS, "ascii", vertex=["x", "y", "z", *names], rows=rows)
    assert_is(read(".ply", content), POSITIONS, FANS, None, UV)


@pytest.mark.parametrize("file_format", ORDERS)
def test_ply_needs_positions_only(read, file_format):
    """Two of three components of a normal are none."""
    rows = [[*position, 0, 1] for position in POSITIONS]
    content = ply(POLYGONS, file_format, vertex=["x", "y", "z", "nx", "ny"], rows=rows)
    assert_is(read(".ply", content), POSITIONS, FANS)


def test_ply_lines_mean_nothing(read):
    """In an ASCII file, blanks and line ends separate alike; lines of the header may end like Windows'."""
    head, body = ply(POLYGONS, "ascii").split(b"end_header\n")
    content = head.replace(b"\n", b"\r\n") + b"end_header\r\n" + b"\t".join(body.split())
    assert_is(read(".ply", content), POSITIONS, FANS, NORMALS, UV)


def test_ply_survives_the_way_to_a_file_and_back(tmp_path):
    """What `write` writes, `read_mesh` reads."""
    mesh_ply.write(tmp_path / "x.ply", *map(np.array, (POSITIONS, FANS, NORMALS, UV)), ["a remark"])
    assert_is(read_mesh(tmp_path / "x.ply"), POSITIONS, FANS, NORMALS, UV)
    mesh_ply.write(tmp_path / "y.ply", np.array(POSITIONS), np.array(FANS))
    assert_is(read_mesh(tmp_path / "y.ply"), POSITIONS, FANS)


def lines(word, rows):
    return "".join(f"{word} {' '.join(map(str, row))}\n" for row in rows)


V, VT, VN = lines("v", POSITIONS), lines("vt", UV), lines("vn", NORMALS)
UPRIGHT = [[u, 1 - v] for u, v in UV]
CORNERS = {  # form of a corner of vertex i (from 1): which of uv and normals it names
    "{0}": (False, False), "{0}/{0}": (True, False), "{0}//{0}": (False, True), "{0}/{0}/{0}": (True, True)}


def faces(form, polygons):
    return lines("f", [[form.format(index + 1) for index in polygon] for polygon in polygons])


@pytest.mark.parametrize("polygons", SOME_POLYGONS, ids=["mixed", "pentagon", "triangles"])
@pytest.mark.parametrize("form", CORNERS)
def test_obj_reads_as_written(read, form, polygons):
    """Each form of a corner; v runs upwards in the file and downwards here; tables that no face names are no part."""
    has_uv, has_normals = CORNERS[form]
    mesh = read(".obj", V + VT + VN + faces(form, polygons))
    fans = {1: FANS[:3], 3: FANS if polygons is POLYGONS else [[4, 3, 2]] * 3}[len(polygons)]
    assert_is(mesh, POSITIONS, fans, NORMALS if has_normals else None, UPRIGHT if has_uv else None)
    assert mesh.vertices.dtype == np.float64


SEPARATE = "f 1/1/3 2/2/3 3/1/3\nf 1/1/3 3/1/3 4/4/3\nf 1/5/3 3/1/3 4/4/3\n"


@pytest.mark.parametrize("prefix", ["", "  # an unusual place\n"], ids=["at once", "line by line"])
def test_obj_indices_of_their_own_make_vertices(read, prefix):
    """There is one vertex for each different v/vt/vn, and none for what no face names."""
    mesh = read(".obj", prefix + V + VT + VN + SEPARATE)
    assert len(mesh.vertices) == 5
    expected = [(POSITIONS[v - 1], UPRIGHT[t - 1]) for v, t in
                [(1, 1), (2, 2), (3, 1), (1, 1), (3, 1), (4, 4), (1, 5), (3, 1), (4, 4)]]
    corners = mesh.faces.reshape(-1)
    np.testing.assert_array_equal(mesh.vertices[corners], [position for position, _ in expected])
    np.testing.assert_array_equal(mesh.uv[corners], np.float32([uv for _, uv in expected]))
    np.testing.assert_array_equal(mesh.normals[corners], [NORMALS[2]] * 9)


SAME_MESH = {
    "relative indices": V + VT + VN
        + "f -5/-5/-5 -4/-4/-4 -3/-3/-3 -2/-2/-2 -1/-1/-1\nf 5/5/5 4/4/4 3/3/3\nf 1/1/1 2/2/2 3/3/3 4/4/4\n",
    "Windows": (V + VT + VN + faces("{0}/{0}/{0}", POLYGONS)).replace("\n", "\r\n"),
    "old Macintosh": (V + VT + VN + faces("{0}/{0}/{0}", POLYGONS)).replace("\n", "\r"),
    "byte order mark": "\ufeff" + V + VT + VN + faces("{0}/{0}/{0}", POLYGONS),
    "no last line end": (V + VT + VN + faces("{0}/{0}/{0}", POLYGONS)).rstrip(),
    "blanks": ("\n\n" + V + VT + VN + faces("{0}/{0}/{0}", POLYGONS)).replace(" ", " \t ").replace("\n", "  \n"),
    "trailing blanks": (V + VT + VN + faces("{0}/{0}/{0}", POLYGONS)).replace("\n", " \n"),
    "groups and materials": "mtllib a.mtl\n" + V + VT + VN + "".join(
        f"o part{i}\ng x y\nusemtl red\ns off\n{line}\n"
        for i, line in enumerate(faces("{0}/{0}/{0}", POLYGONS).splitlines())),
    "comments": "# v 1 2 3\n" + (V + VT + VN + faces("{0}/{0}/{0}", POLYGONS)).replace("\n", " # why\n"),
    "a line that goes on": V + VT + VN + faces("{0}/{0}/{0}", POLYGONS).replace(" 3/3/3", " \\\n3/3/3"),
    "weights and colours": lines("v", [[*p, 1] for p in POSITIONS[:2]] + [[*p, 0.5, 0.5, 0.5] for p in POSITIONS[2:]])
        + lines("vt", [[*uv, 0.5] for uv in UV]) + VN + faces("{0}/{0}/{0}", POLYGONS),
    "colours": lines("v", [[*p, 0.5, 0.5, 0.5] for p in POSITIONS]) + VT + VN + faces("{0}/{0}/{0}", POLYGONS),
    "taking turns": "".join(lines(word, [row]) for rows in zip(POSITIONS, UV, NORMALS, strict=True)
                            for word, row in zip(("v", "vt", "vn"), rows, strict=True))
        + faces("{0}/{0}/{0}", POLYGONS),
    "faces first": faces("{0}/{0}/{0}", POLYGONS) + V + VT + VN,
    "points and lines": V + VT + VN + "p 1 2\nl 1 2 3\n" + faces("{0}/{0}/{0}", POLYGONS),
}


@pytest.mark.parametrize("name", SAME_MESH)
def test_obj_may_be_written_in_many_ways(read, name):
    """Each is the same mesh."""
    assert_is(read(".obj", SAME_MESH[name]), POSITIONS, FANS, NORMALS, UPRIGHT)


def test_obj_corner_without_its_uv_gets_zero(read):
    """Where only some faces have texture coordinates and normals, the others get (0, 0) and no direction."""
    mesh = read(".obj", V + VT + VN + "f 1/2/1 2/2/1 3/2/1\nf 4 5 1\n")
    np.testing.assert_array_equal(mesh.uv[mesh.faces[1]], np.zeros((3, 2)))
    np.testing.assert_array_equal(mesh.normals[mesh.faces[1]], np.zeros((3, 3)))
    np.testing.assert_array_equal(mesh.normals[mesh.faces[0]], [NORMALS[0]] * 3)


@pytest.mark.parametrize("name", [*CORNERS, *SAME_MESH])
def test_obj_is_the_same_at_once_and_line_by_line(name):
    """The two ways to read a file are told apart by nothing but their speed."""
    data = (V + VT + VN + faces(name, POLYGONS[:1] * 3) if name in CORNERS else SAME_MESH[name]).encode()
    try:
        at_once = mesh_obj._at_once(data)
    except mesh_obj._Unusual:
        assert name in SAME_MESH
        return
    rows, corners, counts = mesh_obj._line_by_line(data)
    for word in rows:
        np.testing.assert_array_equal(at_once[0][word], rows[word])
    for given, expected in zip(at_once[1], corners, strict=True):
        np.testing.assert_array_equal(given, expected)
    np.testing.assert_array_equal(at_once[2], counts)


def test_usual_obj_files_are_read_at_once():
    """Otherwise the test above would compare nothing."""
    for form in CORNERS:
        mesh_obj._at_once((V + VT + VN + faces(form, POLYGONS[:1] * 3)).encode())


def test_triangles_without_area_stay(read):
    """A repeated corner, and corners on a line."""
    mesh = read(".obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n")
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 0, 1]])


def test_lengths_are_limited_as_in_scene_files():
    """A vertex may be where a sphere's centre may be."""
    assert LARGEST == values.LARGEST


@pytest.mark.oracle
@pytest.mark.parametrize("extension, content", [
    (".ply", ply([[0, 1, 2], [4, 3, 2]], "binary_little_endian")), (".ply", ply([[0, 1, 2], [4, 3, 2]], "ascii")),
    (".obj", V + VT + VN + SEPARATE), (".obj", V + VT + VN + faces("{0}/{0}/{0}", POLYGONS[1:])),
], ids=["binary ply", "ascii ply", "obj with separate indices", "obj"])
def test_mitsuba_reads_the_same(tmp_path, extension, content):
    """Corner by corner, its loaders find the same positions, normals and texture coordinates."""
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant("llvm_ad_rgb")  # as the converters do
    path = tmp_path / f"mesh{extension}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    ours = read_mesh(path)
    theirs = mi.traverse(mi.load_dict({"type": extension[1:], "filename": str(path)}))
    corners = np.array(theirs["faces"])
    for name, rows, width in (("vertex_positions", ours.vertices, 3), ("vertex_normals", ours.normals, 3),
                              ("vertex_texcoords", ours.uv, 2)):
        expected = np.array(theirs[name]).reshape(-1, width)[corners]
        np.testing.assert_allclose(rows[ours.faces.reshape(-1)], expected, atol=1e-6)
