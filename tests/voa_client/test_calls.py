"""Calls as HTTP requests and as remote calls by name: both carry equal requests."""

import base64
import inspect
import json
from typing import Any, get_type_hints

import pytest

from voa_client import UsageError
from voa_client import _calls as calls
from voa_client._call import Call
from voa_msgs.looks import LookAnnouncement
from voa_msgs.objects import Object, ObjectPage, ObjectUpload
from voa_msgs.rankings import RankingRequest, VoaRequest
from voa_msgs.robots import ClaimRequest
from voa_msgs.scenarios import PredictionsRequest
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, Scan, ScanRequest, SessionRequest, UpdateRequest

SCAN = ScanRequest(sensor="Q1", scan=Scan(ranges=[0.5, None]))
NAMED = {"session": "s"}
CASES: list[tuple[Call[Any], str, str, dict[str, Any]]] = [
    (calls.health(), "service.health", "GET /readyz", {}),
    (calls.caller(), "caller.get", "GET /v1/caller", {}),
    (calls.get_object("o"), "object.get", "GET /v1/objects/o", {"id": "o"}),
    (calls.stable_poses("o"), "object.stable_poses", "GET /v1/objects/o/stable-poses", {"id": "o"}),
    (calls.object_mesh("o", 500), "object.mesh", "GET /v1/objects/o/mesh", {"id": "o", "most_faces": 500}),
    (calls.delete_object("o"), "object.delete", "DELETE /v1/objects/o", {"id": "o"}),
    (calls.delete_scenario("c"), "scenario.delete", "DELETE /v1/scenarios/c", {"id": "c"}),
    (calls.list_objects("c"), "object.list", "GET /v1/objects", {"after": "c"}),
    (calls.list_scenarios(None), "scenario.list", "GET /v1/scenarios", {}),
    (calls.get_scenario("c"), "scenario.get", "GET /v1/scenarios/c", {"id": "c"}),
    (
        calls.predict("c", PredictionsRequest(sensors=["Q1"])),
        "scenario.predict",
        "POST /v1/scenarios/c/predictions",
        {"id": "c", "sensors": ["Q1"]},
    ),
    (calls.warnings("c"), "scenario.warnings", "GET /v1/scenarios/c/warnings", {"id": "c"}),
    (calls.create_session(SessionRequest(scenario="c")), "session.create", "POST /v1/sessions", {"scenario": "c"}),
    (calls.get_session("s"), "session.get", "GET /v1/sessions/s", NAMED),
    (calls.delete_session("s", None), "session.delete", "DELETE /v1/sessions/s", NAMED),
    (calls.history("s", "7"), "history.get", "GET /v1/sessions/s/history", NAMED | {"after": "7"}),
    (
        calls.history("s", None, beliefs=True),
        "history.get",
        "GET /v1/sessions/s/history",
        NAMED | {"beliefs": True},
    ),
    (
        calls.put_belief("s", BeliefRequest(belief=None), None),
        "belief.put",
        "PUT /v1/sessions/s/belief",
        NAMED | {"belief": None},
    ),
    (
        calls.report_outcome("s", OutcomeRequest(grasp="G", success=True), None),
        "outcome.report",
        "POST /v1/sessions/s/grasp-outcomes",
        NAMED | {"grasp": "G", "success": True},
    ),
    (
        calls.apply_scan("s", SCAN, None),
        "scan.apply",
        "POST /v1/sessions/s/scans",
        NAMED | {"sensor": "Q1", "scan": {"ranges": [0.5, None]}},
    ),
    (
        calls.report_outcome("s", OutcomeRequest(grasp="G", success=False, object_moved=0.5), None),
        "outcome.report",
        "POST /v1/sessions/s/grasp-outcomes",
        NAMED | {"grasp": "G", "success": False, "object_moved": 0.5},
    ),
    (
        calls.announce_look("s", LookAnnouncement(sensor="Q1", robot="scout")),
        "look.announce",
        "POST /v1/sessions/s/looks",
        NAMED | {"sensor": "Q1", "robot": "scout"},
    ),
    (calls.cancel_look("s", "l"), "look.cancel", "DELETE /v1/sessions/s/looks/l", NAMED | {"look": "l"}),
    (
        calls.rank_looks(
            "s", VoaRequest.model_validate({"from": {"x": 1.0, "y": 2.0}, "cost_per_m": 0.1, "pending": ["Q1"]})
        ),
        "voa.rank",
        "POST /v1/sessions/s/voa",
        NAMED | {"from": {"x": 1.0, "y": 2.0}, "cost_per_m": 0.1, "pending": ["Q1"]},
    ),
    (
        calls.rank_looks("s", VoaRequest(outcomes=True)),
        "voa.rank",
        "POST /v1/sessions/s/voa",
        NAMED | {"outcomes": True},
    ),
    (
        calls.rank_grasps("s", ["G1", "G2"]),
        "grasp.rank",
        "GET /v1/sessions/s/grasps",
        NAMED | {"grasps": ["G1", "G2"]},
    ),
    (calls.rank_grasps("s", None), "grasp.rank", "GET /v1/sessions/s/grasps", NAMED),
    (calls.robots(), "robot.list", "GET /v1/robots", {}),
    (
        calls.claim_robot("r 1", ClaimRequest(session=None)),
        "robot.claim",
        "PUT /v1/robots/r%201/session",
        {"robot": "r 1", "session": None},
    ),
    (
        calls.find_object("Box.OBJ", b"v 0 0 0", 1, None),
        "object.list",
        "GET /v1/objects",
        {"sha256": "7b6f74e68a82e1ba99b66e56054d46975b1869661ffa0c7f17301f69cbb64463", "type": "obj", "scale": 1.0},
    ),
    (
        calls.create_session(SessionRequest(scenario="c", robots=["r"])),
        "session.create",
        "POST /v1/sessions",
        {"scenario": "c", "robots": ["r"]},
    ),
    (
        calls.rank_once(RankingRequest(scenario="c", belief=None)),
        "ranking.compute",
        "POST /v1/rankings",
        {"scenario": "c", "belief": None},
    ),
    (
        calls.rank_once(RankingRequest(scenario="c", belief=None, absent=0.2)),
        "ranking.compute",
        "POST /v1/rankings",
        {"scenario": "c", "belief": None, "absent": 0.2},
    ),
    (
        calls.update_once(UpdateRequest(scenario="c", belief=None, absent=0.2, sensor="Q1", scan=SCAN.scan)),
        "update.compute",
        "POST /v1/updates",
        {"scenario": "c", "belief": None, "absent": 0.2, "sensor": "Q1", "scan": {"ranges": [0.5, None]}},
    ),
    (calls.robot_scan("r 1"), "robot.scan", "GET /v1/robots/r%201/scan", {"robot": "r 1"}),
    (calls.request_look("r 1"), "robot.look", "POST /v1/robots/r%201/look", {"robot": "r 1"}),
]


@pytest.mark.parametrize(("call", "rpc", "http", "payload"), CASES, ids=lambda case: case if type(case) is str else "")
def test_a_call_is_the_same_by_path_and_by_name(call: Call[Any], rpc: str, http: str, payload: dict[str, Any]) -> None:
    assert call.rpc == rpc
    assert f"{call.method} {call.url}" == http
    assert json.loads(call.payload()) == payload
    body = json.loads(call.content() or b"{}")
    assert body | dict(call.ids) | call.parameters == payload


def test_what_changes_a_session_takes_a_key_and_what_takes_long_is_heavy() -> None:
    hints = {name: get_type_hints(made).get("return") for name, made in vars(calls).items() if inspect.isfunction(made)}
    assert len([hint for hint in hints.values() if getattr(hint, "__origin__", None) is Call]) == 34
    writes = {call.rpc for call, *_ in CASES if call.writes}
    assert writes == {"session.create", "session.delete", "belief.put", "outcome.report", "scan.apply", "look.announce"}
    heavy = {call.rpc for call, *_ in CASES if call.heavy}
    meshes = {"object.stable_poses", "object.mesh"}
    assert heavy == meshes | {"scenario.predict", "scenario.warnings", "voa.rank", "ranking.compute"}


def test_what_goes_over_http_only_says_so() -> None:
    only = [call.rpc for call, *_ in CASES if call.http_only]
    assert only == ["robot.claim"]
    with pytest.raises(UsageError, match=r"robot\.claim: can be called over HTTP only; make .* the service's http"):
        calls.claim_robot("r", ClaimRequest(session="s")).check_has_rpc()
    with pytest.raises(UsageError, match=r"session\.delete: if_match can be used over HTTP only"):
        calls.delete_session("s", 3).check_has_rpc()


def test_another_mesh_than_the_requested_one_is_not_returned() -> None:
    """A service that does not know the question lists whatever it has."""
    call = calls.find_object("box.obj", b"v", 1.0)
    at = "2026-01-01T00:00:00Z"
    item = {"id": "a", "name": "box", "extents": [0.1] * 3, "faces": 12, "watertight": True, "created_at": at}

    def result(**more: object) -> Object | None:
        page = {"items": [item, item | {"id": "b"} | more], "next": None}
        return calls.matching_object(call, ObjectPage.model_validate_json(json.dumps(page)))

    assert result() is None
    assert result(sha256="0" * 64) is None
    there = result(sha256=call.query["sha256"])
    assert there is not None
    assert there.id == "b"


def test_an_upload_is_a_form_or_base64() -> None:
    call = calls.create_object("box.obj", b"v 0 0 0\n\xff", "crate", 0.001)
    assert call.upload is not None
    assert call.upload.form() == {"scale": "0.001", "name": "crate"}
    document = ObjectUpload.model_validate_json(call.payload())
    assert (document.filename, document.file, document.name, document.scale) == (
        "box.obj",
        b"v 0 0 0\n\xff",
        "crate",
        0.001,
    )
    plain = json.loads(calls.create_object("box.obj", b"v", None, 1).payload())
    turned = calls.create_object("box.obj", b"v", None, 1.0, "+Y")
    assert turned.upload is not None
    assert turned.upload.form() == {"scale": "1.0", "up": "+Y"}
    assert ObjectUpload.model_validate_json(turned.payload()).up == "+Y"
    assert plain == {"filename": "box.obj", "file": base64.b64encode(b"v").decode(), "scale": 1.0}
    assert call.heavy
    assert call.content() is None


@pytest.mark.parametrize(
    ("id_", "quoted"), [("a/b", "a%2Fb"), ("..", "%2E%2E"), ("a.b", "a.b"), ("ä?#", "%C3%A4%3F%23"), ("%41", "%2541")]
)
def test_an_id_is_one_segment_of_the_path(id_: str, quoted: str) -> None:
    assert calls.get_session(id_).url == f"/v1/sessions/{quoted}"


def test_an_empty_id_is_no_id() -> None:
    with pytest.raises(UsageError, match=r"session\.get: session: expected an id"):
        calls.get_session("")
