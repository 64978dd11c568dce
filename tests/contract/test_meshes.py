"""Good mesh files: one solid is one object, whatever its file; up, scale, and what is probably a mistake."""

import base64
import hashlib
import json
from collections.abc import Iterator

import numpy as np
import pytest

from tests.support.serving import Json, Service, box_obj, mesh_scenario, serving
from tests.voa_meshes.files import CORNERS, POINTS, TRIANGLES, Gltf, ascii_ply, ascii_stl, obj
from voa_assets import path as asset_path
from voa_service.rpc.entry import Rpc

Y_UP = POINTS[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
BOX = box_obj()


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("meshes"), mesh_mebibytes=1024) as running:
        yield running


def upload(service: Service, content: str | bytes, name: str, **form: str) -> Json:
    """The answer to an upload."""
    answer = service.http.post("/v1/objects", files={"file": (name, content)}, data=form)
    assert answer.status_code in (200, 201), answer.text
    body: Json = answer.json()
    return body


def glb(points: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> bytes:
    """A GLB file whose numbers are exact in single precision."""
    made = Gltf()
    made.mesh(made.triangles(points))
    return made.file()


def test_a_solid_is_one_object_whatever_its_file(service: Service) -> None:
    whole = np.round(POINTS * 100.0)  # exact in every type
    turned = np.round(Y_UP * 100.0)
    files: dict[str, str | bytes] = {
        "a.obj": obj(TRIANGLES, whole),
        "a.ply": ascii_ply(TRIANGLES, whole),
        "a.stl": ascii_stl(np.round(CORNERS * 100.0)),
        "a.glb": glb(turned),
    }
    answers = [upload(service, content, name, scale="0.01") for name, content in files.items()]
    answers += [upload(service, obj(TRIANGLES, turned), "b.obj", scale="0.01", up="+Y")]
    answers += [upload(service, glb(whole), "b.glb", scale="0.01", up="+Z")]
    assert {answer["id"] for answer in answers} == {answers[0]["id"]}
    assert [answer["up"] for answer in answers] == ["+Z", "+Z", "+Z", "+Y", "+Y", "+Z"]
    assert answers[0]["extents"] == pytest.approx([0.08, 0.07, 0.06])
    assert all(answer["watertight"] and answer["warnings"] == [] for answer in answers)
    assert service.get(f"/v1/objects/{answers[0]['id']}") == answers[0]


def test_up_is_kept(service: Service) -> None:
    first = upload(service, glb(Y_UP * 1.5), "kept.glb")
    assert first["up"] == "+Y"
    assert service.get(f"/v1/objects/{first['id']}") == first


def test_up_can_be_said_without_forms_too(service: Service) -> None:
    upload_ = {"filename": "y.obj", "file": base64.b64encode(obj(TRIANGLES, Y_UP).encode()).decode(), "up": "+Y"}
    answered = Rpc(service.inside).answer("object.create", json.dumps(upload_).encode())
    assert json.loads(answered.body)["id"] == upload(service, obj(TRIANGLES), "z.obj")["id"]


@pytest.mark.parametrize(
    ("scale", "hint"),
    [(100.0, "metres (scale=1)"), (0.04, "metres (scale=1)")],
)
def test_an_unusual_extent_is_a_warning(service: Service, scale: float, hint: str) -> None:
    answer = upload(service, box_obj(0.04, 0.06, 0.05), "box.obj", scale=str(scale))
    [warning] = answer["warnings"]
    assert warning["kind"] == "extent"
    assert f"{0.06 * scale:g} m" in warning["detail"]
    assert hint in warning["detail"]
    # Later the scale that was applied is not known any more, but the size is.
    [stored] = service.get(f"/v1/objects/{answer['id']}")["warnings"]
    assert stored["detail"].startswith(warning["detail"].partition("The file may be in")[0])


def test_usual_extents_are_none(service: Service) -> None:
    for scale in (0.06, 49.0):
        assert upload(service, BOX, "box.obj", scale=str(scale))["warnings"] == []


def test_a_mesh_that_stands_on_the_other_plane_of_its_file_is_a_warning(service: Service) -> None:
    lying = obj(TRIANGLES, 1.1 * Y_UP)
    [warning] = upload(service, lying, "lying.obj")["warnings"]
    assert warning["kind"] == "up-axis"
    assert "up=+Y" in warning["detail"]
    [warning] = upload(service, glb(1.2 * POINTS), "never-turned.glb")["warnings"]
    assert "up=+Z" in warning["detail"]
    for up in ("+Y", "+Z"):
        assert upload(service, lying, "lying.obj", up=up)["warnings"] == []  # who says it has thought of it


def by_digest(service: Service, content: str | bytes, type_: str = "obj", **more: str | float) -> list[Json]:
    """The meshes that the service has of a file, as an upload is answered."""
    digest = hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()
    answer = service.http.get("/v1/objects", params={"sha256": digest, "type": type_, **more})
    assert answer.status_code == 200, answer.text
    assert answer.json()["next"] is None
    assert {item["sha256"] for item in answer.json()["items"]} <= {digest}
    return [item | {"sha256": None} for item in answer.json()["items"]]


def test_a_file_that_was_uploaded_is_listed_by_its_digest_as_its_upload_was_answered(service: Service) -> None:
    content = obj(TRIANGLES, 1.3 * POINTS)
    assert by_digest(service, content) == []
    first = upload(service, content, "first.OBJ")
    assert by_digest(service, content) == [first] == [upload(service, content, "second.obj")]
    assert first["name"] == "first", "a mesh keeps the name of its first upload"
    assert by_digest(service, content, scale=1, up="+Z") == [first]
    for other in ({"scale": 0.5}, {"up": "+Y"}):
        assert by_digest(service, content, **other) == []
    assert by_digest(service, content, "stl") == [], "as an STL it would not be read"
    halved = upload(service, content, "half.obj", scale="0.1", up="+Y")
    assert by_digest(service, content, scale=0.1, up="+Y") == [halved]
    assert by_digest(service, content) == [first]


def test_a_mesh_in_a_list_is_warned_of_as_when_it_was_uploaded(service: Service) -> None:
    lying = obj(TRIANGLES, 1.4 * Y_UP)
    answers = [upload(service, lying, "lying.obj", up="+Z"), upload(service, lying, "lying.obj")]
    assert [len(answer["warnings"]) for answer in answers] == [0, 1]
    assert [by_digest(service, lying, up="+Z"), by_digest(service, lying)] == [answers[:1], answers[1:]]
    large = upload(service, BOX, "large.obj", scale="100")
    assert large["warnings"]
    assert by_digest(service, BOX, scale=100) == [large]


def test_up_is_that_of_the_type_where_it_is_not_said(service: Service) -> None:
    content = glb(1.5 * Y_UP)
    first = upload(service, content, "turned.glb")
    assert by_digest(service, content, "glb") == [first] == by_digest(service, content, "glb", up="+Y")
    assert by_digest(service, content, "glb", up="+Z") == []


def test_a_file_that_was_refused_is_not_listed(service: Service) -> None:
    answer = service.http.post("/v1/objects", files={"file": ("no.obj", "v 0 0 0")})
    assert answer.status_code == 422
    assert by_digest(service, "v 0 0 0") == []


def test_a_list_of_all_names_no_file(service: Service) -> None:
    upload(service, BOX, "box.obj")
    assert {item["sha256"] for item in service.get("/v1/objects")["items"]} == {None}


SHEET = "v 0 0 0\nv .1 0 0\nv .1 .1 0\nv 0 .1 0\nv .05 .05 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
NEEDLE = "".join(f"v {0.01 * k} 0 0\n" for k in range(7)) + "".join(f"f {k} {k + 1} {k + 2}\n" for k in range(1, 6))
ODD = {
    "a sheet": SHEET,
    "a sheet on its edge": SHEET.replace("v .05 .05 0", "v .05 0 .05"),
    "a needle": NEEDLE,
    "a box far away": obj(points=POINTS + 570.0),
    "a box inside out": obj([face[::-1] for face in TRIANGLES]),
    "a box with a hole": obj(TRIANGLES[1:]),
    "a box twice": obj(TRIANGLES * 2),
    "a box with a fin": obj(TRIANGLES) + "v 0.3 0 0\nf 1 2 13\n",
}


@pytest.mark.parametrize("content", ODD.values(), ids=ODD)
def test_whatever_is_accepted_is_answered(service: Service, content: str) -> None:
    id_ = upload(service, content, "odd.obj")["id"]
    poses = service.http.get(f"/v1/objects/{id_}/stable-poses")
    assert poses.status_code in (200, 422), poses.text
    resting = poses.json()["items"][:3] if poses.is_success else []
    scenario = mesh_scenario(id_)
    scenario["poses"] += [
        {"name": f"rest {k}", "position": pose["position"], "quaternion_wxyz": pose["quaternion_wxyz"]}
        for k, pose in enumerate(resting)
    ]
    scenario["scores"] = {"probabilities": [[0.5] * len(scenario["poses"])] * 2}
    made = service.create(scenario)
    assert service.post(f"/v1/scenarios/{made}/predictions", None)["poses"]
    session = service.open(made)
    assert service.get(f"/v1/sessions/{session}/voa")["ranking"]


def test_a_mesh_far_from_its_origin_rests_as_one_at_it(service: Service) -> None:
    near = upload(service, obj(), "near.obj")["id"]
    far = upload(service, obj(points=POINTS + np.array([400.0, -300.0, 500.0])), "far.obj")["id"]
    both = [service.get(f"/v1/objects/{id_}/stable-poses")["items"] for id_ in (near, far)]
    chances = [sorted(pose["probability"] for pose in poses) for poses in both]
    assert chances[0] == pytest.approx(chances[1], abs=1e-6)


@pytest.mark.parametrize("name", ["block", "mallet", "mug"])
def test_the_shipped_objects_cause_no_warning(service: Service, name: str) -> None:
    file = asset_path(name) / f"{name}.obj"
    assert upload(service, file.read_bytes(), file.name)["warnings"] == []
