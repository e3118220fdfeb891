"""PLY files: ASCII, binary little and big endian [Turk1994].

The elements `vertex` and `face` are read, others are stepped over. Every row is as its header says, or the file is
refused; nothing is allocated for rows that the file is too short to hold.
"""

from __future__ import annotations

import struct
from array import array

import numpy as np

from renderer.io import mesh_ply_text
from renderer.io.files import replacing
from renderer.io.mesh_parts import LEAST_CORNERS, Malformed, fans
from renderer.io.mesh_ply_header import ASCII, read_header

UV_NAMES = (("u", "v"), ("s", "t"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
CORNER_NAMES = ("vertex_indices", "vertex_index")
LARGEST_ROW = 2**31 - 1  # bytes; numpy's limit
BLANK = b" \t\r\n\0"


def read(data):
    """Return (vertices, triangles, normals or None, uv or None) of a PLY file's bytes; raises Malformed."""
    header = read_header(data)
    elements = {element.name: element for element in header.elements}
    positions, normals, uv = _vertex_properties(elements)
    corners = _corner_property(elements)
    read_rows = mesh_ply_text.read_rows if header.format == ASCII else _read_binary
    columns, counts, indices = read_rows(data, header, elements["face"], corners)
    vertices = _stacked(columns, elements["vertex"], positions)
    if vertices.dtype != np.float32:
        vertices = vertices.astype(np.float64)
    normals, uv = (names and _stacked(columns, elements["vertex"], names).astype(np.float32) for names in (normals, uv))
    short = np.flatnonzero(counts < LEAST_CORNERS)
    if len(short):
        raise _too_short(short[0], counts[short[0]])
    faces = fans(indices, counts)
    if header.format == ASCII:  # line numbers are worked out only where something is wrong
        mesh_ply_text.check(data, header, (vertices, normals, uv), faces, elements["face"], corners)
    return vertices, faces, normals, uv


def write(path, vertices, faces, normals=None, uv=None, comments=()):
    """Write a PLY file (see `encoded`); raises RenderError if it cannot be written."""
    with replacing(path) as file:
        file.write(encoded(vertices, faces, normals, uv, comments))


def encoded(vertices, faces, normals=None, uv=None, comments=()):
    """Return the bytes of a binary little-endian PLY: float32 positions, normals and uv, int32 corners of triangles."""
    groups = [("xyz", vertices), (("nx", "ny", "nz"), normals), ("uv", uv)]
    groups = [(names, rows) for names, rows in groups if rows is not None]
    lines = ["ply", "format binary_little_endian 1.0", *(f"comment {text}" for text in comments)]
    lines += [f"element vertex {len(vertices)}", *(f"property float {name}" for names, _ in groups for name in names)]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = np.empty(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    numbers = np.concatenate([rows for _, rows in groups], 1).astype("<f4")
    return "\n".join(lines).encode("ascii") + numbers.tobytes() + rows.tobytes()


def _vertex_properties(elements):
    """Return the names of the positions, of the normals and of the texture coordinates (None where there are none)."""
    for name in ("vertex", "face"):
        if name not in elements:
            raise Malformed(f"the header declares no element {name}; a mesh has vertices and faces")
    vertex = elements["vertex"]
    if vertex.has_lists:
        raise Malformed("element vertex has a list property; only single numbers are understood there")
    names = [prop.name for prop in vertex.properties]
    missing = [name for name in "xyz" if name not in names]
    if missing:
        raise Malformed(f"element vertex has no property {', '.join(missing)}; it needs x, y and z")
    normals = ("nx", "ny", "nz")
    uv = next((pair for pair in UV_NAMES if set(pair) <= set(names)), None)
    return tuple("xyz"), normals if set(normals) <= set(names) else None, uv


def _corner_property(elements):
    """Return the list property of faces that holds the corners."""
    for prop in elements["face"].properties:
        if prop.name in CORNER_NAMES:
            if prop.count_type is None:
                raise Malformed(f"property {prop.name} of element face must be a list")
            if prop.type[0] == "f" or prop.count_type[0] == "f":
                raise Malformed(f"property {prop.name} of element face must be a list of whole numbers, "
                                "with a whole number as its length")
            return prop
    raise Malformed(f"element face has no list property {' or '.join(CORNER_NAMES)}")


def _stacked(columns, vertex, names):
    """Return the named columns side by side, in the machine's byte order."""
    places = [prop.name for prop in vertex.properties]
    stacked = np.stack([columns[places.index(name)] for name in names], -1)
    return stacked.astype(stacked.dtype.newbyteorder("="), copy=False)


# Binary files


def _read_binary(data, header, face, corners):
    """Return (columns of the vertices, corners of each face, all corners one after the other)."""
    order, offset, columns, counts, indices = header.order, header.size, (), (), ()
    for element in header.elements:
        least = element.count * sum(prop.least_size for prop in element.properties)
        if least > len(data) - offset:
            raise Malformed(f"the header promises {element.count} rows of element {element.name}, which take at least "
                            f"{least} bytes; only {len(data) - offset} bytes are left in the file")
        wanted = corners if element is face else None
        if not element.has_lists:
            rows = np.frombuffer(data, _row_type(element, order, ()), element.count, offset)
            offset += rows.nbytes
            if element.name == "vertex":
                columns = [rows[name] for name in rows.dtype.names]
        else:
            place = data, offset, element, order, wanted
            offset, found = _uniform(*place) or _walked(*place)
            counts, indices = found if element is face else (counts, indices)
    if data[offset:].strip(BLANK):
        raise Malformed(f"{len(data) - offset} bytes follow the last row that the header promises; its counts are too "
                        "small")
    return columns, counts, indices


def _row_type(element, order, lengths):
    """Return the numpy type of a row whose lists have these lengths; field 2i is the length of list property i."""
    fields, lengths = [], iter(lengths)
    for number, prop in enumerate(element.properties):
        if prop.count_type is None:
            fields.append((f"{number}", order + prop.type))
        else:
            fields.append((f"n{number}", order + prop.count_type))
            fields.append((f"{number}", order + prop.type, (next(lengths),)))
    return np.dtype(fields)


def _uniform(data, offset, element, order, wanted):
    """Return what `_walked` does, at once, if all rows have lists as long as those of the first; None otherwise."""
    if not element.count:
        return None
    lengths, place = [], offset
    for prop in element.properties:
        if prop.count_type is not None:
            if place + np.dtype(prop.count_type).itemsize > len(data):
                return None
            lengths.append(int(np.frombuffer(data, order + prop.count_type, 1, place)[0]))
            if lengths[-1] < 0:
                return None
            place += np.dtype(prop.count_type).itemsize + lengths[-1] * np.dtype(prop.type).itemsize
        else:
            place += np.dtype(prop.type).itemsize
    if place - offset > LARGEST_ROW or (place - offset) * element.count > len(data) - offset:
        return None
    rows = np.frombuffer(data, _row_type(element, order, lengths), element.count, offset)
    lists = [number for number, prop in enumerate(element.properties) if prop.count_type is not None]
    if any((rows[f"n{number}"] != length).any() for number, length in zip(lists, lengths, strict=True)):
        return None
    if wanted is None:
        return offset + rows.nbytes, None
    number = element.properties.index(wanted)
    counts = np.full(element.count, lengths[lists.index(number)], np.int64)
    items = np.ascontiguousarray(rows[f"{number}"]).reshape(-1)
    return offset + rows.nbytes, (counts, items.astype(items.dtype.newbyteorder("="), copy=False))


def _walked(data, offset, element, order, wanted):
    """Return the offset after the rows and (corners of each face, all corners) of the list property `wanted`."""
    steps, skip = [], 0
    for prop in element.properties:
        if prop.count_type is None:
            skip += np.dtype(prop.type).itemsize
        else:
            length = struct.Struct(order + np.dtype(prop.count_type).char)
            steps.append((skip, length.unpack_from, length.size, np.dtype(prop.type).itemsize, prop is wanted))
            skip = 0
    counts, items, size, place = array("q"), bytearray(), len(data), offset
    for row in range(element.count):
        for before, unpack, length_size, item_size, is_wanted in steps:
            place += before
            if place + length_size > size:
                raise _cut_off(element, row)
            (count,) = unpack(data, place)
            place += length_size
            end = place + int(count) * item_size
            if count < 0 or end > size:
                raise Malformed(f"row {row} of element {element.name} announces a list of {count} numbers; "
                                f"{size - place} bytes are left in the file")
            if is_wanted:
                if count < LEAST_CORNERS:
                    raise _too_short(row, count)
                counts.append(count)
                items += data[place:end]
            place = end
        place += skip
    if place > size:
        raise _cut_off(element, element.count - 1)
    if wanted is None:
        return place, None
    corners = np.frombuffer(items, order + wanted.type)
    return place, (np.array(counts), corners.astype(corners.dtype.newbyteorder("="), copy=False))


def _too_short(row, count):
    return Malformed(f"face {row} has {count} corners; it must have at least {LEAST_CORNERS}")


def _cut_off(element, row):
    return Malformed(f"the file ends in row {row} of element {element.name}; the header promises {element.count} rows")
