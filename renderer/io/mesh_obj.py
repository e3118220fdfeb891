"""Wavefront OBJ files: polygons over positions, texture coordinates and normals with indices of their own.

Files of the usual form (blocks of equal lines, one form of corner, no relative indices) are parsed in whole arrays;
whatever else there is, and everything with a mistake in it, goes line by line. Both give the same mesh.

Of the format, `v`, `vt`, `vn` and `f` count. Weights and colours behind a position are passed over, and so are groups,
smoothing, materials (`mtllib`, `usemtl`), points, lines and free-form curves. Where a corner of some faces names no
texture coordinates or normal, though others do, it gets uv (0, 0) and the normal (0, 0, 0), which stands for none.
"""

from __future__ import annotations

import re
import warnings
from array import array

import numpy as np

from renderer.io.mesh_parts import LARGEST, LEAST_CORNERS, Malformed, as_number, fans, shown

IGNORED = frozenset(
    b"o g s mg mtllib usemtl maplib usemap l p vp lod bevel c_interp d_interp shadow_obj trace_obj ctech stech "
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con call csh".split())
# How many numbers may follow: positions with a weight or with a colour (and both), uv with a depth, normals.
LENGTHS = {b"v": (3, 4, 6, 7), b"vt": (1, 2, 3), b"vn": (3,)}
KEPT = {b"v": 3, b"vt": 2, b"vn": 3}
LARGEST_LINE = 2**20  # bytes; a polygon of 50,000 corners
BLOCK = re.compile(rb"^(v|vt|vn|f) [^\n]*+(?:\n\1 [^\n]*+)*+|^[^\n]++", re.MULTILINE)
CORNER = re.compile(rb"(-?\d{1,18})(?:/(-?\d{1,18})?(?:/(-?\d{1,18})?)?)?")  # 18 digits fit 64 bits
WORD = re.compile(rb"\S+")
# Which of v, vt, vn a corner names, and the separators that this takes.
FORMS = {(True, False, False): b"", (True, True, False): b"/", (True, False, True): b"//", (True, True, True): b"//"}
SLASH, BLANK, BREAK = b"/ \n"
DIGITS = b"0123456789"
NONE = -1  # index of what a corner does not name


class _Unusual(Exception):
    """The file has to be read line by line."""


def read(data):
    """Return (vertices, triangles, normals or None, uv or None) of an OBJ file's bytes; raises Malformed."""
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise Malformed("not an OBJ file, which is text: there is a zero byte in this line", line, 1)
    data = data.removeprefix(b"\xef\xbb\xbf")  # the byte order mark that some editors write
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    breaks = np.flatnonzero(np.frombuffer(data, np.uint8) == BREAK)
    lengths = np.diff(breaks, prepend=-1, append=len(data))
    if lengths.max() > LARGEST_LINE:
        raise _too_long(int(lengths.argmax()) + 1)
    try:
        rows, corners, counts = _at_once(data)
    except _Unusual:
        rows, corners, counts = _line_by_line(data)
    return _indexed(rows, corners, counts)


def _at_once(data):
    """Return what `_line_by_line` does; `_Unusual` for files that are not of the usual form."""
    if b"\\\n" in data or b"\\\r\n" in data:  # a line that goes on in the next
        raise _Unusual
    blocks = {b"v": [], b"vt": [], b"vn": [], b"f": []}
    for found in BLOCK.finditer(data):
        if found[1] is not None:
            blocks[found[1]].append(found[0])
        elif found[0][:1] != b"#" and (words := found[0].split(maxsplit=1)) and words[0] not in IGNORED:
            raise _Unusual
    rows = {word: _table(word, blocks[word]) for word in LENGTHS}
    corners, counts = _corners(blocks[b"f"])
    for index, table in zip(corners, rows.values(), strict=True):
        if index is not None and index.size and not (index.min() >= 0 and index.max() < len(table)):
            raise _Unusual
    return rows, corners, counts


def _table(word, blocks):
    """Return the numbers of the lines `word x y ...` as (N, kept) float64."""
    if not blocks:
        return np.empty((0, KEPT[word]))
    text = b"\n".join(blocks).decode("latin-1")
    lines = text[len(word) + 1 :].replace(f"\n{word.decode()} ", "\n").split("\n")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # lines without any number are only warned about
            table = np.loadtxt(lines, np.float64, ndmin=2, comments=None)
    except (ValueError, UserWarning):
        raise _Unusual from None
    if len(table) != len(lines) or table.shape[1] not in LENGTHS[word] or table.shape[1] < KEPT[word]:
        raise _Unusual
    table = table[:, : KEPT[word]]
    if not (np.abs(table) <= LARGEST).all():
        raise _Unusual
    return table


def _corners(blocks):
    """Return the indices (v, vt or None, vn or None) of all corners, from 0, and the corners of each face."""
    if not blocks:
        raise _Unusual
    lines = [line[2:].strip() for block in blocks for line in block.split(b"\n")]
    first = CORNER.fullmatch(lines[0].split(b" ")[0])
    form = first and tuple(group is not None for group in first.groups())
    length = lines[0].count(b" ") + 1
    if form not in FORMS or length < LEAST_CORNERS:
        raise _Unusual
    text = b"\n".join(lines) + b"\n"
    pattern = np.frombuffer(b" ".join([FORMS[form]] * length) + b"\n", np.uint8)
    numbers = _evenly_separated(text, len(lines), pattern)
    if len(numbers) != len(lines) * length * sum(form):
        raise _Unusual
    if form == (True, False, True) and text.count(b"//") != len(lines) * length:
        raise _Unusual
    columns = iter(numbers.reshape(-1, sum(form)).T - 1)
    return tuple(next(columns) if given else None for given in form), np.full(len(lines), length, np.int64)


def _evenly_separated(text, line_count, pattern):
    """Return the whole numbers in lines that all have the separators `pattern`; `_Unusual` if there are others.

    That there are as many numbers as places between separators, which is left to the caller, fixes where they stand.
    """
    letters = np.frombuffer(text, np.uint8)
    separators = letters[(letters == SLASH) | (letters == BLANK) | (letters == BREAK)]
    if len(separators) != line_count * len(pattern) or (separators.reshape(line_count, -1) != pattern).any():
        raise _Unusual
    if len(letters) - len(separators) != np.count_nonzero((letters >= DIGITS[0]) & (letters <= DIGITS[-1])):
        raise _Unusual  # relative indices (-1), other blanks, or no numbers at all
    return np.fromstring(text.replace(b"/", b" "), np.int64, sep=" ")


def _indexed(rows, corners, counts):
    """Return (vertices, triangles, normals or None, uv or None): a vertex for each different v/vt/vn."""
    uv = rows[b"vt"].astype(np.float32)
    uv[:, 1] = 1 - uv[:, 1]  # v runs upwards in the file, downwards here
    tables = rows[b"v"], uv, rows[b"vn"].astype(np.float32)
    named = [index is not None for index in corners]
    if any((index != corners[0]).any() or len(table) != len(tables[0])
           for index, table in zip(corners, tables, strict=True) if index is not None):
        key = corners[0]
        for index, table in zip(corners[1:], tables[1:], strict=True):
            if index is not None:  # numbered afresh each time, so that the products fit 64 bits
                key = np.unique(key, return_inverse=True)[1] * (len(table) + 1) + index + 1
        _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
        nothing = [np.vstack([table, np.zeros_like(table, shape=(1, table.shape[1]))]) for table in tables]
        tables = [table[index[first]] if given else None
                  for table, index, given in zip(nothing, corners, named, strict=True)]
        corners = (inverse, *corners[1:])
    vertices, uv, normals = (table if given else None for table, given in zip(tables, named, strict=True))
    return vertices, fans(corners[0], counts), normals, uv


# Line by line


def _line_by_line(data):
    """Return ({word: table}, (v, vt or None, vn or None) of all corners, corners of each face); raises Malformed."""
    tables = {word: array("d") for word in LENGTHS}
    corners, counts, places = (array("q"), array("q"), array("q")), array("q"), array("q")
    for number, line in _logical_lines(data):
        words = WORD.findall(line.split(b"#", 1)[0])
        if not words:
            continue
        word = words[0]
        if word in tables:
            tables[word].extend(_numbers(word, words, number, line))
        elif word == b"f":
            counts.append(_face(words, corners, [len(tables[name]) // KEPT[name] for name in tables], number, line))
            places.append(number)
        elif word not in IGNORED:
            raise _wrong("a line must begin with v, vt, vn, f or another keyword of the format", 0, number, line)
    rows = {word: np.array(table).reshape(-1, KEPT[word]) for word, table in tables.items()}
    corners, counts = [np.array(column, np.int64) for column in corners], np.array(counts, np.int64)
    for index, (word, table) in zip(corners, rows.items(), strict=True):
        _check_range(index, word, len(table), counts, places)
    named = (index if word == b"v" or (index != NONE).any() else None
             for index, word in zip(corners, rows, strict=True))
    return rows, tuple(named), counts


def _logical_lines(data):
    """Yield (number, line), with lines joined that end in a backslash."""
    number, place = 1, 0
    while place < len(data):
        first, pieces, size, goes_on = number, [], 0, True
        while goes_on and place < len(data):
            end = data.find(b"\n", place)
            end = len(data) if end < 0 else end
            piece, place, number = data[place:end].rstrip(b"\r"), end + 1, number + 1
            goes_on = piece.endswith(b"\\")
            pieces.append(piece[:-1] + b" " if goes_on else piece)
            size += len(piece)
            if size > LARGEST_LINE:
                raise _too_long(first)
        yield first, b"".join(pieces)


def _numbers(word, words, number, line):
    """Return the numbers of a line that count, with zeros for what may be absent."""
    if len(words) - 1 not in LENGTHS[word]:
        allowed = ", ".join(map(str, LENGTHS[word]))
        raise _wrong(f"{word.decode()} must be followed by {allowed} numbers, not by {len(words) - 1}", 0, number, line)
    numbers = []
    for place, text in enumerate(words[1:], 1):
        value = as_number(text)
        if value is None or not abs(value) <= LARGEST:
            told = f"{word.decode()} must be followed by finite numbers, at most {LARGEST:g} in size"
            raise _wrong(told, place, number, line)
        numbers.append(value)
    return (numbers + [0.0])[: KEPT[word]]


def _face(words, corners, sizes, number, line):
    """Append the corners of a face, with indices from 0 and NONE for what they do not name; return their number."""
    if len(words) - 1 < LEAST_CORNERS:
        raise _wrong(f"a face must have at least {LEAST_CORNERS} corners, not {len(words) - 1}", 0, number, line)
    for place, text in enumerate(words[1:], 1):
        found = CORNER.fullmatch(text)
        if found is None:
            raise _wrong("a corner must be v, v/vt, v//vn or v/vt/vn, of whole numbers", place, number, line)
        for column, size, group, word in zip(corners, sizes, found.groups(), KEPT, strict=True):
            index = 0 if group is None else int(group)
            if group is not None and not -size <= index or group is not None and not index:
                raise _wrong(f"an index counts from 1 on, or from -1 backwards; here -{size} is the least for "
                             f"{word.decode()}", place, number, line)
            column.append(index - 1 if index >= 0 else size + index)
    return len(words) - 1


def _check_range(index, word, size, counts, places):
    """Raise Malformed for the first corner that names what the file does not have."""
    wrong = np.flatnonzero(index >= size)
    if len(wrong):
        face = int(np.searchsorted(np.cumsum(counts), wrong[0], side="right"))
        told = f"this face names {word.decode()} {index[wrong[0]] + 1}; the file has {size} of them"
        raise Malformed(told, places[face], 1)


def _wrong(message, place, number, line):
    """Return a complaint about a word of a line, with its column."""
    found = list(WORD.finditer(line))[place]
    return Malformed(f"{message}; found {shown(found[0])}", number, found.start() + 1)


def _too_long(number):
    return Malformed(f"a line of more than {LARGEST_LINE} bytes; no line of an OBJ file is that long", number, 1)
