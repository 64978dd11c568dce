"""OBJ in all its dialects is one solid, and what is not OBJ is refused with its line."""

import codecs
from itertools import count

import numpy as np
import pytest

from tests.voa_meshes.files import POINTS, POLYGONS, SOLID, TRIANGLES, assert_solid, changed, measures, obj
from voa_meshes.obj import read_obj
from voa_meshes.triangles import UnreadableMesh

PLAIN = obj()
VERTICES = "".join(line + "\n" for line in PLAIN.splitlines() if line.startswith("v"))
LAST_FACE = PLAIN.splitlines()[-1]


def with_corners(form: str) -> str:
    """The faces with every corner in a form such as "{0}/{1}"; texture and normals count on their own."""
    faces = ["f " + " ".join(form.format(i + 1, k) for i, k in zip(face, count(1), strict=False)) for face in POLYGONS]
    return VERTICES + "vt 0 0\n" * 6 + "vn 0 0 1\n" * 6 + "\n".join(faces) + "\n"


def relative(mixed: bool = False) -> str:
    """The lower half of the vertices, faces among them, then the others: indices counted from the face's line."""
    lines = VERTICES.splitlines()
    low, rest = POLYGONS[0], POLYGONS[1:]
    text = "\n".join(lines[:6]) + "\nf " + " ".join(str(i - 6) for i in low) + "\n" + "\n".join(lines[6:]) + "\n"
    for face in rest:
        text += "f " + " ".join(str(i + 1 if mixed and k % 2 else i - 12) for k, i in enumerate(face)) + "\n"
    return text


READ = {
    "polygons": PLAIN,
    "triangles": obj(TRIANGLES),
    "relative indices": relative(),
    "relative and absolute indices": relative(mixed=True),
    "faces before their vertices": PLAIN.removeprefix(VERTICES) + VERTICES,
    "texture": with_corners("{0}/{1}"),
    "normals": with_corners("{0}//{1}"),
    "texture and normals": with_corners("{0}/{1}/{1}"),
    "texture left out": with_corners("{0}/"),
    "relative texture": with_corners("{0}/-1/-1"),
    "tabs": PLAIN.replace(" ", "\t"),
    "indentation": "".join(f"  \t{line} \n" for line in PLAIN.splitlines()),
    "comments behind values": "# step\n" + "".join(f"{line} # {line} \\\n" for line in PLAIN.splitlines()),
    "comments next to values": PLAIN.replace("\n", "#x\n"),
    "carriage returns": PLAIN.replace("\n", "\r"),
    "carriage returns and line feeds": PLAIN.replace("\n", "\r\n"),
    "no last line end": PLAIN.strip(),
    "empty lines": "\n \n\t\n" + PLAIN.replace("\n", "\n\n"),
    "continued lines": PLAIN.replace(" ", " \\\n"),
    "continued lines without blanks before": PLAIN.replace(" ", "\\\n "),
    "continued lines with blanks behind": PLAIN.replace(" ", " \\ \t\n "),
    "continued lines of Windows": PLAIN.replace(" ", " \\\r\n"),
    "a path that ends in a backslash": changed(PLAIN, ("f ", "usemtl C:\\steps\\\nf ")),
    "names that are continued": "mtllib a.mtl \\\n b.mtl\ng one \\\n two\n" + PLAIN,
    "colours of vertices": VERTICES.replace("\n", " 0.5 0.25 1\n") + PLAIN.removeprefix(VERTICES),
    "colours with a fourth value": VERTICES.replace("\n", " 0.5 0.25 1 1\n") + PLAIN.removeprefix(VERTICES),
    "weights of 1": VERTICES.replace("\n", " 1.0\n") + PLAIN.removeprefix(VERTICES),
    "groups and looks": "mtllib steel.mtl\no step\n" + changed(PLAIN, ("f ", "g a b\nusemtl steel\ns off\nmg 0\nf ")),
    "points and lines": PLAIN + "p 1 2 3\nl 1 2 3\nl 1/1 2/2\nvp 0.5 0.5\n",
    "the old word for a face": PLAIN.replace("f ", "fo "),
    "exponents and signs": PLAIN.replace("v 0.0", "v +0.0").replace(" 0.0\n", " -0e-3\n"),
    "unused vertices that are no numbers": VERTICES + "v nan inf 0\n" + PLAIN.removeprefix(VERTICES),
}


@pytest.mark.parametrize("text", READ.values(), ids=READ)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_every_dialect_is_the_same_solid(text: str, encoding: str) -> None:
    assert_solid(read_obj(text.encode(encoding)))


def test_text_in_16_bits_of_either_order_and_padding_are_read() -> None:
    assert_solid(read_obj(codecs.BOM_UTF16_BE + PLAIN.encode("utf-16-be")))
    assert_solid(read_obj(PLAIN.encode() + b"\0\0\x1a"))
    assert_solid(read_obj(b"# caf\xe9\n" + PLAIN.encode()))


def test_two_solids_with_relative_indices_are_two() -> None:
    upper = POINTS + np.array([0.0, 0.0, 0.1])
    moved = iter(f"v {x!r} {y!r} {z!r}" for x, y, z in upper.tolist())
    text = relative() + "\n".join(next(moved) if line.startswith("v") else line for line in relative().splitlines())
    measured = measures(read_obj(text.encode()))
    assert measured[0] == pytest.approx(2.0 * SOLID[0])
    assert measured[3] == pytest.approx(2.0 * SOLID[3] + 0.1 * SOLID[0])


REFUSED = {
    "index 0": (PLAIN.replace("f 6 ", "f 0 "), r"OBJ has no index 0.*\(line 13\)"),
    "an index beyond the end": (PLAIN.replace("f 6 ", "f 13 "), r"vertex 13, but the file has only 12 \(line 13\)"),
    "an index before the beginning": (
        PLAIN.replace("f 6 ", "f -13 "),
        r"refers to vertex -13, but only 12 stand before it \(line 13\)",
    ),
    "a relative index beyond those before": ("f -1 -2 -3\n" + PLAIN, r"only 0 stand before it \(line 1\)"),
    "an index of 20 digits": (PLAIN.replace("f 6 ", f"f {'9' * 20} "), r"refers to vertex '9{20}' \(line 13\)"),
    "words for indices": (PLAIN.replace("f 6 ", "f six "), r"expected the vertices of a face, got 'six.*\(line 13\)"),
    "fractions for indices": (PLAIN.replace("f 6 ", "f 6.0 "), r"expected the vertices of a face.*\(line 13\)"),
    "an underscore in an index": (PLAIN.replace("f 6 ", "f 0_6 "), r"expected the vertices of a face.*\(line 13\)"),
    "four parts of a corner": (PLAIN.replace("f 6 ", "f 6/1/1/1 "), r"expected the vertices of a face.*\(line 13\)"),
    "a corner without a vertex": (PLAIN.replace("f 6 ", "f /1 "), r"expected the vertices of a face.*\(line 13\)"),
    "a face without corners": (PLAIN + "f\n", r"expected the vertices of a face, got '' \(line 21\)"),
    "a face of two corners": (PLAIN + "f 1 2\n", r"at least 3 corners of a face, got 2 \(line 21\)"),
    "a face whose continuation is a line too late": (PLAIN + "f 1 2 \\\n\n3\n", r"\(line 21\)"),
    "sides that cross": (PLAIN + "f 1 3 2 4\n", r"line 21: the sides of its polygon cross"),
    "two coordinates": (PLAIN + "v 1 2\n", r"expected x, y and z of a vertex, got '1 2' \(line 21\)"),
    "five coordinates": (PLAIN + "v 1 2 3 4 5\n", r"expected x, y and z.*\(line 21\)"),
    "a decimal comma": (PLAIN + "v 1,5 2 3\n", r"expected x, y and z of a vertex, got '1,5 2 3' \(line 21\)"),
    "an underscore in a number": (PLAIN + "v 1_0 2 3\n", r"expected x, y and z.*\(line 21\)"),
    "a weight that is not 1": (PLAIN + "v 1 2 3 2\n", r"a vertex with the weight 2 is not supported \(line 21\)"),
    "a free-form surface": (PLAIN + "surf 0 1 0 1 1 2 3 4\n", r"a free-form surface \(surf\) is not supported"),
    "another file": (PLAIN + "call part.obj\n", r"a call of another file \(call\) is not supported"),
    "a statement that is none": (PLAIN.replace("f 6", "F 6"), r"OBJ has no statement 'F' \(line 13\)"),
    "text": ("hello world\n", r"OBJ has no statement 'hello' \(line 1\)"),
    "bytes": ("\0\1\2\3" * 10, r"OBJ has no statement"),
}


@pytest.mark.parametrize(("text", "says"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_obj_is_refused_with_its_line(text: str, says: str) -> None:
    with pytest.raises(UnreadableMesh, match=says) as refused:
        read_obj(text.encode())
    assert "\n" not in str(refused.value)


def test_text_that_is_not_in_the_16_bits_it_says_is_refused() -> None:
    with pytest.raises(UnreadableMesh, match="UTF-16"):
        read_obj(codecs.BOM_UTF16_LE + b"odd")


def test_a_line_keeps_its_number_behind_continued_ones() -> None:
    with pytest.raises(UnreadableMesh, match=r"\(line 25\)"):
        read_obj(
            (
                PLAIN.replace("f 6 5 ", "f 6 5 \\\n", 1).replace("f 7 ", "f \\\n\\\n\\\n7 ", 1) + f"{LAST_FACE} x\n"
            ).encode()
        )
