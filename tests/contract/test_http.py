"""The contract over HTTP, on answers of the real service: statuses, headers, versions, and what the numbers mean."""

import math
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from pydantic import BaseModel

from tests.support import twin
from tests.support.serving import (
    LIDAR,
    POSES,
    PREDICTIONS,
    SCORES,
    Json,
    Service,
    as_scan,
    box_obj,
    data_scenario,
    mesh_scenario,
    scan_of,
)
from voa_msgs.lidars import LidarPresets
from voa_msgs.objects import Object, ObjectPage, StablePoses
from voa_msgs.rankings import RankedGrasps, Ranking
from voa_msgs.scenarios import Predictions, Scenario, ScenarioPage
from voa_msgs.sessions import HistoryPage, Session, SessionPage, UpdatedEstimate

GOOD = [0.52, 0.5, None, 1.0]
UNIFORM = [1.0 / 3.0] * 3
BELIEF = [0.2, 0.3, 0.5]


def scans(session: str) -> str:
    return f"/v1/sessions/{session}/scans"


def as_twin(predicted: list[float | None]) -> list[float]:
    return [math.inf if value is None else value for value in predicted]


def measured(ranges: list[float | None]) -> list[float]:
    return [math.nan if value is None else value for value in ranges]


# ---------------------------------------------------------------------------------------------- statuses, messages


def test_creating_is_201_the_same_content_again_200_deleting_204_and_then_404(service: Service) -> None:
    body = data_scenario(name="created once")
    first, again = (service.http.post("/v1/scenarios", json=body) for _ in range(2))
    assert (first.status_code, again.status_code) == (201, 200)
    assert first.json() == again.json()
    opened = service.http.post("/v1/sessions", json={"scenario": first.json()["id"]})
    assert opened.status_code == 201
    path = f"/v1/sessions/{opened.json()['id']}"
    assert service.http.get(path).status_code == 200
    gone = service.http.delete(path)
    assert (gone.status_code, gone.content) == (204, b"")
    assert service.http.get(path).status_code == 404
    assert service.http.delete(path).status_code == 404


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("/v1/objects", ObjectPage),
        ("/v1/lidars", LidarPresets),
        ("/v1/scenarios", ScenarioPage),
        ("/v1/scenarios/{scenario}", Scenario),
        ("/v1/objects/{object}", Object),
        ("/v1/objects/{object}/stable-poses", StablePoses),
        ("/v1/sessions", SessionPage),
        ("/v1/sessions/{session}", Session),
        ("/v1/sessions/{session}/voa", Ranking),
        ("/v1/sessions/{session}/voa?definition=executed&outcomes=true", Ranking),
        ("/v1/sessions/{session}/grasps", RankedGrasps),
        ("/v1/sessions/{session}/history", HistoryPage),
    ],
)
def test_an_answer_is_its_message(service: Service, mesh_id: str, path: str, message: type[BaseModel]) -> None:
    scenario = service.get(f"/v1/scenarios/{mesh_id}")
    session = service.open(mesh_id)
    service.post(scans(session), scan_of([0.28] * 360, "E"))
    answer = service.http.get(path.format(scenario=mesh_id, object=scenario["object"], session=session))
    assert answer.headers["content-type"] == "application/json"
    message.model_validate_json(answer.content)


@pytest.mark.parametrize(
    ("path", "body", "message"),
    [
        ("/v1/updates", {"belief": UNIFORM} | scan_of(GOOD), UpdatedEstimate),
        ("/v1/rankings", {"belief": UNIFORM, "outcomes": True}, Ranking),
    ],
)
def test_a_stateless_answer_is_its_message_with_version_null(
    service: Service, data_id: str, path: str, body: Json, message: type[BaseModel]
) -> None:
    before = service.stored()
    answer = service.post(path, body | {"scenario": data_id})
    message.model_validate(answer, strict=False)
    assert answer["version"] is None
    assert service.stored() == before


def test_predictions_are_their_message_with_or_without_a_body(service: Service, data_id: str) -> None:
    path = f"/v1/scenarios/{data_id}/predictions"
    answers = [service.http.post(path), service.http.post(path, json={}), service.http.post(path, json=None)]
    assert [answer.status_code for answer in answers] == [200, 200, 200]
    told = [Predictions.model_validate_json(answer.content) for answer in answers]
    assert told[0] == told[1] == told[2]
    assert (told[0].sensors, told[0].poses) == (["Q1", "Q2"], list(POSES))
    assert told[0].ranges == [[PREDICTIONS[sensor][pose] for pose in POSES] for sensor in ("Q1", "Q2")]


def test_a_request_id_is_given_back_if_it_is_sane_and_made_up_if_not(service: Service) -> None:
    for offered, kept in (("robot-7:42", True), ("x" * 65, False), ("a b", False), ("", False)):
        answer = service.http.get("/v1/lidars", headers={"x-request-id": offered})
        assert (answer.headers["x-request-id"] == offered) is kept
        assert answer.headers["x-request-id"]


def test_lists_go_on_where_the_page_before_ended(service: Service, data_id: str) -> None:
    opened = [service.open(data_id) for _ in range(5)]
    found: list[str] = []
    query = "limit=2"
    while query:
        page = service.get(f"/v1/sessions?{query}")
        assert len(page["items"]) <= 2
        found += [item["id"] for item in page["items"]]
        query = f"limit=2&after={page['next']}" if page["next"] else ""
    assert found[-5:] == opened
    assert len(set(found)) == len(found)
    assert "belief" not in service.get("/v1/sessions")["items"][0]


# --------------------------------------------------------------------------------------------- versions, keys, tags


def test_versions_start_at_0_count_accepted_scans_and_stand_in_the_etag(service: Service, data_id: str) -> None:
    opened = service.http.post("/v1/sessions", json={"scenario": data_id})
    assert (opened.json()["version"], opened.headers["etag"]) == (0, '"v0"')
    path = f"/v1/sessions/{opened.json()['id']}"
    for version in (1, 2):
        answer = service.http.post(path + "/scans", json=scan_of(GOOD))
        assert (answer.json()["version"], answer.headers["etag"]) == (version, f'"v{version}"')
        read = service.http.get(path)
        assert read.headers["etag"] == f'"v{version}"'
        assert read.json() == {key: value for key, value in answer.json().items() if key != "update"}
    answer = service.http.post(path + "/scans", json=scan_of([None] * 4))
    assert (answer.status_code, answer.headers["etag"]) == (200, '"v2"')
    assert answer.json()["update"] == {
        "accepted": False,
        "reason": "no_beams",
        "log_evidence": None,
        "fit_rmsd_mm": None,
        "fit_hit_rmsd_mm": None,
        "best_fit_pose": None,
        "beams_compared": 0,
    }
    assert service.http.get(path).json() == read.json()
    kinds = [(entry["version"], entry["kind"]) for entry in service.get(path + "/history")["items"]]
    assert kinds == [(0, "prior"), (1, "scan"), (2, "scan")]


@pytest.mark.parametrize("ranges", [GOOD, [None] * 4, [1.9, 1.9, 1.9, 0.2]], ids=["accepted", "no beams", "no match"])
def test_a_key_sent_again_gets_the_first_answer_and_changes_nothing(
    service: Service, ranges: list[float | None]
) -> None:
    session = service.open(service.create(data_scenario(update={"rule": "margin", "margin_m": 0.03})))
    key = {"idempotency-key": "once"}
    first = service.http.post(scans(session), json=scan_of(ranges), headers=key)
    service.post(scans(session), scan_of(GOOD))  # the session moves on
    before = service.stored()
    again = service.http.post(scans(session), json=scan_of(ranges), headers=key)
    assert (again.status_code, again.content) == (first.status_code, first.content) == (200, first.content)
    assert again.headers["etag"] == first.headers["etag"]
    assert service.stored() == before


def test_a_key_is_checked_before_if_match(service: Service, data_id: str) -> None:
    session = service.open(data_id)
    headers = {"idempotency-key": "k", "if-match": '"v0"'}
    first = service.http.post(scans(session), json=scan_of(GOOD), headers=headers)
    again = service.http.post(scans(session), json=scan_of(GOOD), headers=headers)
    assert (first.status_code, again.status_code, again.content) == (200, 200, first.content)
    stale = service.http.post(scans(session), json=scan_of(GOOD), headers=headers | {"idempotency-key": "l"})
    assert stale.status_code == 412
    assert stale.json()["version"] == 1
    fresh = service.http.post(scans(session), json=scan_of(GOOD), headers={"if-match": '"v7", "v1"'})
    assert fresh.json()["version"] == 2
    assert service.http.post(scans(session), json=scan_of(GOOD), headers={"if-match": "*"}).json()["version"] == 3


def test_a_refused_request_does_not_use_up_its_key(service: Service, data_id: str) -> None:
    session = service.open(data_id)
    key = {"idempotency-key": "k"}
    assert service.http.post(scans(session), json=scan_of(GOOD, "Q9"), headers=key).status_code == 422
    stale = service.http.post(scans(session), json=scan_of(GOOD), headers=key | {"if-match": '"v5"'})
    assert stale.status_code == 412
    assert service.http.post(scans(session), json=scan_of(GOOD), headers=key).json()["version"] == 1


def test_a_key_belongs_to_its_session(service: Service, data_id: str) -> None:
    key = {"idempotency-key": "same"}
    for _ in range(2):
        session = service.open(data_id)
        assert service.http.post(scans(session), json=scan_of(GOOD), headers=key).json()["version"] == 1


def test_a_session_is_created_once_per_key_and_deleted_once_per_key(service: Service, data_id: str) -> None:
    key = {"idempotency-key": "new session"}
    first, again = (service.http.post("/v1/sessions", json={"scenario": data_id}, headers=key) for _ in range(2))
    assert (again.status_code, again.content) == (201, first.content)
    assert first.status_code == 201
    other = service.http.post("/v1/sessions", json={"scenario": data_id, "prior": BELIEF}, headers=key)
    assert (other.status_code, other.json()["type"]) == (422, "urn:voa:problem:idempotency-key-reused")
    path = f"/v1/sessions/{first.json()['id']}"
    gone = [service.http.delete(path, headers={"idempotency-key": "end"}).status_code for _ in range(2)]
    assert gone == [204, 204]
    assert service.http.delete(path).status_code == 404


def test_the_same_key_on_another_call_is_refused(service: Service, data_id: str) -> None:
    session = service.open(data_id)
    key = {"idempotency-key": "k"}
    assert service.http.post(scans(session), json=scan_of(GOOD), headers=key).status_code == 200
    answer = service.http.delete(f"/v1/sessions/{session}", headers=key)
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:voa:problem:idempotency-key-reused")
    assert service.http.get(f"/v1/sessions/{session}").status_code == 200


def test_concurrent_duplicates_make_one_version_and_others_one_each(service: Service, data_id: str) -> None:
    session = service.open(data_id)
    together = threading.Barrier(8)

    def send(key: str | None) -> Any:
        together.wait()
        headers = {} if key is None else {"idempotency-key": key}
        return service.http.post(scans(session), json=scan_of(GOOD), headers=headers)

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(send, ["same"] * 5 + [None] * 3))
    assert all(answer.status_code == 200 for answer in answers)
    assert len({answer.content for answer in answers[:5]}) == 1
    assert service.get(f"/v1/sessions/{session}")["version"] == 4
    versions = {answer.json()["version"] for answer in answers}
    assert versions == {1, 2, 3, 4}


# ------------------------------------------------------------------------------------------- beams and acceptance


def test_null_is_missing_in_a_scan_and_no_return_in_a_prediction(service: Service, data_id: str) -> None:
    def update(scan: Json) -> Any:
        return service.post("/v1/updates", {"scenario": data_id, "belief": UNIFORM, "sensor": "Q1", "scan": scan})

    perfect = update(as_scan(PREDICTIONS["Q1"]["P1"]))
    assert perfect["update"]["fit_rmsd_mm"] == 0.0
    assert perfect["update"]["best_fit_pose"] == "P1"
    assert perfect["update"]["beams_compared"] == 4
    missing = update({"ranges": PREDICTIONS["Q1"]["P1"]})
    assert missing["update"]["beams_compared"] == 3
    assert missing["belief"] != perfect["belief"]


def test_what_stands_at_an_index_of_no_return_is_ignored(service: Service, data_id: str) -> None:
    answers = [
        service.post(
            "/v1/updates", {"scenario": data_id, "belief": UNIFORM} | scan_of([0.5, v, 0.6, 1.0], no_return=[1])
        )
        for v in (None, 0.0, 0.4, 99.0)
    ]
    assert all(answer == answers[0] for answer in answers)
    assert answers[0]["update"]["beams_compared"] == 4


FAR = [1.9, 1.9, 1.9, 0.2]


@pytest.mark.parametrize(
    ("update", "ranges", "accepted", "reason"),
    [
        ({"rule": "margin"}, FAR, False, "no_match"),
        ({"rule": "margin", "on_no_match": "reject"}, FAR, False, "no_match"),
        ({"rule": "margin", "on_no_match": "nearest"}, FAR, True, "nearest"),
        ({"rule": "margin", "on_no_match": "nearest"}, [None] * 4, False, "no_beams"),
        ({"rule": "exponential", "reject_above_rmsd_mm": 50.0}, FAR, False, "bad_fit"),
        ({"rule": "margin", "on_no_match": "nearest", "reject_above_rmsd_mm": 50.0}, FAR, False, "bad_fit"),
        ({"rule": "exponential", "reject_above_rmsd_mm": 5000.0}, FAR, True, None),
        ({"rule": "margin"}, [0.5, 0.5, None, 1.0], True, None),
    ],
)
def test_a_scan_is_accepted_or_not_and_says_why(
    service: Service, update: Json, ranges: list[float | None], accepted: bool, reason: str | None
) -> None:
    session = service.open(service.create(data_scenario(update=update | {"no_return_m": 1.0})), prior=BELIEF)
    answer = service.post(scans(session), scan_of(ranges))
    report = answer["update"]
    assert (report["accepted"], report["reason"]) == (accepted, reason)
    assert answer["version"] == int(accepted)
    assert (report["log_evidence"] is None) is (reason is not None)
    if not accepted:
        assert answer["belief"] == BELIEF
        assert answer["last_fit_rmsd_mm"] is None
        assert service.get(f"/v1/sessions/{session}/history")["items"][-1]["version"] == 0
    if reason == "nearest":
        distances = [twin.distance(measured(ranges), as_twin(PREDICTIONS["Q1"][pose]), 1.0) for pose in POSES]
        assert answer["belief"] == pytest.approx(twin.nearest(distances))


# ---------------------------------------------------------------------------------------- sessions against the twin

RULES: list[tuple[str, Json]] = [
    ("margin", {"margin_m": 0.25}),
    ("exponential", {}),
    ("gaussian", {"sigma_m": 0.3}),
    ("inverse_rmsd", {"floor_m": 0.001}),
]


@pytest.mark.parametrize(("rule", "parameters"), RULES)
def test_stateless_calls_session_calls_and_the_twin_agree(service: Service, rule: str, parameters: Json) -> None:
    update = {"rule": rule, "no_return_m": 1.0, "on_no_match": "nearest"} | parameters
    scenario = service.create(data_scenario(update=update))
    session = service.open(scenario, prior=BELIEF)
    twin_parameters = parameters | {"no_return_m": 1.0}

    def logs(beams: list[float], sensor: str) -> tuple[list[float], list[float]]:
        predicted = [as_twin(PREDICTIONS[sensor][pose]) for pose in POSES]
        return (
            [twin.log_weight(rule, twin_parameters, beams, other) for other in predicted],
            [twin.distance(beams, other, 1.0) for other in predicted],
        )

    voa = {}
    for sensor in ("Q1", "Q2"):
        each = [logs(as_twin(PREDICTIONS[sensor][pose]), sensor) for pose in POSES]
        voa[sensor] = twin.value_of_assistance(
            SCORES, BELIEF, [one[0] for one in each], [one[1] for one in each], on_no_match="nearest"
        )
    ranked = service.get(f"/v1/sessions/{session}/voa")
    once = service.post("/v1/rankings", {"scenario": scenario, "belief": BELIEF})
    assert ranked | {"version": None} == once
    assert {look["sensor"]: look["voa"] for look in ranked["ranking"]} == pytest.approx(voa, abs=1e-12)
    assert [look["sensor"] for look in ranked["ranking"]] == [
        ("Q1", "Q2")[i] for i in twin.ranking([voa["Q1"], voa["Q2"]], [0.0, 0.0])
    ]

    stateless = service.post("/v1/updates", {"scenario": scenario, "belief": BELIEF} | scan_of(GOOD))
    applied = service.post(scans(session), scan_of(GOOD))
    shared = set(stateless) - {"version"}
    assert {name: applied[name] for name in shared} == {name: stateless[name] for name in shared}
    expected = twin.update(BELIEF, *logs(measured(GOOD), "Q1"), 3, on_no_match="nearest")
    assert applied["belief"] == pytest.approx(expected.belief, abs=1e-12)
    assert applied["update"]["log_evidence"] == pytest.approx(expected.log_evidence, abs=1e-12)
    grasp, score = twin.best_grasp(SCORES, expected.belief)
    assert applied["best_grasp"] == (None if grasp is None else f"G{grasp + 1}")
    assert applied["expected_score"] == pytest.approx(score, abs=1e-12)
    entropy = -math.fsum(share * math.log(share) for share in expected.belief if share)
    assert applied["entropy_nats"] == pytest.approx(entropy, abs=1e-12)
    grasps = service.get(f"/v1/sessions/{session}/grasps")
    assert grasps["version"] == 1
    assert {row["name"]: row["expected_score"] for row in grasps["grasps"]} == pytest.approx(
        {f"G{x + 1}": twin.expected_score(row, expected.belief) for x, row in enumerate(SCORES)}
    )


def test_executed_value_and_a_sensor_belief_agree_with_the_twin(service: Service, data_id: str) -> None:
    other = [0.6, 0.3, 0.1]
    body = {"scenario": data_id, "belief": BELIEF, "definition": "executed", "sensor_belief": other, "sensors": ["Q1"]}
    predicted = [as_twin(PREDICTIONS["Q1"][pose]) for pose in POSES]
    parameters = {"no_return_m": 1.0}
    expected = twin.value_of_assistance(
        SCORES,
        BELIEF,
        [[twin.log_weight("exponential", parameters, scan, pose) for pose in predicted] for scan in predicted],
        [[twin.distance(scan, pose, 1.0) for pose in predicted] for scan in predicted],
        definition="executed",
        sensor_belief=other,
    )
    answer = service.post("/v1/rankings", body)
    assert answer["ranking"][0]["voa"] == pytest.approx(expected, abs=1e-12)
    assert answer["definition"] == "executed"
    assert service.post("/v1/rankings", body | {"sensor_belief": BELIEF})["ranking"] != answer["ranking"]


def test_outcomes_are_listed_only_when_asked_for(service: Service, data_id: str) -> None:
    session = service.open(data_id, prior=BELIEF)
    quiet, told = (service.get(f"/v1/sessions/{session}/voa{query}") for query in ("", "?outcomes=true"))
    assert all("outcomes" not in look for look in quiet["ranking"])
    for look in told["ranking"]:
        assert [outcome["pose"] for outcome in look["outcomes"]] == list(POSES)
        assert [outcome["probability"] for outcome in look["outcomes"]] == pytest.approx(BELIEF)
        after = math.fsum(outcome["probability"] * outcome["expected_score"] for outcome in look["outcomes"])
        assert after == pytest.approx(look["expected_score_after"])
        assert look["voa"] == pytest.approx(after - told["expected_score_before"])


def test_costs_count_and_the_recommendation_follows_them(service: Service) -> None:
    def ranked(*costs: float) -> Any:
        sensors = [
            {"name": f"Q{i + 1}", "x": 0.0, "y": 0.0, "yaw_rad": 0.0, "cost": cost} for i, cost in enumerate(costs)
        ]
        return service.get(f"/v1/sessions/{service.open(service.create(data_scenario(sensors=sensors)))}/voa")

    free = ranked(0.0, 0.0)
    best = free["ranking"][0]
    assert best["voa"] > 0.01
    assert free["recommendation"] == {"action": "look", "sensor": best["sensor"], "net_value": best["net_value"]}
    dear = ranked(1.0, 1.0)
    assert dear["ranking"][0]["net_value"] == pytest.approx(best["voa"] - 1.0)
    assert dear["recommendation"] == {
        "action": "grasp",
        "grasp": dear["best_grasp_before"],
        "expected_score": dear["expected_score_before"],
    }
    first = int(best["sensor"][1]) - 1
    costs = [0.0, 0.0]
    costs[first] = 0.5
    assert ranked(*costs)["ranking"][0]["sensor"] != best["sensor"]


def test_a_subset_of_grasps_is_all_that_counts(service: Service, data_id: str) -> None:
    session = service.open(data_id, prior=BELIEF)
    alone = service.post(f"/v1/sessions/{session}/voa", {"grasps": ["G1"]})
    assert alone["best_grasp_before"] == "G1"
    assert alone["expected_score_before"] == pytest.approx(twin.expected_score(SCORES[0], BELIEF))
    listed = service.get(f"/v1/sessions/{session}/grasps?grasps=G2")
    assert [row["name"] for row in listed["grasps"]] == ["G2"]


def test_a_grasp_that_cannot_succeed_is_none(service: Service) -> None:
    session = service.open(service.create(data_scenario(scores={"probabilities": [[0.0] * 3] * 2})))
    assert service.get(f"/v1/sessions/{session}")["best_grasp"] is None
    ranking = service.get(f"/v1/sessions/{session}/voa")
    assert ranking["best_grasp_before"] is None
    assert ranking["recommendation"] == {"action": "grasp", "grasp": None, "expected_score": 0.0}


# ------------------------------------------------------------------------------------------------------- scenarios


def test_a_scenario_is_named_by_its_content(service: Service) -> None:
    one, same = (service.create(data_scenario(name="digest")) for _ in range(2))
    assert one == same
    assert service.create(data_scenario(name="another")) != one
    explicit = data_scenario(name="digest", prior=None, workspace=None)
    explicit["update"] |= {"on_no_match": "reject", "score_floor": 0.0, "reject_above_rmsd_mm": None}
    assert service.create(explicit) == one
    filled = service.get(f"/v1/scenarios/{one}")
    assert filled["update"]["no_return_m"] == 1.0
    assert filled["lidar"]["noise_m"] > 0.0
    assert filled["grasps"][0]["data"] == {"width_m": 0.018}
    del filled["id"], filled["created_at"], filled["warnings"]
    again = service.http.post("/v1/scenarios", json=filled)
    assert (again.status_code, again.json()["id"]) == (200, one)


def test_a_filled_in_preset_posted_again_is_the_same_scenario(service: Service, mesh_id: str) -> None:
    filled = service.get(f"/v1/scenarios/{mesh_id}")
    assert (filled["lidar"]["preset"], filled["lidar"]["beams"]) == ("lds-01", 360)
    assert (filled["lidar"]["range_min"], filled["lidar"]["range_max"], filled["lidar"]["zero"]) == (
        0.12,
        3.5,
        "missing",
    )
    del filled["id"], filled["created_at"], filled["warnings"]
    assert service.create(filled) == mesh_id


@pytest.mark.parametrize("rule", ["margin", "gaussian", "inverse_rmsd", "beam"])
def test_every_parameter_of_a_rule_is_filled_in(service: Service, rule: str) -> None:
    stored = service.get(f"/v1/scenarios/{service.create(data_scenario(update={'rule': rule}))}")
    empty = [name for name, value in stored["update"].items() if value is None]
    assert empty == ["reject_above_rmsd_mm"]
    assert stored["update"]["no_return_m"] == LIDAR["range_max"]


# ------------------------------------------------------------------------------------------------------ with a mesh

EAST = {"x": 0.3, "y": 0.0, "yaw_rad": math.pi}


def test_a_mesh_is_predicted_as_the_ray_caster_sees_it(service: Service, mesh_id: str) -> None:
    told = service.post(f"/v1/scenarios/{mesh_id}/predictions", {"sensors": ["E", EAST | {"height_m": 0.9}]})
    assert told["sensors"] == ["E", "1"]
    assert told["poses"] == ["A", "B"]
    assert told["ranges"][0][0][0] == pytest.approx(0.28)  # the box is 0.04 deep along x
    assert told["ranges"][0][1][0] == pytest.approx(0.27)  # and 0.06 along y
    assert told["ranges"][0][0][180] is None
    assert all(value is None for pose in told["ranges"][1] for value in pose)  # over the box


def test_predictions_ignore_the_workspace_and_updates_do_not(service: Service) -> None:
    box = service.upload(box_obj())
    open_, boxed = (
        service.create(mesh_scenario(box, workspace=space))
        for space in (None, {"min": [0.1, 0.1], "max": [0.2, 0.2]})  # the box is not in it
    )
    path = "/v1/scenarios/{}/predictions"
    assert service.post(path.format(open_), {}) == service.post(path.format(boxed), {})
    seen = service.post(path.format(open_), {"sensors": ["E"]})["ranges"][0][0]
    reports = [
        service.post("/v1/updates", {"scenario": scenario, "belief": [0.5, 0.5], "sensor": "E", "scan": as_scan(seen)})
        for scenario in (open_, boxed)
    ]
    assert reports[0]["belief"][0] > 0.5
    assert reports[1]["belief"] == [0.5, 0.5]
    assert [
        look["voa"] for look in service.post("/v1/rankings", {"scenario": boxed, "belief": [0.5, 0.5]})["ranking"]
    ] == [
        0.0,
        0.0,
    ]


def test_sensor_poses_may_be_anywhere_with_a_mesh(service: Service, mesh_id: str) -> None:
    session = service.open(mesh_id)
    body = {"sensors": ["N", EAST, EAST | {"name": "dear", "cost": 0.3}]}
    looks = {look["sensor"]: look for look in service.post(f"/v1/sessions/{session}/voa", body)["ranking"]}
    assert set(looks) == {"N", "1", "dear"}
    assert looks["dear"]["voa"] == looks["1"]["voa"] > 0.0
    assert looks["dear"]["net_value"] == pytest.approx(looks["1"]["voa"] - 0.3)
    own = {look["sensor"]: look["voa"] for look in service.get(f"/v1/sessions/{session}/voa")["ranking"]}
    assert looks["1"]["voa"] == pytest.approx(own["E"], abs=1e-12)
    seen = service.post(f"/v1/scenarios/{mesh_id}/predictions", {"sensors": [EAST]})["ranges"][0][0]
    by_name = {"scenario": mesh_id, "belief": [0.5, 0.5], "sensor": "E", "scan": as_scan(seen)}
    by_pose = {key: value for key, value in by_name.items() if key != "sensor"} | {"sensor_pose": EAST}
    assert service.post("/v1/updates", by_pose) == service.post("/v1/updates", by_name)


def test_a_scan_on_other_beams_is_predicted_at_its_own_angles(service: Service, mesh_id: str) -> None:
    seen = service.post(f"/v1/scenarios/{mesh_id}/predictions", {"sensors": ["E"]})["ranges"][0]
    body = {"scenario": mesh_id, "belief": [0.5, 0.5], "sensor": "E"}
    full = service.post("/v1/updates", body | {"scan": as_scan(seen[1])})
    # Five beams around the middle, and the whole turn the other way round.
    step = math.radians(1.0)
    few = as_scan([*seen[1][358:], *seen[1][:3]]) | {"angle_min": -2 * step, "angle_increment": step}
    clockwise = as_scan([seen[1][-i % 360] for i in range(360)]) | {"angle_increment": -step}
    for scan, beams in ((few, 5), (clockwise, 360)):
        answer = service.post("/v1/updates", body | {"scan": scan})
        assert answer["update"]["beams_compared"] == beams
        assert answer["update"]["best_fit_pose"] == "B"
        assert answer["update"]["fit_rmsd_mm"] == pytest.approx(0.0, abs=1e-4)
    assert answer["belief"] == pytest.approx(full["belief"], abs=1e-9)


def test_an_uncertain_sensor_pose_says_less_than_a_sure_one(service: Service, mesh_id: str) -> None:
    seen = service.post(f"/v1/scenarios/{mesh_id}/predictions", {"sensors": [EAST]})["ranges"][0][0]

    def belief(std: Json | None) -> float:
        place = EAST if std is None else EAST | {"std": std}
        body = {"scenario": mesh_id, "belief": [0.5, 0.5], "sensor_pose": place, "scan": as_scan(seen)}
        return float(service.post("/v1/updates", body)["belief"][0])

    sure = belief(None)
    assert belief({}) == belief({"xy_m": 0.0, "yaw_rad": 0.0}) == sure
    assert 0.5 < belief({"xy_m": 0.02}) < sure
    assert 0.5 < belief({"yaw_rad": 0.2}) < sure


def test_listed_sensors_use_the_data_and_other_poses_the_mesh(service: Service) -> None:
    flat: list[float | None] = [0.5] + [None] * 359
    scenario = service.create(mesh_scenario(service.upload(box_obj()), predictions={"E": {"A": flat, "B": flat}}))
    told = service.post(f"/v1/scenarios/{scenario}/predictions", {"sensors": ["E", "N", EAST]})
    assert told["ranges"][0] == [flat, flat]
    assert told["ranges"][1][0][0] == pytest.approx(0.27)
    assert told["ranges"][2][0][0] == pytest.approx(0.28)


def test_a_pose_model_prior_moves_the_belief(service: Service, mesh_id: str) -> None:
    prior = {"form": "pose_model", "categories": [{"pose": "A", "probability": 1.0, "yaw_concentration": 2.0}]}
    session = service.get(f"/v1/sessions/{service.open(mesh_id, prior=prior)}")
    weights = [math.exp(2.0 * math.cos(yaw)) for yaw in (0.0, math.pi / 2.0)]
    assert session["belief"] == pytest.approx([weight / math.fsum(weights) for weight in weights])
