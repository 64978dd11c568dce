"""STL, as text and as binary."""

import re

import numpy as np

from voa_meshes.text import is_number, narrow, numbers, shown, with_newlines
from voa_meshes.triangles import Floats, Triangles, UnreadableMesh

HEADER = 84
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_ANY = b"*"
"""Place of a normal's number, which is ignored: programs differ where a normal has no direction."""
_PATTERN: list[bytes | None] = [b"facet", b"normal", _ANY, _ANY, _ANY, b"outer", b"loop"]
_PATTERN += 3 * [b"vertex", None, None, None] + [b"endloop", b"endfacet"]
_PARTS = {b"facet", b"vertex", b"endloop", b"endfacet"}
_BOUNDARY = re.compile(rb"^[ \t]*(solid|endsolid)(?:[ \t][^\n]*)?$", re.MULTILINE | re.IGNORECASE)


def read_stl(content: bytes) -> Triangles:
    """Read an STL file, text or binary, of which the length decides; colours are ignored.

    Raises:
        UnreadableMesh: the file has fewer or more facets than its header says, or text that is not STL.
    """
    if len(content) >= HEADER and len(content) == HEADER + RECORD.itemsize * _claimed(content):
        return _of_bytes(content)
    text = with_newlines(narrow(content)).strip()
    return _of_text(text) if text[:5].lower() == b"solid" and b"\0" not in text else _of_bytes(content)


def _claimed(content: bytes) -> int:
    return int.from_bytes(content[80:HEADER], "little")


def _of_bytes(content: bytes) -> Triangles:
    if len(content) < HEADER:
        raise UnreadableMesh(f"expected a header of {HEADER} bytes, or text that begins with 'solid'")
    claimed, held = _claimed(content), (len(content) - HEADER) // RECORD.itemsize
    if held < claimed:
        raise UnreadableMesh(f"the header says {claimed} facets, the file has {held}: is it cut off?")
    records = np.frombuffer(content, RECORD, count=held, offset=HEADER)
    corners = records["corners"].astype(np.float64)
    if held > claimed and (claimed == 0 or _is_like(corners[claimed], corners[:claimed])):
        raise UnreadableMesh(f"the header says {claimed} facets, the file has more")
    return _soup(corners[:claimed])


def _is_like(facet: Floats, others: Floats) -> bool:
    """Return True if a record (3, 3) after the last facet is one more: its corners differ and lie near the others."""
    low, high = others.min(axis=(0, 1)), others.max(axis=(0, 1))
    size = float((high - low).max())
    inside = (facet >= low - size).all() and (facet <= high + size).all()
    return bool(inside) and len(np.unique(facet, axis=0)) == 3


def _of_text(text: bytes) -> Triangles:
    bounds = list(_BOUNDARY.finditer(text))
    kinds = [bound[1].lower() for bound in bounds]
    if kinds != [b"solid", b"endsolid"] * (len(kinds) // 2) or not kinds:
        raise UnreadableMesh("expected lines 'solid' and 'endsolid' in turn: is the file cut off?")
    outside = [text[a.end() : b.start()] for a, b in zip(bounds[1::2], bounds[2::2], strict=False)]
    outside.append(text[bounds[-1].end() :])
    names = [set(bound[0].lower().split()) for bound in bounds]
    if any(_PARTS & set(part.lower().split()) for part in outside) or any(
        {b"facet", b"normal"} <= name for name in names
    ):
        raise UnreadableMesh("a part of a facet stands outside of 'solid' and 'endsolid'")
    inside = [text[a.end() : b.start()] for a, b in zip(bounds[::2], bounds[1::2], strict=True)]
    return _soup(np.concatenate([_facets(part.split()) for part in inside]))


def _facets(words: list[bytes]) -> Floats:
    """Read the corners (f, 3, 3) of the facets of one solid."""
    length = len(_PATTERN)
    columns: list[list[float]] = []
    try:
        for place, keyword in enumerate(_PATTERN):
            column = words[place::length]
            if keyword is None:
                columns.append(numbers(column))
            elif keyword != _ANY and any(word != keyword and word.lower() != keyword for word in column):
                raise ValueError(keyword)
    except ValueError as error:
        at = next(k for k, word in enumerate(words) if not _fits(word, _PATTERN[k % length]))
        keyword = _PATTERN[at % length]
        expected = "a number" if keyword is None else ascii(keyword.decode())
        raise UnreadableMesh(f"facet {at // length + 1}: expected {expected}, got {shown(words[at])}") from error
    if len(words) % length:
        raise UnreadableMesh(f"facet {len(words) // length + 1} is not whole: is the file cut off?")
    return np.array(columns, dtype=np.float64).T.reshape(-1, 3, 3)


def _fits(word: bytes, keyword: bytes | None) -> bool:
    return is_number(word) if keyword is None else keyword in (_ANY, word.lower())


def _soup(corners: Floats) -> Triangles:
    """Make triangles of facets (f, 3, 3), each with three vertices of its own."""
    if not len(corners):
        raise UnreadableMesh("it has no facets")
    return Triangles(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
