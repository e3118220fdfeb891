"""Mesh files with mistakes in them: each is told in plain words with its place, at once, and takes no memory."""

import os
import struct
import time
import tracemalloc

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from renderer.core.errors import SceneError
from renderer.io.mesh import MeshData, read_mesh

HEAD = ("ply\nformat {format} 1.0\nelement vertex {v}\nproperty float x\nproperty float y\nproperty float z\n"
        "element face {f}\nproperty list uchar int vertex_indices\nend_header\n")
ROWS = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n"  # lines 10 to 13
GOOD_TEXT = (HEAD.format(format="ascii", v=4, f=2) + ROWS + "3 0 1 2\n4 0 1 3 2\n").encode()
POINTS = struct.pack("<12f", *map(float, ROWS.split()))
TRIANGLE = struct.pack("<B3i", 3, 0, 1, 2)
QUAD = struct.pack("<B4i", 4, 0, 1, 3, 2)


def text_ply(body, v=4, f=1):
    return (HEAD.format(format="ascii", v=v, f=f) + body).encode()


def binary_ply(body, v=4, f=1, order="little"):
    return HEAD.format(format=f"binary_{order}_endian", v=v, f=f).encode() + body


GOOD_BINARY = binary_ply(POINTS + TRIANGLE + QUAD, f=2)
V = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"  # lines 1 to 4
GOOD_OBJ = (V + "vt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/1\nf -1/1/1 2/2/1 3/1/1 4/1/1\nf 1 2 3\n").encode()


def header(old, new, body=ROWS + "3 0 1 2\n"):
    """Return an ASCII file whose header has something else in it."""
    text = HEAD.format(format="ascii", v=4, f=1)
    assert old in text
    return (text.replace(old, new) + body).encode()


PLY = {  # what is wrong: (content, line or 0, what the message says)
    "not a PLY file": (b"v 1 2 3\nf 1 1 1\n", 1, "first line must be 'ply', found 'v 1 2 3'"),
    "a picture": (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 1, "first line must be 'ply'"),
    "no end of header": (GOOD_TEXT[:60], 0, "no line 'end_header' among its first 60 bytes"),
    "header without end": (b"ply\n" + b"comment\n" * 200_000, 0, "no line 'end_header'"),
    "one huge line": (b"ply\ncomment " + b"x" * 10_000_000, 0, "no line 'end_header'"),
    "no format": (header("format ascii 1.0\n", ""), 0, "no line 'format'"),
    "unknown format": (header("ascii", "binary_middle_endian"), 2, "ascii, binary_little_endian, binary_big_endian"),
    "unknown version": (header("1.0", "2.0"), 2, "version 1.0"),
    "format twice": (header("format ascii 1.0\n", "format ascii 1.0\nformat ascii 1.0\n"), 3, "once"),
    "unknown header line": (header("property float y", "banana"), 5, "found 'banana'"),
    "property without element": (header("element vertex 4\n", ""), 3, "must follow the element"),
    "unknown type": (header("float y", "quad y"), 5, "unknown type 'quad' (known: char, uchar"),
    "incomplete property": (header("float y", "float"), 5, "declared as 'property type name'"),
    "property twice": (header("float y", "float x"), 5, "property 'x' is declared twice"),
    "element twice": (header("element face 1", "element vertex 1"), 7, "element 'vertex' is declared twice"),
    "no y and z": (header("property float y\nproperty float z\n", ""), 0, "no property y, z; it needs x, y and z"),
    "no faces declared": (header("element face 1\nproperty list uchar int vertex_indices\n", "", ROWS), 0,
                          "no element face"),
    "no vertices declared": (header("element vertex", "element point"), 0, "no element vertex"),
    "no corners": (header("vertex_indices", "corners"), 0, "no list property vertex_indices or vertex_index"),
    "corners that are no list": (header("list uchar int", "int"), 0, "vertex_indices of element face must be a list"),
    "corners that are fractions": (header("uchar int", "uchar float"), 0, "must be a list of whole numbers"),
    "length that is a fraction": (header("uchar int", "double int"), 8, "must be a whole number, not a double"),
    "list of a vertex": (header("property float z", "property float z\nproperty list uchar int w"), 0, "list property"),
    "rows of nothing": (header("element vertex 4", "element nothing 9999999999\nelement vertex 4"), 0, "no properties"),
    "thousands of properties": (
        header("property float z", "\n".join(f"property float p{i}" for i in range(2000))), 1003, "more than 1000"),
    "negative count": (header("vertex 4", "vertex -4"), 3, "whole number of at least 0, found '-4'"),
    "fractional count": (header("vertex 4", "vertex 4.5"), 3, "found '4.5'"),
    "enormous count": (header("vertex 4", "vertex 9" + "9" * 5000), 3, "found '9999"),
    "no vertices": (text_ply("", v=0, f=0), 0, "the file has no vertices"),
    "no faces": (text_ply(ROWS, f=0), 0, "the file has no faces"),
    "binary without faces": (binary_ply(POINTS, f=0), 0, "the file has no faces"),
    # counts that lie
    "count too large": (text_ply(ROWS + "3 0 1 2\n", v=4_000_000_000), 0, "promises 4000000000 rows"),
    "binary count too large": (binary_ply(POINTS + TRIANGLE, v=4_000_000_000), 0,
                               "promises 4000000000 rows of element vertex, which take at least 48000000000 bytes"),
    "binary face count too large": (binary_ply(POINTS + TRIANGLE, f=10**17), 0, "only 13 bytes are left"),
    "face count too large": (text_ply(ROWS + "3 0 1 2\n", f=10**17), 0, "ends before property vertex_indices in row 1"),
    "face count one too large": (binary_ply(POINTS + TRIANGLE + QUAD, f=3), 0, "file ends in row 2 of element face"),
    "count too small": (text_ply(ROWS + "3 0 1 2\n", v=3), 13, "the length of property vertex_indices in row 0"),
    "face count too small": (text_ply(ROWS + "3 0 1 2\n3 0 1 2\n"), 15, "ends before '3'; its counts are too small"),
    "binary count too small": (binary_ply(POINTS + TRIANGLE * 2), 0, "13 bytes follow the last row"),
    "truncated": (text_ply("0 0 0\n1 0 0\n0 1 0\n1 1"), 0, "ends before property z in row 3 of element vertex"),
    "binary truncated in a vertex": (binary_ply(POINTS[:-1]), 0, "only 47 bytes are left"),
    "binary truncated in a face": (binary_ply(POINTS + TRIANGLE[:-1]), 0, "announces a list of 3 numbers; 11 bytes"),
    "list length lies": (text_ply(ROWS + "200 0 1 2\n"), 0, "file ends before property vertex_indices in row 0"),
    "list length is enormous": (text_ply(ROWS + "1e300 0 1 2\n"), 14, "length of property vertex_indices"),
    "list length is negative": (text_ply(ROWS + "-3 0 1 2\n"), 14, "at least 3, found -3"),
    "list length is a fraction": (text_ply(ROWS + "3.5 0 1 2\n"), 14, "found 3.5"),
    "list length is nan": (text_ply(ROWS + "nan 0 1 2\n"), 14, "found nan"),
    "binary list length lies": (binary_ply(POINTS + b"\xc8" + TRIANGLE[1:]), 0, "announces a list of 200 numbers; 12"),
    "second binary list length lies": (binary_ply(POINTS + TRIANGLE + b"\xc8" + TRIANGLE[1:], f=2), 0, "a list of 200"),
    "binary list length is negative": (header("ascii", "binary_little_endian", "").replace(b"uchar", b"char") + POINTS
                                       + b"\xff" + TRIANGLE[1:], 0, "announces a list of -1 numbers"),
    # values
    "a word for a number": (text_ply("0 0 0\n1 x 0\n0 1 0\n1 1 0\n3 0 1 2\n"), 11, "must be a number, found 'x'"),
    "half a number": (text_ply("0 0 0\n1 1.5e 0\n0 1 0\n1 1 0\n3 0 1 2\n"), 11, "must be a number, found '1.5e'"),
    "nan": (text_ply("0 0 0\n1 0 nan\n0 1 0\n1 1 0\n3 0 1 2\n"), 11, "must be a finite number"),
    "infinity": (text_ply("0 0 0\n1 -inf 0\n0 1 0\n1 1 0\n3 0 1 2\n"), 11, "property y in row 1 of element vertex"),
    "beyond": (text_ply("0 0 0\n1 1e19 0\n0 1 0\n1 1 0\n3 0 1 2\n"), 11, "at most 1e+18 in size, found '1e19'"),
    "binary nan": (binary_ply(struct.pack("<f", np.nan) + POINTS[4:] + TRIANGLE), 0,
                   "the position of vertex 0 is (nan, 0, 0)"),
    "binary infinity": (binary_ply(POINTS[:-4] + struct.pack("<f", np.inf) + TRIANGLE), 0, "vertex 3 is (1, 1, inf)"),
    "index out of range": (text_ply(ROWS + "3 0 1 4\n"), 14, "between 0 and 3, found 4"),
    "negative index": (text_ply(ROWS + "3 0 1 -1\n"), 14, "between 0 and 3, found -1"),
    "fractional index": (text_ply(ROWS + "3 0 1 1.5\n"), 14, "found 1.5"),
    "enormous index": (text_ply(ROWS + "3 0 1 1e300\n"), 14, "found 1e+300"),
    "binary index out of range": (binary_ply(POINTS + struct.pack("<B3i", 3, 0, 1, 4)), 0,
                                  "triangle 0 names vertex 4; the file has 4 vertices, so it must be between 0 and 3"),
    "binary negative index": (binary_ply(POINTS + struct.pack("<B3i", 3, 0, 1, -1)), 0, "names vertex -1"),
    "two corners": (text_ply(ROWS + "2 0 1\n"), 14, "at least 3, found 2"),
    "binary two corners": (binary_ply(POINTS + struct.pack("<B2i", 2, 0, 1)), 0, "face 0 has 2 corners"),
    "binary two corners later": (binary_ply(POINTS + TRIANGLE + struct.pack("<B2i", 2, 0, 1), f=2), 0,
                                 "face 1 has 2 corners"),
    "no corner": (binary_ply(POINTS + b"\0"), 0, "face 0 has 0 corners; it must have at least 3"),
}

OBJ = {
    "a binary file": (b"\x7fELF\n\0\0\0\1", 2, "which is text"),
    "a PLY file": (GOOD_TEXT, 1, "found 'ply'"),
    "prose": (V.encode() + b"hello world\nf 1 2 3\n", 5, "another keyword of the format; found 'hello'"),
    "a huge line": (b"v " + b"1 " * 5_000_000, 1, "a line of more than 1048576 bytes"),
    "a huge line of many": (V.encode() + b"f " + b"1 \\\n" * 500_000, 5, "a line of more than 1048576 bytes"),
    "a huge number": (V.encode() + b"v 0 0 " + b"9" * 1_000_000 + b"\n", 5, "at most 1e+18 in size; found '9999"),
    "a huge index": (V.encode() + b"f 1 2 " + b"3" * 1_000_000 + b"\n", 5, "a corner must be v"),
    "only comments": (b"# nothing\n", 0, "the file has no vertices"),
    "no faces": (V.encode(), 0, "the file has no faces"),
    "no vertices": (b"f 1 2 3\n", 1, "names v 1; the file has 0 of them"),
    "points only": ((V + "p 1\nl 1 2\n").encode(), 0, "the file has no faces"),
    "two coordinates": ((V + "v 1 2\nf 1 2 3\n").encode(), 5, "3, 4, 6, 7 numbers, not by 2"),
    "five coordinates": (("v 1 2 3 4 5\n" + V + "f 1 2 3\n").encode(), 1, "not by 5"),
    "two and four coordinates": (b"v 1 2\nv 3 4 5 6\nv 1 2 3\nf 1 2 3\n", 1, "not by 2"),
    "two components of a normal": ((V + "vn 1 2\nf 1 2 3\n").encode(), 5, "vn must be followed by 3 numbers"),
    "a word for a number": ((V + "v 1 x 3\nf 1 2 3\n").encode(), 5, "finite numbers, at most 1e+18 in size; found 'x'"),
    "digits with underscores": ((V + "v 1 1_0 3\nf 1 2 3\n").encode(), 5, "found '1_0'"),
    "nan": ((V + "v 1 nan 3\nf 1 2 3\n").encode(), 5, "found 'nan'"),
    "infinity": ((V + "v 1 2 -inf\nf 1 2 3\n").encode(), 5, "found '-inf'"),
    "beyond": ((V + "v 1 2 1e400\nf 1 2 3\n").encode(), 5, "found '1e400'"),
    "nan in a uv": ((V + "vt 1 nan\nf 1/1 2/1 3/1\n").encode(), 5, "vt must be followed by finite numbers"),
    "index out of range": ((V + "f 1 2 3\nf 1 2 5\n").encode(), 6, "names v 5; the file has 4 of them"),
    "uv out of range": ((V + "vt 0 0\nf 1/1 2/2 3/1\n").encode(), 6, "names vt 2; the file has 1 of them"),
    "normal of none": ((V + "f 1//1 2//1 3//1\n").encode(), 5, "names vn 1; the file has 0 of them"),
    "index 0": ((V + "f 0 1 2\n").encode(), 5, "an index counts from 1 on"),
    "too far back": ((V + "f -1 -2 -5\n").encode(), 5, "here -4 is the least for v; found '-5'"),
    "a word for a corner": ((V + "f 1 2 x\n").encode(), 5, "v//vn or v/vt/vn, of whole numbers; found 'x'"),
    "a fraction for a corner": ((V + "f 1 2 3.5\n").encode(), 5, "found '3.5'"),
    "too many slashes": ((V + "f 1 2 3/1/1/1\n").encode(), 5, "found '3/1/1/1'"),
    "a lost slash": ((V + "vt 0 0\nvn 0 0 1\nf 1/1 1/2/1/ 1 3/1/1\n").encode(), 7, "found '1/2/1/'"),
    "a slash in another corner": (
        (V + "vt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/1\nf 1/1 1/2/2/1 3/1/1\n").encode(), 9,
        "found '1/2/2/1'"),
    "two corners": ((V + "f 1 2 3\nf 1 2\n").encode(), 6, "at least 3 corners, not 2"),
    "two corners everywhere": ((V + "f 1 2\nf 1 2\n").encode(), 5, "at least 3 corners, not 2"),
    "no corner": ((V + "f\n").encode(), 5, "at least 3 corners, not 0"),
    "blank face": ((V + "f  \nf 1 2 3\n").encode(), 5, "at least 3 corners, not 0"),
    "blank vertex": (("v  \n" + V + "f 1 2 3\n").encode(), 1, "not by 0"),
}
EMPTY = {"empty": b"", "only line ends": b"\r\n\n", "only zeros": bytes(100)}
CASES = [(".ply", name, *case) for name, case in PLY.items()] + [(".obj", name, *case) for name, case in OBJ.items()]
CASES += [(end, name, content, 0, "the file is empty") for end in (".ply", ".obj") for name, content in EMPTY.items()]
MOST_SECONDS = 2.0  # of CPU; the largest of these files has 10 MB
MOST_MEMORY = 12  # times the size of the file, and what an import may take besides
FLOOR = 4 << 20  # bytes


def problem(path):
    """Return the one problem for which a file is refused."""
    with pytest.raises(SceneError) as caught:
        read_mesh(path)
    (found,) = caught.value.problems
    return found


@pytest.mark.parametrize("extension, name, content, line, told", CASES, ids=[f"{case[0]} {case[1]}" for case in CASES])
def test_mistake_is_told(tmp_path, extension, name, content, line, told):
    """With the file, the line of a text file, what was found and what is allowed; soon, and in little memory."""
    path = tmp_path / f"mesh{extension}"
    path.write_bytes(content)
    began = time.process_time()
    found = problem(path)
    spent = time.process_time() - began
    tracemalloc.start()  # which takes time of its own
    problem(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.file == str(path) and told in found.message
    assert (found.line, found.column > 0) == (line, line > 0)
    assert len(found.message) < 400
    assert spent < MOST_SECONDS and peak < MOST_MEMORY * len(content) + FLOOR


@pytest.mark.parametrize("extension, content, place", [
    (".ply", text_ply("0 0 0\n1   x 0\n0 1 0\n1 1 0\n3 0 1 2\n"), (11, 5)), (".obj", b"v 0 0 0\nv  1 0 x\n", (2, 8)),
])
def test_column_is_that_of_the_word(tmp_path, extension, content, place):
    """Counted from 1, as editors do."""
    (tmp_path / f"mesh{extension}").write_bytes(content)
    found = problem(tmp_path / f"mesh{extension}")
    assert (found.line, found.column) == place


def test_unusual_files_are_told(tmp_path):
    """What cannot be opened, and names that promise no mesh."""
    assert problem(tmp_path / "gone.ply").message == "there is no such file"
    (tmp_path / "folder.obj").mkdir()
    assert problem(tmp_path / "folder.obj").message == "this is not a file"
    os.mkfifo(tmp_path / "pipe.ply")
    assert problem(tmp_path / "pipe.ply").message == "this is not a file"
    for name in ("mesh.stl", "mesh", "ply"):
        (tmp_path / name).write_bytes(GOOD_TEXT)
        assert "its name must end in .obj or .ply" in problem(tmp_path / name).message
    (tmp_path / "upper.PLY").write_bytes(GOOD_TEXT)
    assert len(read_mesh(tmp_path / "upper.PLY").faces) == 3


@pytest.mark.parametrize("trouble, said", [
    (PermissionError(13, "Permission denied"), "cannot be read: Permission denied"),
    (MemoryError(), "not enough memory for this mesh (0 MiB)"),
])
def test_trouble_of_the_system_is_told(tmp_path, monkeypatch, trouble, said):
    """No permission, no memory: an error with the file's name."""
    path = tmp_path / "mesh.obj"
    path.write_bytes(GOOD_OBJ)

    def fail(*arguments, **options):
        raise trouble

    if isinstance(trouble, OSError):
        monkeypatch.setattr("builtins.open", fail)
    else:
        monkeypatch.setattr("renderer.io.mesh_obj._line_by_line", fail)
    assert problem(path).message == said


def test_file_beyond_the_limit_is_not_read(tmp_path, monkeypatch):
    """Its size is enough to refuse it."""
    monkeypatch.setattr("renderer.io.mesh.MAX_FILE", 100)
    (tmp_path / "mesh.ply").write_bytes(GOOD_TEXT)
    assert "that is no mesh file" in problem(tmp_path / "mesh.ply").message


@pytest.mark.parametrize("extension, content", [
    (".ply", GOOD_TEXT.replace(b"ply\n", b"ply\ncomment \xff\xfe\xe9\n", 1)),
    (".obj", b"# \xff\xfe\xe9\no \xff\n" + GOOD_OBJ),
])
def test_comments_may_be_in_any_encoding(tmp_path, extension, content):
    """Only numbers and keywords are looked at."""
    (tmp_path / f"mesh{extension}").write_bytes(content)
    assert len(read_mesh(tmp_path / f"mesh{extension}").faces) > 0


@pytest.mark.parametrize("order, index", [("little", "<"), ("big", ">")])
def test_mistake_in_either_byte_order(tmp_path, order, index):
    """An index read in the wrong order would be out of range; one in the right order is told as it is."""
    body = struct.pack(f"{index}12f", *map(float, ROWS.split())) + struct.pack(f"{index}B3i", 3, 0, 1, 77)
    (tmp_path / "mesh.ply").write_bytes(binary_ply(body, order=order))
    assert "names vertex 77" in problem(tmp_path / "mesh.ply").message


# Random damage

BINARY_WITH_ALL = (
    b"ply\nformat binary_big_endian 1.0\nelement camera 1\nproperty list short double w\nelement vertex 4\n"
    b"property double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\n"
    b"property float nz\nproperty float s\nproperty float t\nelement face 2\nproperty list uchar float texcoord\n"
    b"property list int uint vertex_index\nproperty uchar flag\nend_header\n"
    + struct.pack(">h2d", 2, 1.0, 2.0)
    + b"".join(struct.pack(">3d5f", *map(float, row.split()), 0, 0, 1, 0.5, 0.5) for row in ROWS.splitlines())
    + struct.pack(">B2fi3IB", 2, 0.0, 1.0, 3, 0, 1, 2, 9) + struct.pack(">Bi4IB", 0, 4, 0, 1, 3, 2, 9))
GOOD = [(".ply", GOOD_TEXT), (".ply", GOOD_BINARY), (".ply", BINARY_WITH_ALL), (".obj", GOOD_OBJ),
        (".obj", (V + "f 1 2 3\nf 2 3 4\n").encode())]
WORDS = [b"nan", b"-1", b"1e999", b"4000000000", b"0", b"", b" ", b"\n", b"/", b"//", b"\\\n", b"#", b"3.5", b"\xff",
         b"f ", b"v ", b"list", b"element", b"property", b"end_header\n", b"uchar", b"double", b"binary_little_endian",
         b"\0", b"_"]
PUT = st.sampled_from(WORDS) | st.binary(max_size=6)
DAMAGE = st.lists(st.tuples(st.floats(0, 1), st.integers(0, 8), PUT), max_size=4)  # where, how much goes, what comes


@settings(max_examples=400, deadline=None)
@given(st.sampled_from(GOOD), DAMAGE, st.none() | st.floats(0, 1))
@example((".obj", b"v 0 0 0\nf 1 1 1"), [], None)
def test_damaged_file_is_read_or_refused(tmp_path_factory, good, damage, kept):
    """Whatever stands in the file: a mesh that keeps its promises, or a mistake that is told. Nothing else."""
    extension, content = good
    for place, length, put in damage:
        start = int(place * len(content))
        content = content[:start] + put + content[start + length :]
    content = content if kept is None else content[: int(kept * len(content))]
    path = tmp_path_factory.getbasetemp() / f"damaged{extension}"
    path.write_bytes(content)
    try:
        mesh = read_mesh(path)
    except SceneError as error:
        assert all(found.file == str(path) and found.message for found in error.problems)
        return
    assert isinstance(mesh, MeshData) and mesh.faces.dtype == np.uint32 and mesh.faces.shape[1:] == (3,)
    assert len(mesh.faces) and mesh.faces.max() < len(mesh.vertices)
    for rows, width in ((mesh.vertices, 3), (mesh.normals, 3), (mesh.uv, 2)):
        assert rows is None or rows.shape == (len(mesh.vertices), width) and np.isfinite(rows).all()
    assert sum(part.nbytes for part in (mesh.vertices, mesh.faces)) < 100 * len(content)


@pytest.mark.parametrize("extension, content", GOOD)
def test_the_files_to_damage_are_good(tmp_path, extension, content):
    """Otherwise the test above would only ever see refusals."""
    (tmp_path / f"mesh{extension}").write_bytes(content)
    assert len(read_mesh(tmp_path / f"mesh{extension}").faces) >= 2
