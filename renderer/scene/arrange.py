"""Which shapes a ray tests one after the other, and which it finds through a structure.

Unbounded shapes are always tested. The others are too while they are few: unrolled, their tests cost less than the way
through a hierarchy. Meshes, and many shapes, go into a structure together, whatever their kinds.
"""

from collections import Counter

from renderer.core import rows
from renderer.core.rows import Rows
from renderer.scene import schema
from renderer.scene.geometry import TRIANGLES, ShapeGroup
from renderer.shapes import KINDS

AUTO = "auto"
STRUCTURES = (AUTO, "bvh", "grid", "none")
TRIANGLE, MESH = "triangle", "mesh"
MOST_BESIDE = 4  # bounded shapes that are tested by every ray although there is a structure


def arrange(loaded, accel):
    """Return [(index in the file, shape)] in the compiled order, and the fields of its Geometry.

    `accel` is `bvh`, `grid` or `none`, or `auto`: a hierarchy where there are meshes or many shapes. Compiled come
    first shapes outside of the structure, then those inside that are no triangles, triangles, and last meshes, each
    sorted by kind. Raises SceneError for mesh files that cannot be read.
    """
    assert accel in STRUCTURES, accel
    meshes = [item for item in loaded.shapes if item[1].type == MESH]
    others = [item for item in loaded.shapes if item[1].type != MESH]
    places = [
        (within, within and shape.type == TRIANGLE, shape.type)
        for within, (_, shape) in zip(_within([shape for _, shape in others], bool(meshes), accel), others)
    ]
    order = sorted(range(len(others)), key=places.__getitem__)  # stable: the file's order within a kind
    ordered = [others[k] for k in order] + meshes
    places = [places[k] for k in order]
    shapes = [shape for _, shape in ordered]
    first_triangle = sum(not sheet for _, sheet, _ in places)
    groups = tuple(_groups(shapes[:first_triangle], places))

    triangles = structure = None
    if first_triangle < len(shapes):
        from renderer.scene.meshes import read_meshes, triangles as gather  # brings numpy

        mode = loaded.description.rendermode
        files = read_meshes(loaded, meshes)
        triangles = gather(shapes[first_triangle:], files, first_triangle, mode == "uv", mode == schema.PATHTRACER)
    if triangles or any(group.code for group in groups):
        from renderer.scene.structures import structure_over  # small scenes start faster without

        structure = structure_over(triangles, groups, shapes, accel)
    return ordered, {"shapes": groups, "triangles": triangles, "structure": structure, "shape_count": len(ordered)}


def _within(shapes, has_meshes, accel):
    """Return for each shape that is no mesh whether it goes into the structure."""
    few = accel == AUTO and not has_meshes
    if accel == "none" or few and len(shapes) <= rows.UNROLL_LIMIT:
        return [False] * len(shapes)
    bounded = [shape.type == TRIANGLE or _bounds(shape) is not None for shape in shapes]
    if few and sum(bounded) <= rows.UNROLL_LIMIT:
        return [False] * len(shapes)
    beside = _beside(shapes, has_meshes) if accel == AUTO else ()
    return [within and shape.type not in beside for within, shape in zip(bounded, shapes)]


def _beside(shapes, has_meshes):
    """Return the kinds of which there are so few that they are tested beside the structure.

    Each kind inside makes the test of every leaf longer, for all rays; triangles are there with meshes anyway.
    """
    counts = Counter(shape.type for shape in shapes if not (has_meshes and shape.type == TRIANGLE))
    beside, total = set(), 0
    for name, count in sorted(counts.items(), key=lambda item: item[1]):
        total += count
        if total > MOST_BESIDE:
            break
        beside.add(name)
    return beside


def _bounds(shape):
    """Return the corners of the box around a shape, None where it has none."""
    bounds = KINDS[shape.type].bounds
    return bounds and bounds(shape)


def _groups(shapes, places):
    """Yield the ShapeGroups of shapes that are sorted by their places."""
    first, code = 0, TRIANGLES
    for place in dict.fromkeys(places[: len(shapes)]):
        inside, _, name = place
        kind, members = KINDS[name], [shape for at, shape in zip(places, shapes) if at == place]
        columns = kind.columns(members) if kind.columns else None
        records = Rows([kind.pack(shape, columns) for shape in members], directions=kind.directions)
        code += inside
        yield ShapeGroup(kind, records, first, code if inside else None)
        first += len(members)
