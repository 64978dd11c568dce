"""STL of both kinds is one solid, however it begins; what is missing or too much is refused."""

import struct

import pytest

from tests.voa_meshes.files import CORNERS, ascii_stl, assert_solid, binary_stl, changed
from voa_meshes.stl import read_stl
from voa_meshes.triangles import UnreadableMesh

TEXT, BYTES = ascii_stl(), binary_stl()
FLOAT32 = 1e-8  # what single precision leaves of 5 cm

READ_TEXT = {
    "as it is": TEXT,
    "capital letters": TEXT.upper(),
    "tabs": TEXT.replace(" ", "\t"),
    "no indentation": "\n".join(line.strip() for line in TEXT.splitlines()),
    "carriage returns": TEXT.replace("\n", "\r"),
    "lines of Windows": TEXT.replace("\n", "\r\n"),
    "no names": TEXT.replace("solid step", "solid"),
    "a name of STL's words": TEXT.replace("solid step", "solid outer loop facet"),
    "a name with blanks": TEXT.replace("solid step", "solid a step of 20 mm"),
    "a word behind the data": TEXT + "the end\n",
    "another name at the end": TEXT.replace("endsolid step", "endsolid other"),
    "two solids": ascii_stl(CORNERS[:7], "a") + ascii_stl(CORNERS[7:], "b"),
    "an empty solid": "solid nothing\nendsolid nothing\n" + TEXT,
    "padding": TEXT + "\n\n \0\0\x1a",
    "facets on one line": changed(TEXT, ("facet normal 0 0 0\n outer loop\n", "facet normal 0 0 0 outer loop ")),
    "normals that are no numbers": TEXT.replace("normal 0 0 0", "normal nan nan nan"),
    "normals of a Windows program": TEXT.replace("normal 0 0 0", "normal -nan(ind) -1.#IND 1.#QNAN"),
}


@pytest.mark.parametrize("text", READ_TEXT.values(), ids=READ_TEXT)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_every_dialect_of_the_text_is_the_same_solid(text: str, encoding: str) -> None:
    assert_solid(read_stl(text.encode(encoding)))


READ_BYTES = {
    "as it is": BYTES,
    "a header that says solid": binary_stl(head=b"solid step"),
    "a header like the text's": binary_stl(head=b"solid step\nfacet normal 0 0 0\n outer loop\n"),
    "a header with a byte order mark": binary_stl(head=b"\xef\xbb\xbf"),
    "a header with a mark of 16 bits": binary_stl(head=b"\xff\xfe"),
    "colours": b"".join([BYTES[:84], *(BYTES[84 + 50 * k : 132 + 50 * k] + b"\x1f\x80" for k in range(20))]),
    "zeros behind the data": BYTES + bytes(120),
    "text behind the data": BYTES + b"made by nobody in particular, for no purpose whatever, at no time",
    "a few bytes behind the data": BYTES + b"\x01\x02\x03",
    "solid, and bytes behind the data": binary_stl(head=b"solid step") + b"\0\xff" * 40,
}


@pytest.mark.parametrize("content", READ_BYTES.values(), ids=READ_BYTES)
def test_bytes_are_the_same_solid(content: bytes) -> None:
    assert_solid(read_stl(content), within=FLOAT32)


REFUSED = {
    "fewer facets than the header says": (BYTES[:-50], "the header says 20 facets, the file has 19"),
    "a facet that is cut off": (BYTES[:-1], "the header says 20 facets, the file has 19"),
    "more facets than the header says": (binary_stl(claimed=19), "the header says 19 facets, the file has more"),
    "many more facets": (binary_stl(claimed=5), "the header says 5 facets, the file has more"),
    "a header that says none": (binary_stl(claimed=0), "the header says 0 facets, the file has more"),
    "a header that says 4e9": (binary_stl(claimed=0xFFFFFFFF), "the header says 4294967295 facets, the file has 20"),
    "more facets, and solid": (binary_stl(claimed=7, head=b"solid step"), "the header says 7 facets"),
    "a header alone": (bytes(84), "no facets"),
    "less than a header": (b"STL", "expected a header of 84 bytes"),
    "a text that is cut off": (TEXT[: len(TEXT) // 2].encode(), "is the file cut off"),
    "a text without its end": (TEXT.removesuffix("endsolid step\n").encode(), "is the file cut off"),
    "a facet that is not whole": (changed(TEXT, (" endloop\nendfacet\nendsolid", "endsolid")).encode(), "facet 20"),
    "a facet of two corners": (changed(TEXT, ("  vertex -0.05 -0.02 0.0\n", "")).encode(), "facet [0-9]+: expected"),
    "a polygon": (
        changed(TEXT, (" endloop", "  vertex 0 0 0\n endloop")).encode(),
        "facet 1: expected 'endloop', got 'vertex'",
    ),
    "a word for a number": (changed(TEXT, ("-0.05", "five")).encode(), "facet 1: expected a number, got 'five'"),
    "an underscore in a number": (
        changed(TEXT, ("-0.05", "-0_5")).encode(),
        "facet 1: expected a number, got '-0_5'",
    ),
    "a facet outside of a solid": (
        changed(TEXT, ("endsolid step\n", "")).encode() + b"endsolid\nfacet\n",
        "stands outside",
    ),
    "a corner between two solids": ((TEXT + "vertex 0 0 0\n" + TEXT).encode(), "stands outside"),
    "a facet on the line of the name": (changed(TEXT, ("solid step\n", "solid step ")).encode(), "stands outside"),
    "a solid in a solid": (b"solid a\n" + TEXT.encode(), "in turn"),
    "nothing": (b"solid\nendsolid\n", "no facets"),
}


@pytest.mark.parametrize(("content", "says"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_whole_is_refused(content: bytes, says: str) -> None:
    with pytest.raises(UnreadableMesh, match=says) as refused:
        read_stl(content)
    assert "\n" not in str(refused.value)


def test_facets_that_are_points_behind_the_data_are_none() -> None:
    point = struct.pack("<12fH", *[0.01] * 12, 0)
    assert_solid(read_stl(BYTES + point), within=FLOAT32)
