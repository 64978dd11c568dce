"""Versions, ETags, If-Match and idempotency keys over HTTP."""

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from tests.contract.values import BELIEF, GOOD, scans
from tests.support.serving import Service, data_scenario, scan_of


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
