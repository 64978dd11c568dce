"""Wavefront OBJ: polygons over numbered vertices."""

import re
from array import array
from collections.abc import Iterator

import numpy as np

from voa_meshes.polygons import triangulated
from voa_meshes.text import narrow, numbers, shown, with_newlines
from voa_meshes.triangles import Floats, Indices, Triangles, Unreadable

_FACE = (b"f", b"fo")
_NAMES = frozenset(b"g o usemtl usemap mtllib maplib shadow_obj trace_obj".split())
"""Statements whose words are free text: a backslash at their end may belong to a path."""
_HARMLESS = _NAMES | frozenset(
    b"vt vn vp p l s mg bevel c_interp d_interp lod ctech stech cstype deg bmat step curv curv2 parm trim hole scrv sp "
    b"end con cdc res".split()
)
"""Statements that say nothing about the polygons."""
_REFUSED = {
    b"surf": "a free-form surface",
    b"bsp": "a B-spline patch",
    b"bzp": "a Bezier patch",
    b"cdp": "a Cardinal patch",
    b"call": "a call of another file",
    b"csh": "a command for a shell",
}
_CORNERS = re.compile(rb"(?:\s*[-+]?\d{1,1000}(?:/[-+]?\d*){0,2}(?=\s|$))+\s*")
_FARTHEST = 2**31


def read_obj(content: bytes) -> Triangles:
    """Read an OBJ file: `v` and `f`; texture, normals, names, points and lines are passed over.

    Raises:
        Unreadable: a statement is none of OBJ, is not supported, or has not the numbers that it must have.
    """
    vertices, faces = _Vertices(), _Faces()
    for line, statement in _statements(with_newlines(narrow(content))):
        kind = statement.split(None, 1)[0]
        if kind == b"v":
            vertices.take(line, statement)
        elif kind in _FACE:
            faces.take(line, statement, len(vertices))
        elif kind in _REFUSED:
            raise Unreadable(f"{_REFUSED[kind]} ({kind.decode()}) is not supported (line {line})")
        elif kind not in _HARMLESS:
            raise Unreadable(f"OBJ has no statement {shown(kind)} (line {line})")
    points = vertices.points()
    return Triangles(points, faces.triangles(points))


def _statements(text: bytes) -> Iterator[tuple[int, bytes]]:
    """The statements that are not empty, without comments, continued lines joined, with the number of their line."""
    lines = text.split(b"\n")
    if b"#" in text:
        lines = [line.partition(b"#")[0] for line in lines]
    continued = b"\\" in text
    at = 0
    while at < len(lines):
        number, parts = at + 1, [lines[at]]
        at += 1
        while continued and parts[-1].rstrip().endswith(b"\\"):
            parts[-1] = parts[-1].rstrip()[:-1]
            if at == len(lines) or _ends_in_a_path(parts, lines[at]):
                break
            parts.append(lines[at])
            at += 1
        statement = b" ".join(parts)
        if statement and not statement.isspace():
            yield number, statement


def _ends_in_a_path(parts: list[bytes], following: bytes) -> bool:
    """Whether a backslash ends a name such as `C:\\meshes\\`, for the next line is a statement of its own."""
    kind, after = parts[0].split(None, 1)[:1], following.split(None, 1)[:1]
    return kind[:1] != [] and kind[0] in _NAMES and after != [] and after[0] in (b"v", *_FACE, *_HARMLESS)


class _Vertices:
    """The `v` statements: x, y, z; then a weight, or a colour with or without one, which change no place."""

    def __init__(self) -> None:
        self._numbers = array("d")

    def __len__(self) -> int:
        return len(self._numbers) // 3

    def take(self, line: int, statement: bytes) -> None:
        words = statement.split()[1:]
        try:
            found = numbers(words)
        except ValueError:
            found = []
        if len(found) not in (3, 4, 6, 7):
            raise Unreadable(f"expected x, y and z of a vertex, got {shown(b' '.join(words))} (line {line})")
        if len(found) == 4 and found[3] != 1.0:
            raise Unreadable(f"a vertex with the weight {found[3]:g} is not supported (line {line})")
        self._numbers.extend(found[:3])

    def points(self) -> Floats:
        return np.array(self._numbers, dtype=np.float64).reshape(-1, 3)


class _Faces:
    """The `f` statements, as indices from 0."""

    def __init__(self) -> None:
        self._corners, self._sizes, self._lines = array("q"), array("q"), array("q")

    def take(self, line: int, statement: bytes, known: int) -> None:
        words = statement.split()[1:]
        if not _CORNERS.fullmatch(statement.split(None, 1)[-1] if words else b""):
            raise Unreadable(f"expected the vertices of a face, got {shown(b' '.join(words))} (line {line})")
        if len(words) < 3:
            raise Unreadable(f"expected at least 3 corners of a face, got {len(words)} (line {line})")
        found = list(map(int, (word.partition(b"/")[0] for word in words) if b"/" in statement else words))
        least, most = min(found), max(found)
        if 0 in found:
            raise Unreadable(f"OBJ has no index 0: its vertices are counted from 1 (line {line})")
        if least < -known:
            raise Unreadable(f"a face refers to vertex {least}, of {known} before it (line {line})")
        if most >= _FARTHEST:
            raise Unreadable(f"a face refers to vertex {shown(str(most).encode())} (line {line})")
        if least < 0:
            found = [known + index + 1 if index < 0 else index for index in found]
        self._corners.extend(index - 1 for index in found)
        self._sizes.append(len(found))
        self._lines.append(line)

    def triangles(self, points: Floats) -> Indices:
        corners, sizes = np.array(self._corners, dtype=np.int64), np.array(self._sizes, dtype=np.int64)
        beyond = np.flatnonzero(corners >= len(points))
        if len(beyond):
            line = self._lines[int(np.searchsorted(np.cumsum(sizes), beyond[0], side="right"))]
            raise Unreadable(f"a face refers to vertex {corners[beyond[0]] + 1}, of {len(points)} (line {line})")
        return triangulated(points, corners, sizes, lambda face: f"line {self._lines[face]}")
