"""PLY as text and as bytes, with whatever else its elements say, is one solid; wrong counts are refused."""

import struct

import numpy as np
import pytest

from tests.voa_meshes.files import (
    POINTS,
    POLYGONS,
    TRIANGLES,
    ascii_ply,
    assert_solid,
    binary_ply,
    changed,
    numbers,
    row,
)
from voa_meshes.ply import read_ply
from voa_meshes.triangles import UnreadableMesh

TEXT = ascii_ply()
HEAD, BODY = TEXT.partition("end_header\n")[::2]
ROWS = BODY.splitlines()


def with_more() -> str:
    """Every element has more than it must, and there are more elements."""
    header = changed(
        HEAD,
        ("property double x", "property uchar red\nproperty list uchar short near\nproperty double x"),
        ("property list uchar int", "property float area\nproperty list uchar int"),
        ("element face", "element material 1\nproperty int shine\nelement face"),
    )
    header += "property list uint8 float32 texcoord\nelement edge 1\nproperty int vertex1\nproperty int vertex2\n"
    points = [f"255 2 0 -1 {line}" for line in ROWS[:12]]
    faces = [f"0.5 {line} 2 0.25 0.75" for line in ROWS[12:]]
    return "\n".join([header + "end_header", *points, "7", *faces, "0 1"]) + "\n"


def bytes_with_more(order: str) -> bytes:
    name = "binary_little_endian" if order == "<" else "binary_big_endian"
    header = with_more().partition("end_header\n")[0].replace("ascii", name) + "end_header\n"
    body = b"".join(struct.pack(f"{order}BB2h3d", 255, 2, 0, -1, *point) for point in POINTS) + struct.pack(
        f"{order}i", 7
    )
    for face in POLYGONS:
        body += struct.pack(f"{order}fB{len(face)}iB2f", 0.5, len(face), *face, 2, 0.25, 0.75)
    return header.encode() + body + struct.pack(f"{order}2i", 0, 1)


READ_TEXT = {
    "polygons": TEXT,
    "triangles": ascii_ply(TRIANGLES),
    "tabs": TEXT.replace(" ", "\t").replace("binary\t", "binary "),
    "indentation": TEXT.replace("\n", "\n \t"),
    "blanks behind": TEXT.replace("\n", "  \n"),
    "carriage returns": TEXT.replace("\n", "\r"),
    "lines of Windows": TEXT.replace("\n", "\r\n"),
    "empty lines": HEAD + "end_header\n\n" + BODY.replace("\n", "\n\n"),
    "the other name of the list": TEXT.replace("vertex_indices", "vertex_index"),
    "names of types with their bits": TEXT.replace("double", "float64").replace("uchar int", "uint8 int32"),
    "unsigned indices": TEXT.replace("uchar int", "uint ushort"),
    "comments": changed(TEXT, ("element face", "obj_info made today\ncomment element face 7\nelement face")),
    "more elements and properties": with_more(),
    "faces first": changed(
        HEAD.replace("\nelement face 8\nproperty list uchar int vertex_indices", ""),
        ("element vertex", "element face 8\nproperty list uchar int vertex_indices\nelement vertex"),
    )
    + "end_header\n"
    + "\n".join([*ROWS[12:], *ROWS[:12]]),
    "no last line end": TEXT.strip(),
    "padding": TEXT + "\n\0\0\x1a",
    "text behind the data": TEXT + "the end\n",
    "unused vertices": ascii_ply(points=[*POINTS, [9.0, 9.0, 9.0], [float("nan"), 0.0, float("inf")]]),
}


@pytest.mark.parametrize("text", READ_TEXT.values(), ids=READ_TEXT)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_every_dialect_of_the_text_is_the_same_solid(text: str, encoding: str) -> None:
    assert_solid(read_ply(text.encode(encoding)))


def in_lines(ends: bytes, content: bytes) -> bytes:
    header, end, body = content.partition(b"end_header\n")
    return (header + end).replace(b"\n", ends) + body


READ_BYTES = {
    "polygons": binary_ply(),
    "polygons, big end first": binary_ply(order=">"),
    "triangles": binary_ply(TRIANGLES),
    "triangles, big end first": binary_ply(TRIANGLES, order=">"),
    "lines of Windows": in_lines(b"\r\n", binary_ply()),
    "carriage returns": in_lines(b"\r", binary_ply()),
    "carriage returns, and a first byte like a line feed": in_lines(
        b"\r", binary_ply(points=np.vstack([POINTS, POINTS]))
    ),
    "more elements and properties": bytes_with_more("<"),
    "more elements and properties, big end first": bytes_with_more(">"),
    "zeros behind the data": binary_ply() + bytes(100),
    "text behind the data": binary_ply() + b"the end of the file, which says nothing",
    "some bytes behind the data": binary_ply() + b"\x03\x01",
    "one face more that is none": binary_ply() + struct.pack("<B3i", 3, 1, 1, 1),
    "unused vertices": binary_ply(points=[*POINTS, [float("nan")] * 3]),
}


@pytest.mark.parametrize("content", READ_BYTES.values(), ids=READ_BYTES)
def test_bytes_are_the_same_solid(content: bytes) -> None:
    assert_solid(read_ply(content))


def test_single_precision_is_what_the_file_has() -> None:
    header = binary_ply().partition(b"end_header\n")[0].replace(b"double", b"float") + b"end_header\n"
    body = POINTS.astype("<f4").tobytes() + b"".join(struct.pack(f"<B{len(p)}i", len(p), *p) for p in POLYGONS)
    assert_solid(read_ply(header + body), within=1e-8)


REFUSED = {
    "fewer faces, in text": (ascii_ply(faces=9).encode(), "the header says 9 of 'face', the file has 8"),
    "more faces, in text": (ascii_ply(faces=7).encode(), "the header says 7 of 'face', the file has more"),
    "fewer vertices, in text": (ascii_ply(vertices=13).encode(), "vertex 13: expected the header's values, got '6 5"),
    "more vertices, in text": (ascii_ply(vertices=11).encode(), "face 1"),
    "fewer faces, in bytes": (binary_ply(faces=9), "the header says 9 of 'face', the file has 8"),
    "more faces, in bytes": (binary_ply(faces=7), "the header says 7 of 'face', the file has more"),
    "many more faces, in bytes": (binary_ply(TRIANGLES, faces=4), "the header says 4 of 'face', the file has more"),
    "fewer triangles, in bytes": (binary_ply(TRIANGLES, faces=21), "the header says 21 of 'face', the file has 20"),
    "fewer vertices, in bytes": (binary_ply(vertices=13), "face"),
    "more vertices, in bytes": (binary_ply(vertices=11), "face"),
    "vertices that are cut off": (binary_ply()[: len(HEAD) + 100], "of 'vertex', the file has"),
    "faces that are cut off": (binary_ply()[:-3], "the header says 8 of 'face', the file has 7"),
    "5e8 vertices": (binary_ply(vertices=500_000_000), "the header says 500000000 of 'vertex'"),
    "more of another element, in text": (
        with_more().encode() + b"1 2\n",
        "the header says 1 of 'edge', the file has more",
    ),
    "more of another element, in bytes": (bytes_with_more("<") + bytes([1] * 8), "'edge', the file has more"),
    "an index beyond the end": (
        ascii_ply([*POLYGONS, [0, 1, 12]]).encode(),
        "face 9 refers to vertex 12, of vertices 0 to 11",
    ),
    "an index below 0": (ascii_ply([*POLYGONS, [0, 1, -1]]).encode(), "face 9 refers to vertex -1"),
    "an index beyond the end, in bytes": (binary_ply([*POLYGONS, [0, 1, 12]]), "face 9 refers to vertex 12"),
    "a fraction for an index": (
        changed(TEXT, (ROWS[12], ROWS[12].replace(" 5", " 5.5"))).encode(),
        "face 1 refers to vertex 5.5",
    ),
    "a face of two corners": (ascii_ply([*POLYGONS, [0, 1]]).encode(), "face 9 has 2 corners"),
    "a face of no corners": (binary_ply([*POLYGONS, []]), "face 9 has 0 corners"),
    "sides that cross": (ascii_ply([*POLYGONS, [0, 2, 1, 3]]).encode(), "face 9: the sides of its polygon cross"),
    "a word for a number": (
        changed(TEXT, ("-0.05", "five")).encode(),
        "vertex 1: expected the header's values, got 'five",
    ),
    "a value too few": (changed(TEXT, (ROWS[0], numbers([1, 2]))).encode(), "vertex 1: expected the header's values"),
    "a value too many": (changed(TEXT, (ROWS[0], numbers([1, 2, 3, 4]))).encode(), "vertex 1: expected the header's"),
    "a list that says too much": (
        changed(TEXT, (ROWS[12], row([7, 0, 1, 2]))).encode(),
        "face 1: expected the header's",
    ),
    "no header": (b"\1" * 100, "expected a header from 'ply' to 'end_header'"),
    "a header without an end": (HEAD.encode(), "expected a header from 'ply' to 'end_header'"),
    "no format": (changed(TEXT, ("format ascii 1.0\n", "")).encode(), "no line 'format'"),
    "another format": (changed(TEXT, ("format ascii 1.0", "format packed 1.0")).encode(), "'format packed 1.0'"),
    "another version": (changed(TEXT, ("format ascii 1.0", "format ascii 2.0")).encode(), "'format ascii 2.0'"),
    "another type": (changed(TEXT, ("double x", "quad x")).encode(), "'property quad x', which PLY"),
    "a list of fractions": (changed(TEXT, ("uchar int", "uchar float")).encode(), "a list of whole numbers"),
    "a list counted in fractions": (changed(TEXT, ("uchar int", "float int")).encode(), "property list float int"),
    "no faces": (changed(TEXT, ("element face", "element hexagon")).encode(), "the elements 'vertex' and 'face'"),
    "no list of corners": (changed(TEXT, ("vertex_indices", "corners")).encode(), "'vertex_indices'"),
    "triangle strips": (changed(TEXT, ("element face", "element tristrips")).encode(), r"strips \(tristrips\)"),
    "no z": (changed(TEXT, ("double z", "double w")).encode(), "got no z"),
    "one name twice": (changed(TEXT, ("double z", "double x")).encode(), "two of one name"),
    "one element twice": (changed(TEXT, ("element face", "element vertex")).encode(), "two elements 'vertex'"),
    "a count that is none": (changed(TEXT, ("vertex 12", "vertex -12")).encode(), "'element vertex -12'"),
}


@pytest.mark.parametrize(("content", "says"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_as_the_header_says_is_refused(content: bytes, says: str) -> None:
    with pytest.raises(UnreadableMesh, match=says) as refused:
        read_ply(content)
    assert "\n" not in str(refused.value)
