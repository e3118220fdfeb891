"""Shapes that are none: without a direction, an extent or an inside, or that say too much.

Pure Python in double precision, so that a scene without convex volumes needs no numerical library to be checked.
"""

from __future__ import annotations

from renderer.core.hull import interior_point, scale_of, unit_halfspaces
from renderer.core.vectors import cross, dot, length, subtract, unit
from renderer.scene import schema, transform
from renderer.scene.findings import WARNING, Finding
from renderer.scene.values import LARGEST

PARALLEL = 1e-6  # sine of the angle below which float32 cannot tell two directions apart reliably
FLAT = 1e-7  # relative size (float32's resolution) below which an extent is nothing
# Relative to the square of the largest coordinate. An edge is at most 2 sqrt(3) times that coordinate, so whatever is
# dropped has a normal below 12 FLAT.
CLEARLY = 12 * FLAT
FLAT_MATRIX = 1e-12  # volume of the box of a matrix's unit rows below which it is rounding of nothing
RELAXATIONS = 64  # steps after which the search for an inner point becomes a linear programme


def directed(record, name, what, at, findings):
    """Find a direction of length 0."""
    if not any(getattr(record, name)):
        findings.append(Finding((at, name), f"must not be [0, 0, 0]: the {what} needs a direction"))


def spanned(record, what, at, findings):
    """Find edges u and v that are nothing or parallel."""
    before = len(findings)
    for name in ("u", "v"):
        if not any(getattr(record, name)):
            findings.append(Finding((at, name), f"must not be [0, 0, 0]: the {what} needs two edges"))
    if len(findings) == before and length(cross(unit(record.u), unit(record.v))) < PARALLEL:
        findings.append(Finding((at, "v"), f"must not be parallel to u: the {what} has no area then"))


def _check_nothing(shape, at, findings):
    """A sphere's only condition is a radius greater than 0, which its key states."""


def _check_cylinder(shape, at, findings):
    directed(shape, "axis", "cylinder", at, findings)


def _check_plane(shape, at, findings):
    directed(shape, "normal", shape.type, at, findings)


def _check_rectangle(shape, at, findings):
    spanned(shape, "rectangle", at, findings)


def _check_triangle(shape, at, findings):
    if not _is_clearly_a_triangle(shape.v0, shape.v1, shape.v2):
        _check_thin_triangle(shape, at, findings)


def _is_clearly_a_triangle(v0, v1, v2):
    """Return whether a triangle is far from being dropped, as nearly all of a hundred thousand are: without a root."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = v0, v1, v2
    reach = max(ax, ay, az, bx, by, bz, cx, cy, cz, -ax, -ay, -az, -bx, -by, -bz, -cx, -cy, -cz)
    bx, by, bz, cx, cy, cz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
    across = max(abs(by * cz - bz * cy), abs(bz * cx - bx * cz), abs(bx * cy - by * cx))
    return across > CLEARLY * reach * reach


def _check_thin_triangle(shape, at, findings):
    e1, e2, e3 = subtract(shape.v1, shape.v0), subtract(shape.v2, shape.v0), subtract(shape.v2, shape.v1)
    longest = max(length(e1), length(e2), length(e3))
    resolution = FLAT * max(map(abs, shape.v0 + shape.v1 + shape.v2))
    # twice the area over the longest edge is the least height
    if longest <= resolution or length(cross(e1, e2)) <= max(resolution, FLAT * longest) * longest:
        findings.append(Finding(at, "dropped: this triangle has no area", severity=WARNING))


def _check_box(shape, at, findings):
    for axis, low, high in zip("xyz", shape.min, shape.max, strict=True):
        if low > high:
            findings.append(Finding((at, "min"), f"must not be greater than max in any axis; in {axis} it is "
                                                 f"{low:g} against {high:g}"))
            return
    if any(high - low <= FLAT * max(abs(low), abs(high)) for low, high in zip(shape.min, shape.max, strict=True)):
        findings.append(Finding(at, "dropped: this box has no volume, min equals max in an axis", severity=WARNING))


def _gives_one(record, at, findings):
    """Return whether exactly one of the record's alternative keys is given."""
    names = schema.EXACTLY_ONE[type(record)]
    given = [name for name in names if getattr(record, name) is not None]
    if len(given) != 1:
        told = f"{', '.join(names[:-1])} and {names[-1]}"
        found = " and ".join(given) + " are" if given else "none is" if len(names) > 2 else "neither is"
        findings.append(Finding(at, f"exactly one of {told} must be given, {found}"))
    return len(given) == 1


def _check_mesh(shape, at, findings):
    """Find steps that say nothing or too much, and transformations that flatten or lose the mesh."""
    before = len(findings)
    for number, step in enumerate(shape.transform):
        here = ((at, "transform"), number)
        if not _gives_one(step, here, findings):
            continue
        if step.rotate is not None and not any(step.rotate.axis):
            message = "must not be [0, 0, 0]: the rotation needs a direction"
            findings.append(Finding(((here, "rotate"), "axis"), message))
        if step.matrix is not None:
            if step.matrix[12:] != (0.0, 0.0, 0.0, 1.0):
                findings.append(Finding((here, "matrix"), "must end in 0, 0, 0, 1: perspective is no place for a mesh"))
            elif _is_flat(step.matrix):
                findings.append(Finding((here, "matrix"), "must be invertible: this one makes the mesh flat"))
    if len(findings) == before and not all(abs(entry) <= LARGEST for row in transform.matrix(shape.transform)
                                           for entry in row):  # NaN compares false
        findings.append(Finding((at, "transform"), f"leads beyond {LARGEST:g} in size, because its steps multiply"))


def _is_flat(matrix):
    """Return whether a 4 x 4 matrix, row by row, leaves less than three dimensions in double precision."""
    rows = [matrix[start : start + 3] for start in (0, 4, 8)]
    sizes = [length(row) for row in rows]
    return not all(sizes) or abs(dot(unit(rows[0]), cross(unit(rows[1]), unit(rows[2])))) <= FLAT_MATRIX


def _check_convex(shape, at, findings):
    if not _gives_one(shape, at, findings):
        return
    if shape.halfspaces is not None:
        _check_halfspaces(shape.halfspaces, at, findings)
    elif not _is_solid(shape.vertices):
        findings.append(Finding(at, "dropped: this convex volume is empty, its vertices lie in one plane",
                                severity=WARNING))


def _check_halfspaces(halfspaces, at, findings):
    """Find half-spaces without a direction, and those whose intersection has no inside."""
    wrong = [row for row, (x, y, z, _) in enumerate(halfspaces) if not (x or y or z)]
    for row in wrong:
        message = "must not have the normal [0, 0, 0]: a half-space needs a direction"
        findings.append(Finding(((at, "halfspaces"), row), message, list(halfspaces[row])))
    if wrong:
        return
    if not _has_inside(halfspaces):
        findings.append(Finding(at, "dropped: this convex volume is empty, no point is in all its half-spaces",
                                severity=WARNING))


def _has_inside(halfspaces):
    """Return whether some ball, large against float32's resolution of the volume, is in all half-spaces."""
    planes = unit_halfspaces(halfspaces, None)
    scale = scale_of(planes)
    # Most volumes give an inner point at once when one steps into the half-space that is left the most; the linear
    # programme takes a third of a second to import.
    p = (0.0, 0.0, 0.0)
    for _ in range(RELAXATIONS):
        excess, normal = max((dot(plane, p) - plane[3], plane) for plane in planes)
        if excess < -FLAT * scale:
            return True
        step = excess + 1e-3 * scale
        p = p[0] - step * normal[0], p[1] - step * normal[1], p[2] - step * normal[2]
    return interior_point(planes)[1] > FLAT * scale


def _is_solid(vertices):
    """Return whether points span a volume: grow the simplex of points that are farthest from each other."""
    first = vertices[0]
    resolution = FLAT * max(max(map(abs, vertex)) for vertex in vertices)
    offsets = [subtract(vertex, first) for vertex in vertices]
    along = max(offsets, key=length)
    if length(along) <= resolution:
        return False
    along = unit(along)
    across = max((cross(along, offset) for offset in offsets), key=length)
    if length(across) <= resolution:
        return False
    normal = unit(across)
    return max(abs(dot(normal, offset)) for offset in offsets) > resolution


CHECKS = {
    "sphere": _check_nothing, "cylinder": _check_cylinder, "triangle": _check_triangle,
    "plane": _check_plane, "box": _check_box, "convex": _check_convex, "mesh": _check_mesh,
    "rectangle": _check_rectangle, "disk": _check_plane,
}
