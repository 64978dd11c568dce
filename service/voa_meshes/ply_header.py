"""The header of a PLY file, which lists its elements and the properties of their records."""

import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from voa_meshes.text import shown
from voa_meshes.triangles import UnreadableMesh

_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"}
_TYPES |= {"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
_TYPES |= {"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"}
_ORDERS = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}
_MOST_LINES = 10_000  # comments included
_START = re.compile(rb"\s*ply[ \t]*(\r\n|\n|\r)")
_END = re.compile(rb"[\r\n][ \t]*end_header[ \t]*(?=[\r\n]|$)")


@dataclass(frozen=True)
class Property:
    """A property of an element: one value of each record, or a list of values.

    Attributes:
        name: of the property, unique in its element.
        type: numpy's code of the values' type, without a byte order.
        counted_by: numpy's code of the type of a list's length; None where the property is one value.
    """

    name: str
    type: str
    counted_by: str | None = None


@dataclass(frozen=True)
class Element:
    """An element: `count` records with the same properties."""

    name: str
    count: int
    properties: tuple[Property, ...]


@dataclass(frozen=True)
class Header:
    """The header of a PLY file.

    Attributes:
        order: numpy's sign of the byte order; None for text.
        elements: in the order of the data, no name twice.
        data_at: offset of the first record in the file, in bytes.
    """

    order: str | None
    elements: tuple[Element, ...]
    data_at: int

    def element(self, name: str) -> Element | None:
        """Return the element with a name, or None where the file has none."""
        return next((element for element in self.elements if element.name == name), None)


def read_header(content: bytes) -> Header:
    """Read the header at the beginning of a file.

    Raises:
        UnreadableMesh: the header is not that of a PLY file, or is cut off.
    """
    start, end = _START.match(content), _END.search(content)
    if start is None or end is None:
        raise UnreadableMesh("expected a header from 'ply' to 'end_header'")
    newline = start[1]
    data_at = end.end() + (len(newline) if content.startswith(newline, end.end()) else 1)
    order, elements = "", list[Element]()
    lines = re.split(rb"[\r\n]+", content[start.end() : end.start()])
    if len(lines) > _MOST_LINES:
        raise UnreadableMesh(f"expected a header of at most {_MOST_LINES} lines, got {len(lines)}")
    for line in lines:
        words = line.decode("latin-1").split()
        match words:
            case [] | ["comment" | "obj_info", *_]:
                pass
            case ["format", name, "1.0"] if name in _ORDERS:
                order = name
            case ["element", name, count] if count.isascii() and count.isdigit() and len(count) < 20:
                elements.append(Element(name, int(count), ()))
            case ["property", *rest] if elements and (property_ := _property(rest)) is not None:
                last = elements[-1]
                elements[-1] = Element(last.name, last.count, (*last.properties, property_))
            case _:
                raise UnreadableMesh(f"the header has a line {shown(line)}, which PLY 1.0 does not have")
    if not order:
        raise UnreadableMesh("the header has no line 'format'")
    _check(elements)
    return Header(_ORDERS[order], tuple(elements), data_at)


def _property(words: list[str]) -> Property | None:
    match words:
        case ["list", counted_by, type_, name] if (
            type_ in _TYPES and np.dtype(_TYPES.get(counted_by, "f4")).kind in "iu"
        ):
            return Property(name, _TYPES[type_], _TYPES[counted_by])
        case [type_, name] if type_ in _TYPES:
            return Property(name, _TYPES[type_])
    return None


def _check(elements: list[Element]) -> None:
    name, times = Counter(element.name for element in elements).most_common(1)[0] if elements else ("", 0)
    if times > 1:
        raise UnreadableMesh(f"the header has two elements {shown(name.encode())}")
    for element in elements:
        properties = [property_.name for property_ in element.properties]
        if not properties or len(set(properties)) < len(properties):
            raise UnreadableMesh(f"the element {shown(element.name.encode())} has no properties, or two of one name")
