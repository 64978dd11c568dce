"""Warnings stand in the answers about scenarios, sessions and scans; they change no digest and no result."""

from typing import Any

import pytest

from tests.support.serving import Json, Service, as_scan, box_obj, data_scenario, mesh_scenario
from voa_msgs.warnings import Warnings
from voa_service.mapping import models

TABLE = {"min": [-0.1, -0.1], "max": [0.1, 0.1]}
FLOATING = [
    {"name": "A", "position": [0.0, 0.0, 0.01], "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0]},
    {"name": "B", "position": [0.0, 0.0, 0.01], "quaternion_wxyz": [0.0, 0.0, 0.0, 1.0]},
]


@pytest.fixture(scope="module")
def box(service: Service) -> str:
    return service.upload(box_obj())


def kinds(answer: Any) -> list[str]:
    return sorted(warning["kind"] for warning in answer["warnings"])


def good(box: str, **changes: Any) -> Json:
    return mesh_scenario(box, **({"workspace": TABLE} | changes))


def test_where_all_is_well_the_list_is_empty(service: Service, box: str) -> None:
    created = service.post("/v1/scenarios", good(box))
    session = service.post("/v1/sessions", {"scenario": created["id"]})
    assert created["warnings"] == session["warnings"] == []
    assert service.get(f"/v1/scenarios/{created['id']}/warnings") == {"items": []}


def test_a_scenario_and_its_sessions_carry_what_is_probably_wrong(service: Service, box: str) -> None:
    body = good(box, name="slips", poses=FLOATING, workspace=None)
    body["scores"] = {"probabilities": [[0.5, 0.5], [0.0, 0.0]]}
    first, again = service.post("/v1/scenarios", body), service.post("/v1/scenarios", body)
    # Half a turn lays the box where it lay, and the scores are the same: A and B are twins.
    expected = ["grasp-never-succeeds", "no-workspace", "pose-height", "twin-poses"]
    assert kinds(first) == kinds(again) == kinds(service.get(f"/v1/scenarios/{first['id']}")) == expected
    session = service.open(first["id"])
    assert kinds(service.get(f"/v1/sessions/{session}")) == expected
    put = service.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).json()
    assert kinds(put) == expected
    floating = next(w for w in first["warnings"] if w["kind"] == "pose-height")
    assert floating["poses"] == ["A", "B"]
    assert floating["sensors"] is None
    assert "10 mm over" in floating["detail"]
    whole = Warnings.model_validate(service.get(f"/v1/scenarios/{first['id']}/warnings"))
    assert sorted(warning.kind for warning in whole.items) == expected


def test_a_scan_carries_its_own_warnings_and_keeps_them_when_it_is_requested_again(service: Service, box: str) -> None:
    id_ = service.create(good(box, name="turned", workspace={"min": [-0.1, -0.1], "max": [0.1, 0.1]}))
    ranges = service.post(f"/v1/scenarios/{id_}/predictions", {"sensors": ["E"]})["ranges"][0][0]
    turned = as_scan(ranges[90:] + ranges[:90])
    session = service.open(id_)
    path, body = f"/v1/sessions/{session}/scans", {"sensor": "E", "scan": turned}
    first = service.post(path, body, **{"Idempotency-Key": "one"})
    assert first == service.post(path, body, **{"Idempotency-Key": "one"})
    assert kinds(first) == ["scan-turned"]
    once = service.post("/v1/updates", body | {"scenario": id_, "belief": [0.5, 0.5]})
    assert once["warnings"] == first["warnings"]
    assert service.post(path, {"sensor": "E", "scan": as_scan(ranges)})["warnings"] == []
    history = service.get(f"/v1/sessions/{session}/history")["items"]
    assert all("warnings" not in (entry["update"] or {}) for entry in history)


def test_a_search_that_fails_hides_no_scenario(service: Service, box: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> None:
        raise FloatingPointError("nobody thought of this")

    monkeypatch.setattr(models, "mistakes_of_scenario", fails)
    created = service.post("/v1/scenarios", good(box, name="unsearchable", workspace=None))
    assert created["warnings"] == []
    assert service.get(f"/v1/sessions/{service.open(created['id'])}")["warnings"] == []


def test_a_new_field_that_has_its_default_changes_no_digest(service: Service) -> None:
    # The digest that the first release gave to this scenario.
    first_release = "0b385e05679ed4b0a4fdc0db98457cf245aad137b0d7d0e16c1b45cc8e9aa3e7"
    assert service.create(data_scenario()) == first_release
    explicit = data_scenario(min_gain=0.005)
    explicit["update"] |= {"on_nothing_seen": "reject"}
    assert service.create(explicit) == first_release
    assert service.create(data_scenario(min_gain=0.0051)) != first_release
    other = data_scenario()
    other["update"] |= {"on_nothing_seen": "evidence"}
    assert service.create(other) != first_release


def test_a_look_must_gain_what_the_scenario_or_the_request_says(service: Service) -> None:
    id_ = service.create(data_scenario(name="gain", min_gain=0.9))
    session = service.open(id_)
    ranking = service.get(f"/v1/sessions/{session}/voa")
    first = ranking["ranking"][0]
    assert 0.0 < first["net_value"] < 0.9
    assert ranking["recommendation"]["action"] == "grasp"
    ranking = service.post(f"/v1/sessions/{session}/voa", {"min_gain": 0.0})
    assert ranking["recommendation"] == {"action": "look", "sensor": first["sensor"], "net_value": first["net_value"]}
    once = {"scenario": id_, "belief": [1 / 3] * 3, "min_gain": first["net_value"], "lookahead": 1}
    assert service.post("/v1/rankings", once)["recommendation"]["action"] == "grasp"


def test_places_that_are_worth_the_same_tie(service: Service) -> None:
    same = {"Q1": data_scenario()["predictions"]["Q1"], "Q2": data_scenario()["predictions"]["Q1"]}
    tied = service.get(f"/v1/sessions/{service.open(service.create(data_scenario(predictions=same)))}/voa")
    assert [look["ties_with_first"] for look in tied["ranking"]] == [True, True]
    apart = service.get(f"/v1/sessions/{service.open(service.create(data_scenario()))}/voa")
    assert [look["ties_with_first"] for look in apart["ranking"]] == [True, False]
