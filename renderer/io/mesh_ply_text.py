"""The rows of an ASCII PLY file: numbers between blanks, whose division into lines means nothing.

All numbers are parsed at once. Only where something is wrong is the text walked again, word by word, for the place.
"""

from __future__ import annotations

import re
from array import array

import numpy as np

from renderer.io.mesh_parts import LARGEST, LEAST_CORNERS, Malformed, as_number, shown

WORD = re.compile(rb"[^ \t\r\n\v\f]+")


class _Surprise(Exception):
    """The text is not as the header says."""


def read_rows(data, header, face, corners):
    """Return (columns of the vertices, corners of each face, all corners one after the other); raises Malformed."""
    try:
        try:
            numbers = np.fromstring(data[header.size :], np.float64, sep=" ")  # strict: it stops at no word silently
        except ValueError:
            raise _Surprise from None
        return _divided(numbers, header, face, corners)
    except _Surprise:
        _explain(data, header, face, corners)


def check(data, header, tables, faces, face, corners):
    """Raise Malformed with the line for numbers of vertices that are not finite and corners that are no vertices.

    `tables` are the vertices' arrays, the first of them with a row for each vertex.
    """
    finite = all((np.abs(table) <= LARGEST).all() for table in tables if table is not None)
    if not finite or len(faces) and not (faces.min() >= 0 and faces.max() < len(tables[0])):
        _explain(data, header, face, corners)


def _divided(numbers, header, face, corners):
    """Return the rows' parts; `_Surprise` where the numbers do not make the promised rows."""
    place, columns, counts, indices = 0, (), (), ()
    for element in header.elements:
        width = len(element.properties)
        if element.count * width > len(numbers) - place:
            raise _Surprise
        if not element.has_lists:
            rows = numbers[place : place + element.count * width].reshape(element.count, width)
            place += rows.size
            if element.name == "vertex":
                types = [prop.type if prop.type[0] == "f" else "f8" for prop in element.properties]
                columns = [column.astype(kind) for column, kind in zip(rows.T, types, strict=True)]
            continue
        place, found = _lists(numbers, place, element, corners if element is face else None)
        counts, indices = found if element is face else (counts, indices)
        if (np.asarray(counts) < LEAST_CORNERS).any():
            raise _Surprise
    if place != len(numbers):
        raise _Surprise
    return columns, counts, indices


def _lists(numbers, place, element, wanted):
    """Return the place after rows with lists, and (corners of each face, all corners) of the property `wanted`."""
    if len(element.properties) == 1 and element.count:  # the usual face: all with as many corners as the first
        length = numbers[place]
        end = place + element.count * (1 + length)
        if 0 <= length <= len(numbers) and length == int(length) and end <= len(numbers):
            rows = numbers[place : int(end)].reshape(element.count, -1)
            if (rows[:, 0] == length).all():
                return int(end), (np.full(element.count, length, np.int64), _whole(rows[:, 1:].reshape(-1)))
    starts, counts, size = array("q"), array("q"), len(numbers)
    for _ in range(element.count):
        for prop in element.properties:
            if prop.count_type is None:
                place += 1
                continue
            length = numbers[place] if place < size else -1.0
            if not 0 <= length <= size - place - 1 or length != int(length):
                raise _Surprise
            if prop is wanted:
                starts.append(place + 1)
                counts.append(int(length))
            place += 1 + int(length)
    if place > size:
        raise _Surprise
    starts, counts = np.array(starts, np.int64), np.array(counts, np.int64)
    shift = np.repeat(starts - (np.cumsum(counts) - counts), counts)
    return place, (counts, _whole(numbers[shift + np.arange(len(shift))]))


def _whole(numbers):
    """Return numbers as integers; `_Surprise` if they are none."""
    if not (np.abs(numbers) < 2**53).all():  # NaN included; beyond, a double cannot tell integers apart
        raise _Surprise
    whole = numbers.astype(np.int64)
    if (whole != numbers).any():
        raise _Surprise
    return whole


# Where is it wrong?


def _explain(data, header, face, corners):
    """Raise Malformed for the first thing that is wrong, with its line."""
    words = _words(data, header)
    vertex_count = next(element.count for element in header.elements if element.name == "vertex")
    for element in header.elements:
        for row in range(element.count):
            for prop in element.properties:
                where = f"property {prop.name} in row {row} of element {element.name}"
                if prop.count_type is None:
                    most = LARGEST if element.name == "vertex" else None
                    _number(words, where, element, most)
                    continue
                least = LEAST_CORNERS if prop is corners else 0
                for corner in range(_length(words, where, element, least)):
                    _item(words, where, element, vertex_count if prop is corners else None)
    word, line, column = next(words, (None, 0, 0))
    if word is not None:
        raise Malformed(f"the last row that the header promises ends before {shown(word)}; its counts are too small",
                        line, column)
    raise Malformed("the rows are not what the header promises")


def _words(data, header):
    """Yield (word, line, column) after the header."""
    line, start = header.lines + 1, header.size
    while start < len(data):
        end = data.find(b"\n", start)
        end = len(data) if end < 0 else end
        for found in WORD.finditer(data, start, end):
            yield found[0], line, found.start() - start + 1
        line, start = line + 1, end + 1


def _next(words, where, element):
    for found in words:
        return found
    raise Malformed(f"the file ends before {where}; the header promises {element.count} rows")


def _number(words, where, element, most):
    """Return the next word as a finite number, its line and column."""
    word, line, column = _next(words, where, element)
    number = as_number(word)
    if number is None:
        raise Malformed(f"{where} must be a number, found {shown(word)}", line, column)
    if most is not None and not abs(number) <= most:
        raise Malformed(f"{where} must be a finite number, at most {most:g} in size, found {shown(word)}", line, column)
    return number, line, column


def _length(words, where, element, least):
    """Return the next word as the length of a list."""
    number, line, column = _number(words, where, element, None)
    if not least <= number < 2**53 or number != int(number):
        told = f"the length of {where} must be a whole number of at least {least}, found {number:g}"
        raise Malformed(told, line, column)
    return int(number)


def _item(words, where, element, limit):
    """Take the next word as an item of a list; with `limit` it has to be an index below it."""
    number, line, column = _number(words, where, element, None)
    if limit is not None and (not 0 <= number < limit or number != int(number)):
        told = f"{where} must be the number of a vertex, between 0 and {limit - 1}, found {number:g}"
        raise Malformed(told, line, column)
