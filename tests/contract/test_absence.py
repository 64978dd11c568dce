"""The probability that the object lies at none of the poses: what moves it, what sets it back, and who shows it."""

import json
import math
from typing import Any

import pytest

from tests.support.places import seen_from, spread_scenario
from tests.support.serving import Json, Service, data_scenario, json_of
from voa_service.rpc.entry import Rpc

PRIOR = 0.2
RANGES = {pose: [0.4 + 0.1 * number] * 4 for number, pose in enumerate(("P1", "P2", "P3"))}
EMPTY: Json = {"sensor": "Q1", "scan": {"ranges": [None] * 4, "no_return": [0, 1, 2, 3]}}
MISSING: Json = {"sensor": "Q1", "scan": {"ranges": [None] * 4}}
WARNING = "probably-absent"


def seen(pose: str = "P2", off_m: float = 0.0) -> Json:
    return {"sensor": "Q1", "scan": {"ranges": [value + off_m for value in RANGES[pose]]}}


def body(**changes: Any) -> Json:
    return data_scenario(**({"name": "absent", "absent": PRIOR, "predictions": {"Q1": RANGES, "Q2": RANGES}} | changes))


@pytest.fixture(scope="module")
def scenario(service: Service) -> str:
    return service.create(body())


@pytest.fixture
def session(service: Service, scenario: str) -> str:
    return service.open(scenario)


def look(service: Service, session: str, request: Json) -> Json:
    answer: Json = service.post(f"/v1/sessions/{session}/scans", request)
    return answer


def kinds(message: Json) -> list[str]:
    return [warning["kind"] for warning in message["warnings"]]


def distance(ranges: list[float], other: list[float]) -> float:
    return math.dist(ranges, other)


def moved(absent: float, log_absent: float, log_evidence: float) -> float:
    """Bayes' rule for a table without the object, from the page."""
    without, there = absent * math.exp(log_absent), (1.0 - absent) * math.exp(log_evidence)
    return without / (without + there)


def test_a_session_begins_with_the_scenarios_absence(service: Service, session: str, data_id: str) -> None:
    own = service.get(f"/v1/sessions/{session}")
    assert own["absent"] == PRIOR
    assert service.get(f"/v1/sessions/{service.open(data_id)}")["absent"] is None


def test_each_scan_moves_it_by_bayes_rule(service: Service, session: str) -> None:
    absent = PRIOR
    for request in (seen("P2"), seen("P1", 0.05), seen("P2")):
        before = service.get(f"/v1/sessions/{session}")
        answer = look(service, session, request)
        ranges = request["scan"]["ranges"]
        log_absent = -distance(ranges, [1.0] * 4)
        weights = [math.exp(-distance(ranges, predicted)) for predicted in RANGES.values()]
        evidence = sum(b * w for b, w in zip(before["belief"], weights, strict=True))
        assert answer["update"]["log_evidence"] == pytest.approx(math.log(evidence), abs=1e-12)
        absent = moved(absent, log_absent, math.log(evidence))
        assert answer["absent"] == pytest.approx(absent, abs=1e-12)
    assert absent < PRIOR


def test_the_belief_is_that_of_a_scenario_without_absence(service: Service, session: str) -> None:
    plain = service.open(service.create(body(absent=None)))
    for request in (seen("P2"), seen("P1", 0.03)):
        own, other = look(service, session, request), look(service, plain, request)
        assert own["belief"] == other["belief"]
        assert (own["expected_score"], own["update"]) == (other["expected_score"], other["update"])
        assert other["absent"] is None


def test_an_empty_table_moves_absence_alone(service: Service, session: str) -> None:
    look(service, session, seen("P2"))
    before = service.get(f"/v1/sessions/{session}")
    answer = look(service, session, EMPTY)
    assert (answer["update"]["accepted"], answer["update"]["reason"]) == (True, "nothing_seen")
    assert answer["version"] == before["version"] + 1
    assert (answer["belief"], answer["places"]) == (before["belief"], before["places"])
    weights = [math.exp(-distance([1.0] * 4, predicted)) for predicted in RANGES.values()]
    evidence = sum(b * w for b, w in zip(before["belief"], weights, strict=True))
    assert answer["absent"] == pytest.approx(moved(before["absent"], 0.0, math.log(evidence)), abs=1e-12)
    assert answer["update"]["log_evidence"] is None
    assert answer["last_fit_rmsd_mm"] == answer["update"]["fit_rmsd_mm"]


def test_an_empty_table_without_absence_is_not_accepted(service: Service) -> None:
    plain = service.open(service.create(body(absent=None)))
    answer = look(service, plain, EMPTY)
    assert (answer["update"]["accepted"], answer["update"]["reason"]) == (False, "nothing_seen")
    assert answer["version"] == 0


def test_a_scan_without_a_beam_is_not_accepted_all_the_same(service: Service, session: str) -> None:
    answer = look(service, session, MISSING)
    assert (answer["update"]["reason"], answer["version"]) == ("no_beams", 0)
    assert answer["absent"] == PRIOR


def test_a_scan_that_no_pose_explains_moves_absence_to_certainty(service: Service) -> None:
    """Under `margin` a scan without any return has weight 1 where nothing lies there, and 0 at every pose."""
    rule = {"rule": "margin", "margin_m": 0.01, "no_return_m": 1.0, "on_nothing_seen": "evidence"}
    session = service.open(service.create(body(name="margin", update=rule)))
    answer = look(service, session, EMPTY)
    assert (answer["update"]["accepted"], answer["update"]["reason"]) == (True, "no_match")
    assert (answer["absent"], answer["version"], kinds(answer)) == (1.0, 1, ["no-workspace", WARNING])
    assert service.get(f"/v1/sessions/{session}")["absent"] == 1.0
    neither = look(service, session, {"sensor": "Q1", "scan": {"ranges": [0.9] * 4}})
    assert (neither["update"]["accepted"], neither["update"]["reason"], neither["version"]) == (False, "no_match", 1)
    reset = service.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).json()
    assert reset["absent"] == PRIOR


def test_a_replaced_belief_and_a_moved_object_set_it_back(service: Service, session: str) -> None:
    for reset in (
        ("PUT", "belief", {"belief": [0.0, 0.5, 0.5]}),
        ("PUT", "belief", {"belief": None}),
        ("POST", "grasp-outcomes", {"grasp": "G1", "success": True, "object_moved": 0.5}),
    ):
        assert look(service, session, EMPTY)["absent"] > PRIOR + 0.1
        method, path, given = reset
        answer = service.http.request(method, f"/v1/sessions/{session}/{path}", json=given)
        assert answer.json()["absent"] == PRIOR


def test_an_outcome_leaves_it_alone(service: Service, session: str) -> None:
    before = look(service, session, EMPTY)["absent"]
    answer = service.post(f"/v1/sessions/{session}/grasp-outcomes", {"grasp": "G1", "success": False})
    assert answer["absent"] == before


def test_lists_and_histories_show_it(service: Service, session: str, data_id: str) -> None:
    plain, shown = service.open(data_id), [service.get(f"/v1/sessions/{session}")["absent"]]
    shown += [look(service, session, request)["absent"] for request in (EMPTY, seen("P2"), EMPTY)]
    history = service.get(f"/v1/sessions/{session}/history")["items"]
    assert [entry["absent"] for entry in history] == shown
    assert [entry["kind"] for entry in history] == ["prior", "scan", "scan", "scan"]
    listed = {each["id"]: each["absent"] for each in service.get("/v1/sessions?limit=1000")["items"]}
    assert listed[session] == shown[-1]
    assert listed[plain] is None


def test_a_warning_says_above_one_half_that_the_object_is_probably_not_there(service: Service, session: str) -> None:
    path, warned = f"/v1/sessions/{session}", []
    for _ in range(4):
        answer = look(service, session, EMPTY)
        warned.append(answer["absent"] > 0.5)
        for message in (answer, service.get(path), service.get(f"{path}/voa")):
            assert (WARNING in kinds(message)) is warned[-1]
    assert {True, False} == set(warned)
    assert service.get(f"{path}/voa")["recommendation"]["action"] in ("look", "grasp")


@pytest.mark.parametrize("absent", [0.0, 0.3, 1.0])
def test_an_update_once_takes_its_own_absence(service: Service, scenario: str, absent: float) -> None:
    request = seen("P2") | {"scenario": scenario, "belief": None, "absent": absent}
    answer = service.post("/v1/updates", request)
    log_absent = -distance(RANGES["P2"], [1.0] * 4)
    expected = moved(absent, log_absent, answer["update"]["log_evidence"])
    assert answer["absent"] == pytest.approx(expected, abs=1e-12)
    assert (WARNING in kinds(answer)) is (answer["absent"] > 0.5)
    assert json.loads(Rpc(service.inside).answer("update.compute", json_of(request)).body) == answer


def test_an_update_once_without_absence_takes_the_scenarios(service: Service, scenario: str, data_id: str) -> None:
    first = look(service, service.open(scenario), EMPTY)
    once = service.post("/v1/updates", EMPTY | {"scenario": scenario, "belief": None})
    assert (once["absent"], once["update"]) == (first["absent"], first["update"])
    plain = {"sensor": "Q1", "scan": {"ranges": [0.5, 0.5, None, 1.0]}, "scenario": data_id, "belief": None}
    assert service.post("/v1/updates", plain)["absent"] is None
    assert service.post("/v1/updates", plain | {"absent": 0.5})["absent"] is not None


@pytest.mark.parametrize(("absent", "warns"), [(None, False), (0.4, False), (0.6, True), (1.0, True), (0.0, False)])
def test_a_ranking_once_warns_of_its_own_absence(
    service: Service, scenario: str, absent: float | None, warns: bool
) -> None:
    ranking = service.post("/v1/rankings", {"scenario": scenario, "belief": None, "absent": absent})
    assert kinds(ranking) == [WARNING] * warns
    likely = service.create(body(name="likely", absent=0.7))
    ranking = service.post("/v1/rankings", {"scenario": likely, "belief": None, "absent": absent})
    assert kinds(ranking) == [WARNING] * (warns or absent is None)


def test_rankings_of_one_belief_differ_by_their_warnings_alone(service: Service, session: str, scenario: str) -> None:
    other = service.open(scenario)
    for _ in range(4):
        look(service, session, EMPTY)
    absent, there = (service.get(f"/v1/sessions/{id_}/voa") for id_ in (session, other))
    assert (kinds(absent), kinds(there)) == ([WARNING], [])
    for ranking in (absent, there):
        del ranking["warnings"], ranking["version"]
    assert absent == there


@pytest.mark.parametrize("absent", [0.0, 1.0, -0.1, 1.1, "0.5", True])
def test_an_absence_that_is_no_prior_probability_is_refused(service: Service, absent: Any) -> None:
    answer = service.http.post("/v1/scenarios", json=body(absent=absent))
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:voa:problem:invalid-request")
    assert "absent" in answer.json()["detail"]


def test_looks_of_one_place_compare_the_empty_table_with_the_mean_of_the_place(service: Service) -> None:
    """Under a spread, the odds after looks of one place are those of their weights together."""
    scenario_id = spread_scenario(service, name="spread and absent", absent=PRIOR)
    session, log_evidences, log_absents = service.open(scenario_id), 0.0, 0.0
    for off in (0.02, 0.03, 0.01):
        request = seen_from(service, "E", "A", off_m=off)
        before = service.get(f"/v1/sessions/{session}")["absent"]
        answer = look(service, session, request)
        log_evidences += answer["update"]["log_evidence"]
        once = service.post("/v1/updates", request | {"scenario": scenario_id, "belief": None, "absent": 0.5})
        odds = math.log(once["absent"]) - math.log1p(-once["absent"])
        log_absents += odds + once["update"]["log_evidence"]
        assert answer["absent"] != before
    expected = moved(PRIOR, log_absents, log_evidences)
    assert answer["absent"] == pytest.approx(expected, abs=1e-9)
