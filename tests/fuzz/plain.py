"""Second readers, written value by value and without a thought to speed or to hostile files.

They check only the content of files that were read, not whether a file should have been refused.
"""

import re
import struct
from collections.abc import Iterator

Corner = tuple[float, ...]
Polygons = list[list[Corner]]

_TYPES = {
    "char": "b",
    "uchar": "B",
    "int8": "b",
    "uint8": "B",
    "short": "h",
    "ushort": "H",
    "int16": "h",
    "uint16": "H",
}
_TYPES |= {
    "int": "i",
    "uint": "I",
    "int32": "i",
    "uint32": "I",
    "float": "f",
    "double": "d",
    "float32": "f",
    "float64": "d",
}


def polygons(kind: str, content: bytes) -> Polygons:
    """The vertices and polygons of a mesh file, as its text or bytes list them."""
    return {"obj": _obj, "stl": _stl, "ply": _ply}[kind](content)


def _lines(content: bytes) -> list[str]:
    return re.split(r"\r\n|\r|\n", content.decode("latin-1").rstrip("\0\x1a"))


def _obj(content: bytes) -> Polygons:
    lines = [line.split("#")[0].rstrip() for line in _lines(content)]
    statements: list[str] = []
    for number, line in enumerate(lines):
        joined = number > 0 and lines[number - 1].endswith("\\")
        part = line.removesuffix("\\")
        if joined:
            statements[-1] += " " + part
        else:
            statements.append(part)
    points: list[Corner] = []
    faces: list[list[int]] = []
    for word, *rest in (statement.split() for statement in statements if statement.split()):
        if word == "v":
            points.append(tuple(float(value) for value in rest[:3]))
        elif word in ("f", "fo"):
            said = [int(corner.split("/")[0]) for corner in rest]
            faces.append([index - 1 if index > 0 else len(points) + index for index in said])
    return [[points[index] for index in face] for face in faces]


def _stl(content: bytes) -> Polygons:
    (claimed,) = struct.unpack_from("<I", content.ljust(84, b"\0"), 80)
    if (
        content[:5].lower() == b"solid"
        and len(content) != 84 + 50 * claimed
        and b"\0" not in content.rstrip(b"\0\x1a\n")
    ):
        text = "\n".join(_lines(content))
        values = [line.split()[1:] for line in re.findall(r"vertex\s+\S+\s+\S+\s+\S+", text, re.IGNORECASE)]
        corners = [tuple(float(value) for value in corner) for corner in values]
    else:
        facets = [struct.unpack_from("<12f", content, 84 + 50 * k)[3:] for k in range(claimed)]
        corners = [facet[3 * k : 3 * k + 3] for facet in facets for k in range(3)]
    return [corners[k : k + 3] for k in range(0, len(corners), 3)]


class _Values:
    """The values of a PLY file's data, one after the other."""

    def __init__(self, data: bytes, format_: str) -> None:
        self._words: Iterator[bytes] = iter(data.split())
        self._data, self._at = data, 0
        self._order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[format_]

    def next(self, type_: str) -> float:
        if not self._order:
            return float(next(self._words))
        (value,) = struct.unpack_from(self._order + _TYPES[type_], self._data, self._at)
        self._at += struct.calcsize(self._order + _TYPES[type_])
        return float(value)


def _ply(content: bytes) -> Polygons:
    header, data = re.split(rb"(?<=end_header)[ \t]*(?:\r\n|\n|\r)", content, maxsplit=1)
    elements: list[tuple[str, int, list[list[str]]]] = []
    format_ = ""
    for words in (line.split() for line in _lines(header)):
        if words[:1] == ["format"]:
            format_ = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    values = _Values(data, format_)
    points: list[Corner] = []
    faces: list[list[int]] = []
    for name, count, properties in elements:
        for _ in range(count):
            record: dict[str, list[float]] = {}
            for property_ in properties:
                size = int(values.next(property_[1])) if property_[0] == "list" else 1
                record[property_[-1]] = [values.next(property_[-2]) for _ in range(size)]
            if name == "vertex":
                points.append(tuple(record[axis][0] for axis in "xyz"))
            elif name == "face":
                faces.append([int(index) for index in record.get("vertex_indices", record.get("vertex_index", []))])
    return [[points[index] for index in face] for face in faces]
