"""The header of a PLY file: which elements it holds, how many, and what a row of each is made of."""

from __future__ import annotations

from dataclasses import dataclass, field

from renderer.io.mesh_parts import SHOWN, Malformed, shown

ASCII = "ascii"
ORDERS = {ASCII: "", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}
LARGEST_HEADER = 2**20  # bytes; most is comments
MOST_DECLARED = 1000  # elements and properties
MOST_DIGITS = 18  # of a count: fits 64 bits


@dataclass(frozen=True)
class Property:
    """A number of each row, or a list of numbers that begins with its length."""

    name: str
    type: str  # numpy's code, as "f4", without byte order
    count_type: str | None = None  # that of a list's length

    @property
    def least_size(self):
        """The bytes that it takes at least in a binary row: an empty list is its length."""
        return int((self.count_type or self.type)[1])


@dataclass
class Element:
    """A table: `count` rows of properties."""

    name: str
    count: int
    properties: list = field(default_factory=list)

    @property
    def has_lists(self):
        return any(prop.count_type is not None for prop in self.properties)


@dataclass(frozen=True)
class Header:
    """`size` bytes (and `lines` lines) of header, after which the rows of the elements follow in their order."""

    format: str
    order: str  # numpy's and struct's sign for the byte order
    elements: tuple
    size: int
    lines: int


def read_header(data):
    """Return the Header of a PLY file's bytes; raises Malformed with the line."""
    first = data[:SHOWN].splitlines()[0].rstrip()
    if first != b"ply":
        raise Malformed(f"not a PLY file: its first line must be 'ply', found {shown(first)}", 1, 1)
    place, number, file_format, elements, declared = 0, 0, None, [], 0
    while True:
        end = data.find(b"\n", place, LARGEST_HEADER)
        if end < 0:
            size = min(len(data), LARGEST_HEADER)
            raise Malformed(f"the header has no line 'end_header' among its first {size} bytes")
        words, place, number = data[place:end].split(), end + 1, number + 1
        declared += words[:1] in ([b"element"], [b"property"])
        if declared > MOST_DECLARED:
            raise Malformed(f"the header declares more than {MOST_DECLARED} elements and properties", number, 1)
        match words:
            case [] | [b"comment" | b"obj_info", *_]:
                continue
            case [b"ply"] if number == 1:
                continue
            case [b"end_header"]:
                break
            case [b"format", name, b"1.0"] if name.decode("latin-1") in ORDERS and file_format is None:
                file_format = name.decode("latin-1")
            case [b"format", *_]:
                raise Malformed(f"this format must be given once, as {', '.join(ORDERS)}, with version 1.0", number, 1)
            case [b"element", name, count]:
                elements.append(_element(name, count, elements, number))
            case [b"property", *rest]:
                _add_property(rest, elements, number)
            case _:
                raise Malformed("a header line must begin with format, comment, element, property or end_header and "
                                f"be complete, found {shown(b' '.join(words))}", number, 1)
    if file_format is None:
        raise Malformed(f"the header has no line 'format' ({', '.join(ORDERS)})")
    for element in elements:
        if element.count and not element.properties:
            raise Malformed(f"element {element.name} has {element.count} rows, but no properties")
    return Header(file_format, ORDERS[file_format], tuple(elements), place, number)


def _element(name, count, elements, number):
    """Return the Element that a header line declares."""
    told = name.decode("latin-1")
    if not count.isdigit() or len(count) > MOST_DIGITS:
        raise Malformed(f"the number of rows of element {shown(name)} must be a whole number of at least 0, "
                        f"found {shown(count)}", number, 1)
    if any(element.name == told for element in elements):
        raise Malformed(f"element {shown(name)} is declared twice", number, 1)
    return Element(told, int(count))


def _add_property(words, elements, number):
    """Add the property that a header line declares to the last element."""
    if not elements:
        raise Malformed("a property must follow the element that it belongs to", number, 1)
    match words:
        case [b"list", count_type, kind, name]:
            types = (kind, count_type)
        case [kind, name]:
            types = (kind,)
        case _:
            raise Malformed("a property is declared as 'property type name' or 'property list type type name'",
                            number, 1)
    codes = [TYPES.get(word.decode("latin-1")) for word in types]
    if None in codes:
        raise Malformed(f"unknown type {shown(types[codes.index(None)])} (known: {', '.join(TYPES)})", number, 1)
    if len(codes) == 2 and codes[1][0] == "f":
        raise Malformed(f"the length of list {shown(name)} must be a whole number, not a {count_type.decode()}",
                        number, 1)
    told = name.decode("latin-1")
    if any(prop.name == told for prop in elements[-1].properties):
        raise Malformed(f"property {shown(name)} is declared twice", number, 1)
    elements[-1].properties.append(Property(told, *codes))
