"""Updates of a belief: what each writes, publishes and counts, and what leaves the session as it was."""

import json
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import PREDICTIONS, Service, as_scan, box_obj, data_scenario, mesh_scenario, scan_of, serving
from tests.support.waiting import SECONDS, wait_for
from voa_core.errors import BeamGridMismatch, InvalidInput, UnknownName
from voa_core.mistakes import scans
from voa_core.prediction import ObservationPredictor
from voa_core.scenario import Scenario
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest, UpdateRequest
from voa_service.failures import NotFound, UnknownReference
from voa_service.mapping import models
from voa_service.mapping.observations import ReceivedScan, ScanObservation
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.usecases.updates import Updates
from voa_store.records import SessionChange, SessionState, StoredResponse, Write

GOOD = ScanRequest.model_validate({"sensor": "Q1", "scan": as_scan(PREDICTIONS["Q1"]["P2"])})
UNFIT = ScanRequest.model_validate({"sensor": "Q1", "scan": {"ranges": [0.5] * 3}})
EMPTY = ScanRequest.model_validate({"sensor": "Q1", "scan": {"ranges": [None] * 4}})


def write(kind: Any = "scan", key: str | None = None, session: str = "") -> Write:
    return write_of(kind, b"{}", idempotency_key(key, scope_of(session), kind, None))


@pytest.fixture
def updates(service: Service) -> Updates:
    return service.inside.updates


@pytest.fixture
def session(service: Service, data_id: str) -> str:
    return service.open(data_id)


def test_an_accepted_scan_makes_a_version_and_is_published(updates: Updates, service: Service, session: str) -> None:
    published: list[tuple[str, int | None]] = []

    def note(id_: str, state: SessionState | None) -> None:
        published.append((id_, None if state is None else state.version))

    with service.inside.changes.listening(note):
        response = updates.apply_scan(session, GOOD, write())
    body = json.loads(response.body)
    assert (response.version, body["version"], body["update"]["accepted"]) == (1, 1, True)
    assert body["last_fit_rmsd_mm"] == body["update"]["fit_rmsd_mm"] == 0.0
    assert published == [(session, 1)]


def test_a_scan_that_is_not_accepted_changes_and_publishes_nothing(
    updates: Updates, service: Service, session: str
) -> None:
    published: list[str] = []
    with service.inside.changes.listening(lambda id_, state: published.append(id_)):
        response = updates.apply_scan(session, EMPTY, write())
    assert (response.version, json.loads(response.body)["update"]["reason"]) == (0, "no_beams")
    assert published == []
    assert service.get(f"/v1/sessions/{session}")["version"] == 0


def test_a_scan_of_a_session_that_another_process_has_deleted_is_refused(
    updates: Updates, service: Service, session: str
) -> None:
    store = service.inside.sessions.store
    first = updates.apply_scan(session, GOOD, write(key="K", session=session))
    other = service.open(service.get(f"/v1/sessions/{session}")["scenario"])
    updates.apply_scan(other, GOOD, write())
    store.delete_session(session, None, None)  # of which this process is not told
    assert first.version == 1
    with pytest.raises(NotFound):
        updates.apply_scan(session, GOOD, write(key="K2", session=session))
    assert updates.apply_scan(other, GOOD, write()).version == 2


def test_every_observation_is_counted_by_kind_and_result(service: Service, session: str) -> None:
    counted: list[tuple[str, str]] = []
    attempts: list[tuple[float, bool]] = []

    def attempted(promised: float, *, success: bool) -> None:
        attempts.append((round(promised, 6), success))

    updates = Updates(
        service.inside.sessions,
        service.inside.updates.places,
        lambda kind, result: counted.append((kind, result)),
        attempted,
    )
    updates.apply_scan(session, GOOD, write())
    updates.apply_scan(session, EMPTY, write())
    promised = service.get(f"/v1/sessions/{session}/grasps?grasps=G1")["grasps"][0]["expected_score"]
    outcome = OutcomeRequest(grasp="G1", success=True)
    for _ in range(2):
        updates.report_outcome(session, outcome, write("outcome", "K", session))
    updates.put_belief(session, BeliefRequest(belief=None), write("belief"))
    assert counted == [("scan", "accepted"), ("scan", "no_beams"), ("outcome", "accepted")]
    assert attempts == [(round(promised, 6), True)], "a repetition is no further attempt"


def test_an_outcome_keeps_the_fit_of_the_last_scan(updates: Updates, session: str) -> None:
    updates.apply_scan(session, GOOD, write())
    outcome = updates.report_outcome(session, OutcomeRequest(grasp="G2", success=False), write("outcome"))
    assert (outcome.version, json.loads(outcome.body)["last_fit_rmsd_mm"]) == (2, 0.0)


def test_a_belief_is_replaced_by_the_stated_one_or_by_the_prior(
    updates: Updates, service: Service, data_id: str
) -> None:
    session = service.open(data_id, prior=[0.5, 0.25, 0.25])
    stated = updates.put_belief(session, BeliefRequest(belief=[0.0, 0.0, 1.0]), write("belief"))
    assert json.loads(stated.body)["belief"] == [0.0, 0.0, 1.0]
    reset = updates.put_belief(session, BeliefRequest(belief=None), write("belief"))
    assert (reset.version, json.loads(reset.body)["belief"]) == (2, [0.5, 0.25, 0.25])


def test_a_repeated_write_is_answered_as_before_until_its_session_is_deleted(
    updates: Updates, service: Service, session: str
) -> None:
    own = write(key="k", session=session)
    first = updates.apply_scan(session, GOOD, own)
    assert updates.apply_scan(session, GOOD, own) == first
    assert service.get(f"/v1/sessions/{session}")["version"] == 1
    service.inside.sessions.delete(session, None, None)
    with pytest.raises(NotFound):
        updates.apply_scan(session, GOOD, own)


@contextmanager
def not_found() -> Any:
    with pytest.raises(NotFound, match="there is no session 'nothing'"):
        yield


def test_updates_of_a_session_that_does_not_exist_are_refused(updates: Updates) -> None:
    with not_found():
        updates.apply_scan("nothing", GOOD, write())
    with not_found():
        updates.report_outcome("nothing", OutcomeRequest(grasp="G1", success=True), write("outcome", key="k"))
    with not_found():
        updates.put_belief("nothing", BeliefRequest(belief=None), write("belief"))


def test_requests_that_do_not_fit_the_scenario_are_refused_and_change_nothing(
    updates: Updates, service: Service, session: str
) -> None:
    with pytest.raises(UnknownName):
        updates.report_outcome(session, OutcomeRequest(grasp="G9", success=True), write("outcome"))
    with pytest.raises(InvalidInput):
        updates.put_belief(session, BeliefRequest(belief=[1.0]), write("belief"))
    assert service.get(f"/v1/sessions/{session}")["version"] == 0


def test_an_update_of_a_stated_belief_stores_nothing(updates: Updates, service: Service, data_id: str) -> None:
    before = service.stored()
    request = GOOD.model_dump() | {"scenario": data_id, "belief": [0.5, 0.5, 0.0]}
    estimate = updates.update_once(UpdateRequest.model_validate(request))
    assert (estimate.version, estimate.update.accepted, estimate.last_fit_rmsd_mm) == (None, True, 0.0)
    assert estimate.belief[1] > 0.5 > estimate.belief[0] > estimate.belief[2] == 0.0
    with pytest.raises(UnknownReference, match="'nothing'"):
        updates.update_once(UpdateRequest.model_validate(request | {"scenario": "nothing"}))
    assert service.stored() == before


def test_a_stated_belief_has_no_fit_where_no_pose_explains_the_scan(updates: Updates, service: Service) -> None:
    exact = service.create(data_scenario(update={"rule": "margin", "no_return_m": 1.0}))
    request = ScanRequest.model_validate({"sensor": "Q1", "scan": {"ranges": [0.7] * 4}}).model_dump()
    belief = [0.5, 0.5, 0.0]
    refused = updates.update_once(UpdateRequest.model_validate(request | {"scenario": exact, "belief": belief}))
    assert (refused.update.accepted, refused.update.reason) == (False, "no_match")
    assert (refused.belief, refused.last_fit_rmsd_mm) == (belief, None)
    assert refused.update.fit_rmsd_mm is not None


@contextmanager
def held(store: Any, session: str) -> Iterator[None]:
    """Hold up all writes of a store within the step of one."""
    entered, let_go = threading.Event(), threading.Event()

    def hold(change: SessionChange, state: SessionState) -> None:
        entered.set()
        assert let_go.wait(SECONDS)
        change.respond(StoredResponse("", state.version))

    with ThreadPoolExecutor(1) as pool:
        holding = pool.submit(store.change, session, write("outcome"), hold)
        try:
            assert entered.wait(SECONDS)
            yield
        finally:
            let_go.set()
            holding.result(SECONDS)


@pytest.mark.parametrize("quick", [True, False])
def test_scans_that_are_compared_in_a_moment_are_compared_by_the_thread_that_commits_them(
    quick: bool, updates: Updates, service: Service, data_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voa_service.mapping.observations._FEW_RANGES", 2**18 if quick else 0)
    threads: list[int] = []
    observation = ReceivedScan.observation

    def compare(received: ReceivedScan, *, quickly: bool = False) -> ScanObservation:
        threads.append(threading.get_ident())
        return observation(received, quickly=quickly)

    monkeypatch.setattr(ReceivedScan, "observation", compare)
    store: Any = service.inside.sessions.store
    other, *sessions = [service.open(data_id) for _ in range(5)]

    def wait_together() -> bool:
        return len(store._session_writer._groups._waiting) == 3

    with ThreadPoolExecutor(4) as pool:
        with held(store, other):
            scans = [
                pool.submit(updates.apply_scan, session, request, write())
                for session, request in zip(sessions, [GOOD, GOOD, UNFIT, EMPTY], strict=True)
            ]
            wait_for(wait_together, "the scans to wait for the transaction")
            assert len(threads) == (0 if quick else 3)
        with pytest.raises(BeamGridMismatch):
            scans.pop(2).result(SECONDS)
        assert [scan.result(SECONDS).version for scan in scans] == [1, 1, 0]
    assert len(threads) == 3
    assert not quick or len(set(threads)) == 1


@pytest.mark.parametrize("fits", [True, False])
def test_predictions_and_searches_for_mistakes_are_made_before_the_transaction(
    fits: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    within: list[tuple[str, bool]] = []

    def noting(owner: Any, name: str) -> None:
        own = getattr(owner, name)

        def noted(*given: Any) -> Any:
            within.append((name, groups._working))
            return own(*given)

        monkeypatch.setattr(owner, name, noted)

    with serving(tmp_path) as service:
        scenario = service.create(mesh_scenario(service.upload(box_obj())))
        session, sensor = service.open(scenario), service.get(f"/v1/scenarios/{scenario}")["sensors"][0]["name"]
        ranges = service.post(f"/v1/scenarios/{scenario}/predictions", {"sensors": [sensor]})["ranges"][0][0]
    with serving(tmp_path) as service:
        groups = service.inside.sessions.store._session_writer._groups  # type: ignore[attr-defined]  # not of the port
        noting(ObservationPredictor, "_predict")
        noting(Scenario, "evidence")
        noting(scans, "_readings")
        noting(models, "mistakes_of_scenario")
        far = [None if value is None else value if fits else 0.5 * value for value in ranges]
        nothing = [beam for beam, value in enumerate(far) if value is None]
        body = {"sensor": sensor, "scan": {"ranges": far, "no_return": nothing}}
        answer = service.inside.updates.apply_scan(session, ScanRequest.model_validate(body), write())
    assert [inside for name, inside in within if name == "evidence"] == ([True] if fits else [True, False])
    others = {(name, inside) for name, inside in within if name != "evidence"}
    search = {("_predict", False), ("mistakes_of_scenario", False)}
    assert others == (search if fits else search | {("_readings", False)})
    assert any(warning["kind"] == "poor-fit" for warning in json.loads(answer.body)["warnings"]) is not fits


def test_a_rehearsal_changes_nothing_and_reads_what_the_next_scan_needs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with serving(tmp_path) as before:
        session = before.open(before.create(data_scenario()))
    with serving(tmp_path) as after:
        rows, counted = after.stored(), observations(after)
        with after.inside.changes.listening(lambda *change: pytest.fail(f"published {change}")):
            after.inside.updates.rehearse()
        assert after.stored() == rows
        assert observations(after) == counted
        for read in ("get_scenario", "get_session"):
            monkeypatch.setattr(after.inside.sessions.store, read, lambda id_: pytest.fail(f"read {id_} again"))
        assert after.inside.updates.apply_scan(session, GOOD, write()).version == 1


def test_a_rehearsal_compares_no_earlier_look(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(tmp_path) as before:
        mesh = before.upload(box_obj())
        session = before.open(before.create(mesh_scenario(mesh) | {"spread": {"xy_m": 0.005, "yaw_rad": 0.05}}))
        scenario = before.get(f"/v1/sessions/{session}")["scenario"]
        sensor = before.get(f"/v1/scenarios/{scenario}")["sensors"][0]["name"]
        ranges = before.post(f"/v1/scenarios/{scenario}/predictions", {"sensors": [sensor]})["ranges"][0][0]
        nothing = [beam for beam, value in enumerate(ranges) if value is None]
        answer = before.post(f"/v1/sessions/{session}/scans", scan_of(ranges, sensor, no_return=nothing))
        assert answer["places"][0]["looks"] == 1
    with serving(tmp_path) as after:
        monkeypatch.setattr(after.inside.sessions.store, "history", lambda *_: pytest.fail("read the history"))
        after.inside.updates.rehearse()


def test_a_rehearsal_leaves_out_a_session_with_very_many_poses(
    updates: Updates, service: Service, session: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert service.get(f"/v1/sessions/{session}")["poses"] == ["P1", "P2", "P3"]
    monkeypatch.setattr(ReceivedScan, "observation", lambda *_: pytest.fail("compared a scan"))
    monkeypatch.setattr("voa_service.usecases.updates._MOST_REHEARSED", 2)
    updates.rehearse()


def test_without_a_session_there_is_nothing_to_rehearse(updates: Updates, service: Service) -> None:
    rows = service.stored()
    updates.rehearse()
    assert service.stored() == rows


def observations(service: Service) -> list[str]:
    return [line for line in service.http.get("/metrics").text.splitlines() if line.startswith("voa_observations")]
