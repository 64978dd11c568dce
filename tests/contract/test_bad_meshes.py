"""Untrusted mesh files: whatever is wrong with one, there is a problem document and nothing is stored."""

import gzip
import io
import json
import struct
import zipfile
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest

from tests.contract.bad_input.base import check_problem
from tests.support.serving import Service, box_obj, serving
from tests.voa_meshes.files import POINTS, ascii_ply, binary_stl, obj
from voa_service.settings import Limits

BOX = box_obj()
FIRST_FACE = "f 1 3 4\n"
INVALID, TYPE, LARGE = "invalid-mesh", "unsupported-mesh-type", "too-large"
LIMITS = Limits(faces=100, upload_bytes=400_000)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("meshes"), limits=LIMITS, mesh_mebibytes=1024) as running:
        yield running


def stl(corners: Sequence[float], claimed: int | None = None) -> bytes:
    """A binary STL of nine numbers per triangle."""
    faces = [corners[i : i + 9] for i in range(0, len(corners), 9)]
    body = b"".join(struct.pack("<12fH", 0.0, 0.0, 1.0, *face, 0) for face in faces)
    return bytes(80) + struct.pack("<I", len(faces) if claimed is None else claimed) + body


def glb(document: dict[str, Any], blob: bytes = b"") -> bytes:
    text = json.dumps({"asset": {"version": "2.0"}} | document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if blob:
        chunks += struct.pack("<II", len(blob), 0x004E4942) + blob
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def glb_claiming(count: int, blob: bytes) -> bytes:
    """A GLB whose accessors say that they have `count` elements."""
    scene: dict[str, Any] = {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"componentType": 5126, "count": count, "type": "VEC3", "bufferView": 0},
            {"componentType": 5125, "count": count, "type": "SCALAR", "bufferView": 0},
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(blob)}],
        "buffers": [{"byteLength": len(blob)}],
    }
    return glb(scene, blob)


def zipped(name: str, size: int) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, bytes(size))
    return out.getvalue()


def strip(faces: int) -> str:
    """A strip of triangles."""
    points = "".join(f"v {i * 1e-3} {i % 2 * 1e-2} {i % 3 * 1e-2}\n" for i in range(faces + 2))
    return points + "".join(f"f {i + 1} {i + 2} {i + 3}\n" for i in range(faces))


BOMB = zipped("box.obj", 30_000_000)
PLY_CLAIMS = (
    "ply\nformat binary_little_endian 1.0\nelement vertex 500000000\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
)
TRIANGLES = [0.01 * (i * 7 % 11) for i in range(9 * 12)]


class Case(NamedTuple):
    name: str
    file: str
    content: str | bytes
    status: int = 422
    kind: str = INVALID
    says: str = ""
    scale: str = "1"
    up: str = "+Z"


CASES = [
    Case("an empty file", "box.obj", b"", says="empty"),
    Case("a file that is cut off", "box.obj", BOX[:60]),
    Case("points alone", "box.obj", "v 0 0 0\nv 1 0 0\n", says="at least 4 faces"),
    Case("text that is no mesh", "box.obj", "hello\n" * 100),
    Case("bytes that are no STL", "box.stl", bytes(range(256)) * 10),
    Case("bytes that are no GLB", "box.glb", bytes(1000), says="GLB"),
    Case("bytes that are no PLY", "box.ply", bytes(1000), says="PLY"),
    Case("an index beyond the last vertex", "box.obj", BOX.replace(FIRST_FACE, "f 1 3 99\n")),
    Case("an index before the first vertex", "box.obj", BOX.replace(FIRST_FACE, "f -99 3 4\n")),
    Case("an index of 20 digits", "box.obj", BOX.replace(FIRST_FACE, f"f {'9' * 20} 3 4\n")),
    Case("words for indices", "box.obj", BOX.replace(FIRST_FACE, "f a b c\n")),
    Case("index 0", "box.obj", BOX.replace(FIRST_FACE, "f 0 2 3\n"), says="OBJ has no index 0"),
    Case("NaN as coordinate", "box.obj", BOX.replace("v -0.02 -0.03 0.0\n", "v nan 0 0\n"), says="finite"),
    Case("infinity as coordinate", "box.obj", BOX.replace("v -0.02 -0.03 0.0\n", "v 1e999 0 0\n"), says="finite"),
    Case("NaN in an STL", "box.stl", stl([float("nan"), *TRIANGLES[1:]]), says="finite"),
    Case("an STL that is cut off", "box.stl", stl(TRIANGLES)[:300]),
    Case("an STL that claims 5e7 faces", "box.stl", stl(TRIANGLES, claimed=50_000_000)),
    Case("a GLB that claims 5e7 elements", "box.glb", glb_claiming(50_000_000, bytes(12))),
    Case("a GLB that claims 5e8 elements of nothing", "box.glb", glb_claiming(500_000_000, b"")),
    Case("a GLB without a scene", "box.glb", glb({}), says="scenes"),
    Case("Draco", "box.glb", glb({"extensionsRequired": ["KHR_draco_mesh_compression"]}), says="Draco compression"),
    Case("an unknown extension", "box.glb", glb({"extensionsRequired": ["ACME_gears"]}), says="'ACME_gears'"),
    Case("a PLY with fewer faces than it says", "box.ply", ascii_ply(faces=30), says="the header says 30 of 'face'"),
    Case("a PLY with more faces than it says", "box.ply", ascii_ply(faces=7), says="the file has more"),
    Case("an STL with more faces than it says", "box.stl", binary_stl(claimed=7), says="the file has more"),
    Case("a polygon that crosses itself", "box.obj", BOX + "f 1 2 4 3\nf 1 4 2 3\n", says="line 22: the sides"),
    Case("map coordinates", "box.obj", obj(points=POINTS + np.array([6.9e5, 5.3e6, 0.0])), says="within 1000 m"),
    Case("a place far away after scale", "box.obj", obj(points=POINTS * 1e3 + 2e6), says="1000 m", scale="0.001"),
    Case("a PLY that claims 5e8 vertices", "box.ply", PLY_CLAIMS.encode() + bytes(100)),
    Case("a compressed bomb named .obj", "box.obj", BOMB),
    Case("a compressed bomb named .stl", "box.stl", BOMB),
    Case("a gzipped bomb named .ply", "box.ply", gzip.compress(bytes(10_000_000))),
    Case("a compressed bomb named .zip", "box.zip", BOMB, 415, TYPE, "*.obj, *.stl, *.ply, *.glb"),
    Case("another type", "box.step", BOX, 415, TYPE, "*.step"),
    Case("no type", "box", BOX, 415, TYPE, "*.obj"),
    Case("too many faces", "box.obj", strip(101), 413, LARGE, "at most 100 faces, got 101"),
    Case("a file that is too large", "box.obj", BOX + "#" * 400_000, 413, LARGE, "at most 400000 bytes"),
    Case("a request that is much too large", "box.obj", BOX + "#" * 500_000, 413, LARGE, "bytes"),
    Case("millimetres without a scale", "box.obj", box_obj(40, 60, 50), says="millimetres (scale=0.001)"),
    Case("metres with the scale of millimetres", "box.obj", BOX, says="metres (scale=1)", scale="0.001"),
    Case("a size that no unit explains", "box.obj", box_obj(4e7, 6e7, 5e7), says="metres per unit of the file"),
    Case("up sideways", "box.obj", BOX, kind="invalid-request", says="'+Y' or '+Z'", up="+X"),
    Case("up as a letter", "box.obj", BOX, kind="invalid-request", says="'+Y' or '+Z'", up="y"),
    Case("a scale of 0", "box.obj", BOX, kind="invalid-request", says="greater than 0", scale="0"),
    Case("a negative scale", "box.obj", BOX, kind="invalid-request", says="greater than 0", scale="-1"),
    Case("NaN as scale", "box.obj", BOX, kind="invalid-request", says="finite", scale="nan"),
    Case("infinity as scale", "box.obj", BOX, kind="invalid-request", says="finite", scale="inf"),
    Case("a word as scale", "box.obj", BOX, kind="invalid-request", says="number", scale="big"),
    Case("a scale that overflows", "box.obj", BOX, scale="1e308"),
    Case("a scale that vanishes", "box.obj", BOX, scale="1e-320"),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_bad_mesh_gets_its_problem_and_is_not_stored(service: Service, case: Case) -> None:
    before = service.stored()
    files = {"file": (case.file, case.content)}
    answer = service.http.post("/v1/objects", files=files, data={"scale": case.scale, "up": case.up})
    check_problem(answer, case.status, case.kind, case.says)
    assert service.stored() == before


@pytest.mark.parametrize(
    ("what", "form", "headers", "status", "kind"),
    [
        ("no file", {"files": {"name": (None, "box")}}, {}, 422, "invalid-request"),
        ("text for a file", {"files": {"file": (None, BOX)}}, {}, 422, "invalid-request"),
        ("a form of another kind", {"data": {"file": BOX}}, {}, 415, "unsupported-media-type"),
        ("JSON", {"json": {"file": BOX}}, {}, 415, "unsupported-media-type"),
        ("a misspelt field", {"files": {"file": ("b.obj", BOX)}, "data": {"Up": "+Y"}}, {}, 422, "invalid-request"),
        (
            "two files",
            {"files": [("file", ("a.obj", BOX)), ("file", ("b.obj", BOX))]},
            {},
            422,
            "invalid-request",
        ),
        ("a file without a name", {"files": {"file": ("", BOX)}}, {}, 422, "invalid-request"),
        ("junk", {"content": b"junk"}, {"content-type": "multipart/form-data; boundary=x"}, 400, "malformed-form"),
        ("no boundary", {"content": b"junk"}, {"content-type": "multipart/form-data"}, 400, "malformed-form"),
        (
            "a name of 129 characters",
            {"files": {"file": ("box.obj", BOX)}, "data": {"name": "n" * 129}},
            {},
            422,
            "invalid-request",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_form_that_is_none_gets_its_problem(
    service: Service, what: str, form: dict[str, Any], headers: dict[str, str], status: int, kind: str
) -> None:
    before = service.stored()
    check_problem(service.http.post("/v1/objects", headers=headers, **form), status, kind, "")
    assert service.stored() == before


def test_a_misspelt_form_field_is_refused_with_the_known_fields(service: Service) -> None:
    answer = service.http.post("/v1/objects", files={"file": ("box.obj", BOX)}, data={"scales": "0.001"})
    assert answer.json()["detail"] == "body.scales: no such field: expected one of file, name, scale, up"


def test_a_form_sent_in_chunks_beyond_the_limit_is_cut_off(service: Service) -> None:
    start = b'--x\r\nContent-Disposition: form-data; name="file"; filename="box.obj"\r\n\r\n'
    headers = {"content-type": "multipart/form-data; boundary=x"}
    answer = service.http.post("/v1/objects", content=iter([start, *[b"#" * 100_000] * 6]), headers=headers)
    check_problem(answer, 413, LARGE, "bytes")


@pytest.mark.parametrize("library", ["/etc/passwd", "../../../etc/hostname", "http://127.0.0.1:1/x.mtl"])
def test_a_material_library_is_not_looked_for(service: Service, library: str) -> None:
    plain = service.upload(BOX)
    assert service.upload(f"mtllib {library}\nusemtl steel\n{BOX}", "other.obj") == plain


def test_a_good_mesh_is_created_once_under_its_digest(service: Service) -> None:
    answers = [
        service.http.post("/v1/objects", files={"file": (name, box_obj(40, 60, 70))}, data={"scale": "0.001"} | more)
        for name, more in (("first.OBJ", {}), ("second.obj", {"name": "again"}))
    ]
    assert [answer.status_code for answer in answers] == [201, 200]
    first, second = (answer.json() for answer in answers)
    assert first == second  # a name does not make another object
    assert first["name"] == "first"
    assert first["extents"] == pytest.approx([0.04, 0.06, 0.07])
    assert (first["faces"], first["watertight"]) == (12, True)
    assert service.get(f"/v1/objects/{first['id']}") == first
    poses = service.get(f"/v1/objects/{first['id']}/stable-poses")["items"]
    assert sum(pose["probability"] for pose in poses) == pytest.approx(1.0)
    assert len(poses) >= 3
