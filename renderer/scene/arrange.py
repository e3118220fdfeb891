"""Which shapes a ray tests one after the other, and which it finds through a structure.

Unbounded shapes are always tested. The others are too while they are few: unrolled, their tests cost less than the way
through a hierarchy. Meshes, and many shapes, go into a structure together, whatever their kinds.
"""

import drjit as dr

from renderer.accel import watertight
from renderer.accel.brute_force import BruteForce
from renderer.accel.build import build
from renderer.accel.bvh import Bvh
from renderer.accel.nodes import assemble
from renderer.accel.pairs import pair
from renderer.accel.records import FREE, LEAF, PRIMITIVE, TAG, WORDS
from renderer.core import rows
from renderer.core.backend import Float, UInt32, Vector3f
from renderer.core.numeric import EPSILON, greater, lesser
from renderer.core.rows import Rows
from renderer.scene.geometry import TRIANGLES, ShapeGroup
from renderer.shapes import KINDS

AUTO = "auto"
STRUCTURES = (AUTO, "bvh", "grid", "none")


def arrange(loaded, accel):
    """Return [(index in the file, shape)] in the compiled order, and the fields of its Geometry.

    `accel` is `bvh`, `grid` or `none`, or `auto`: a hierarchy where there are meshes or many shapes. Raises SceneError
    for mesh files that cannot be read.
    """
    meshes = [item for item in loaded.shapes if item[1].type == "mesh"]
    others = [item for item in loaded.shapes if item[1].type != "mesh"]
    many = len(others) > rows.UNROLL_LIMIT or bool(meshes)
    inside = {id(shape) for _, shape in others if KINDS[shape.type].bounds and KINDS[shape.type].bounds(shape)} if (
        accel not in (AUTO, "none") or accel == AUTO and many
    ) else set()
    if accel == AUTO and not meshes and len(inside) <= rows.UNROLL_LIMIT:
        inside = set()

    def place(item):
        shape = item[1]
        return id(shape) in inside, id(shape) in inside and shape.type == "triangle", shape.type

    others.sort(key=place)  # stable: the file's order within a kind
    shapes = [shape for _, shape in others]
    structured = [id(shape) in inside for shape in shapes]
    sheets = sum(1 for shape in shapes if id(shape) in inside and shape.type == "triangle")
    solids = len(shapes) - sheets
    groups = tuple(_groups(shapes[:solids], structured))
    triangles = None
    if sheets or meshes:
        from renderer.scene.meshes import read_meshes, triangles as gather  # numpy, which small scenes do without

        sheets_and_meshes = [*shapes[solids:], *(shape for _, shape in meshes)]
        uv_shown = loaded.description.rendermode == "uv"
        triangles = gather(sheets_and_meshes, read_meshes(loaded, meshes), solids, uv_shown)
    structure = structure_over(triangles, groups, shapes, accel) if inside or meshes else None
    ordered = [*others, *meshes]
    return ordered, {
        "shapes": groups, "triangles": triangles, "structure": structure, "shape_count": len(ordered)
    }


def _groups(shapes, structured):
    """Return the ShapeGroups of shapes that are sorted by place and kind."""
    first = 0
    code = TRIANGLES
    for key in dict.fromkeys((inside, shape.type) for inside, shape in zip(structured, shapes)):
        inside, name = key
        kind = KINDS[name]
        members = [shape for within, shape in zip(structured, shapes) if (within, shape.type) == key]
        columns = kind.columns(members) if kind.columns else None
        records = Rows([kind.pack(shape, columns) for shape in members], directions=kind.directions)
        code += inside
        yield ShapeGroup(kind, records, first, code if inside else None)
        first += len(members)


def structure_over(triangles, groups=(), shapes=(), accel="bvh"):
    """Return the structure over Triangles, or None, and over those ShapeGroups of `shapes` that have a code."""
    parts = []
    if triangles is not None:
        pairs = pair(*triangles.positions())
        corners = (pairs.v0, pairs.v1, pairs.v2, pairs.v3)
        lo = hi = corners[0]
        for corner in corners[1:]:
            lo = Vector3f(*map(lesser, lo, corner))
            hi = Vector3f(*map(greater, hi, corner))
        parts.append((watertight.leaf_words(pairs, triangles.first), TRIANGLES, lo, hi))
    for group in groups:
        if group.code is not None:
            members = shapes[group.first : group.first + group.rows.count]
            parts.append((_leaf_words(group), group.code, *_bounds(group.kind, members)))
    leaves, lo, hi = _joined(parts)
    if accel == "none":
        return BruteForce(leaves)
    if accel == "grid":
        from renderer.accel.grid import Grid  # few ask for it

        return Grid.over(leaves, lo, hi)
    reach = dr.max([dr.max(greater(abs(a), abs(b))) for a, b in zip(lo, hi)])
    dr.make_opaque(reach)
    return Bvh(assemble(build(lo, hi), leaves), reach)


def _leaf_words(group):
    """Return the leaf words of shapes, but for the tag."""
    count = group.rows.count
    words, place = dr.zeros(UInt32, WORDS * count), WORDS * dr.arange(UInt32, count)
    if group.inline:
        for column, word in zip(range(group.rows.width), FREE):
            dr.scatter(words, dr.reinterpret_array(UInt32, group.rows.column(column)), place + word)
    dr.scatter(words, dr.arange(UInt32, count) + group.first, place + PRIMITIVE)
    return words


def _bounds(kind, shapes):
    """Return the corners of boxes around shapes, rounded outwards."""
    lowest, highest = zip(*map(kind.bounds, shapes))
    lo, hi = (Vector3f(*(Float(list(axis)) for axis in zip(*corners))) for corners in (lowest, highest))
    return lo - abs(lo) * (2 * EPSILON), hi + abs(hi) * (2 * EPSILON)


def _joined(parts):
    """Return leaf words with their tags, and boxes, of several (words, code, lo, hi) as one."""
    counts = [len(lo.x) for _, _, lo, _ in parts]
    total, first = sum(counts), 0
    leaves = dr.empty(UInt32, WORDS * total)
    lo, hi = dr.empty(Vector3f, total), dr.empty(Vector3f, total)
    for count, (words, code, low, high) in zip(counts, parts):
        place = dr.arange(UInt32, count) + dr.opaque(UInt32, first)
        dr.scatter(words, UInt32(LEAF | code), WORDS * dr.arange(UInt32, count) + TAG)
        dr.scatter(leaves, words, dr.arange(UInt32, WORDS * count) + dr.opaque(UInt32, WORDS * first))
        dr.scatter(lo, low, place)
        dr.scatter(hi, high, place)
        first += count
    dr.eval(leaves, lo, hi)
    return leaves, lo, hi
