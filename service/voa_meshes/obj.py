"""Wavefront OBJ: polygons over numbered vertices."""

import re
from array import array
from collections.abc import Iterator

import numpy as np

from voa_meshes.polygons import triangulated
from voa_meshes.text import narrow, numbers, shown, with_newlines
from voa_meshes.triangles import Floats, Indices, Triangles, UnreadableMesh

_FACE = (b"f", b"fo")
_NAMES = frozenset(b"g o usemtl usemap mtllib maplib shadow_obj trace_obj".split())
"""Statements whose words are free text: a backslash at their end may belong to a path."""
_HARMLESS = _NAMES | frozenset(
    b"vt vn vp p l s mg bevel c_interp d_interp lod ctech stech cstype deg bmat step curv curv2 parm trim hole scrv sp "
    b"end con cdc res".split()
)
"""Statements that do not change the polygons."""
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
    """Read an OBJ file: `v` and `f`; textures, normals, names, points and lines are ignored.

    Raises:
        UnreadableMesh: a statement is unknown or not supported, or its numbers are missing.
    """
    vertices, faces = _Vertices(), _Faces()
    for line, statement in _statements(with_newlines(narrow(content))):
        kind = statement.split(None, 1)[0]
        if kind == b"v":
            vertices.take(line, statement)
        elif kind in _FACE:
            faces.take(line, statement, len(vertices))
        elif kind in _REFUSED:
            raise UnreadableMesh(f"{_REFUSED[kind]} ({kind.decode()}) is not supported (line {line})")
        elif kind not in _HARMLESS:
            raise UnreadableMesh(f"OBJ has no statement {shown(kind)} (line {line})")
    points = vertices.points()
    return Triangles(points, faces.triangles(points))


def _statements(text: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield each statement with the number of its first line, without comments, its continued lines joined."""
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
    """Return True where a backslash ends a name such as `C:\\meshes\\`: the next line is then a statement."""
    kind, after = parts[0].split(None, 1)[:1], following.split(None, 1)[:1]
    return kind[:1] != [] and kind[0] in _NAMES and after != [] and after[0] in (b"v", *_FACE, *_HARMLESS)


class _Vertices:
    """The `v` statements: x, y, z, and perhaps a weight of 1 or a colour, which do not move the vertex."""

    def __init__(self) -> None:
        self._numbers = array("d")

    def __len__(self) -> int:
        return len(self._numbers) // 3

    def take(self, line: int, statement: bytes) -> None:
        words = statement.split()[1:]
        try:
            values = numbers(words)
        except ValueError:
            values = []
        if len(values) not in (3, 4, 6, 7):
            raise UnreadableMesh(f"expected x, y and z of a vertex, got {shown(b' '.join(words))} (line {line})")
        if len(values) == 4 and values[3] != 1.0:
            raise UnreadableMesh(f"a vertex with the weight {values[3]:g} is not supported (line {line})")
        self._numbers.extend(values[:3])

    def points(self) -> Floats:
        return np.array(self._numbers, dtype=np.float64).reshape(-1, 3)


class _Faces:
    """The `f` statements, as indices from 0."""

    def __init__(self) -> None:
        self._corners, self._sizes, self._lines = array("q"), array("q"), array("q")

    def take(self, line: int, statement: bytes, known: int) -> None:
        words = statement.split()[1:]
        if not _CORNERS.fullmatch(statement.split(None, 1)[-1] if words else b""):
            raise UnreadableMesh(f"expected the vertices of a face, got {shown(b' '.join(words))} (line {line})")
        if len(words) < 3:
            raise UnreadableMesh(f"expected at least 3 corners of a face, got {len(words)} (line {line})")
        indices = list(map(int, (word.partition(b"/")[0] for word in words) if b"/" in statement else words))
        least, most = min(indices), max(indices)
        if 0 in indices:
            raise UnreadableMesh(f"OBJ has no index 0: its vertices are counted from 1 (line {line})")
        if least < -known:
            raise UnreadableMesh(f"a face refers to vertex {least}, but only {known} stand before it (line {line})")
        if most >= _FARTHEST:
            raise UnreadableMesh(f"a face refers to vertex {shown(str(most).encode())} (line {line})")
        if least < 0:
            indices = [known + index + 1 if index < 0 else index for index in indices]
        self._corners.extend(index - 1 for index in indices)
        self._sizes.append(len(indices))
        self._lines.append(line)

    def triangles(self, points: Floats) -> Indices:
        corners, sizes = np.array(self._corners, dtype=np.int64), np.array(self._sizes, dtype=np.int64)
        beyond = np.flatnonzero(corners >= len(points))
        if len(beyond):
            line = self._lines[int(np.searchsorted(np.cumsum(sizes), beyond[0], side="right"))]
            raise UnreadableMesh(
                f"a face refers to vertex {corners[beyond[0]] + 1}, but the file has only {len(points)} (line {line})"
            )
        return triangulated(points, corners, sizes, lambda face: f"line {self._lines[face]}")
