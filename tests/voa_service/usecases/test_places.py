"""Weights of a session's places: from the scans of its history, whatever is kept of them and whoever else writes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.places import seen_from, spread_scenario
from tests.support.serving import Service
from voa_core.places import Place
from voa_core.scenario import Scenario
from voa_msgs.rankings import VoaRequest
from voa_msgs.sessions import ScanRequest
from voa_service.failures import NotFound
from voa_service.mapping.looks import record_of
from voa_service.mapping.observations import scan_evidence, scan_observation
from voa_service.runtime.cache import Cache
from voa_service.usecases.places import LookedFrom
from voa_store.records import SessionState

ROOM = 2**26
LOOKS = [("E", "A"), ("N", "A"), ("E", "B"), ("E", "A")]


@pytest.fixture
def session(service: Service) -> str:
    """A session that was looked at three times from E, the sensor configuration, and once from N."""
    id_ = service.open(spread_scenario(service))
    for sensor, pose in LOOKS:
        service.post(f"/v1/sessions/{id_}/scans", seen_from(service, sensor, pose))
    return id_


def states(service: Service, session: str) -> list[SessionState]:
    return [entry.state for entry in service.inside.sessions.store.history(session, -1, 99)]


def scenario_of(service: Service, state: SessionState) -> Scenario:
    return service.inside.sessions.model_of(state).scenario


def looked_from(service: Service, budget: int = ROOM) -> LookedFrom:
    """The use cases as in a process that has just started."""
    return LookedFrom(service.inside.sessions.store, Cache(budget))


def expected(service: Service, scenario: Scenario, versions: Sequence[int], copies: int = 64) -> Place:
    """The sum of the looks of E with these versions, compared one after the other."""
    place = Place(None, (), np.zeros((len(scenario.poses), 1)))
    for version in versions:
        request = ScanRequest.model_validate(seen_from(service, *LOOKS[version - 1]))
        place = place.with_look(version, scan_evidence(scenario, request, copies).log_copies)
    return place


def count_comparisons(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Return a list that grows with each scan of the history that is compared again."""
    calls: list[Any] = []

    def compared(*given: Any) -> Any:
        calls.append(given)
        return scan_evidence(*given)

    monkeypatch.setattr("voa_service.usecases.places.scan_evidence", compared)
    return calls


def assert_same(place: Place, other: Place) -> None:
    assert place.looks == other.looks
    assert place.log_sums.tobytes() == other.log_sums.tobytes()


def test_a_process_without_any_weights_computes_them_from_the_history(service: Service, session: str) -> None:
    state = states(service, session)[-1]
    scenario = scenario_of(service, state)
    for copies in (64, 256):
        place = looked_from(service).place(state, scenario, 0, copies)
        assert place.copies == copies
        assert_same(place, expected(service, scenario, [1, 3, 4], copies))


@pytest.mark.parametrize("kept_at", [1, 2, 3])
def test_only_the_looks_after_the_newest_that_is_kept_are_compared(
    service: Service, session: str, kept_at: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    all_states = states(service, session)
    scenario, places = scenario_of(service, all_states[-1]), looked_from(service)
    places.place(all_states[kept_at], scenario, 0, 64)
    compared = count_comparisons(monkeypatch)
    place = places.place(all_states[-1], scenario, 0, 64)
    assert_same(place, expected(service, scenario, [1, 3, 4]))
    assert len(compared) == {1: 2, 2: 2, 3: 1}[kept_at]


@pytest.mark.parametrize("version", [1, 2, 3])
def test_looks_that_others_add_meanwhile_do_not_count_at_an_earlier_version(
    service: Service, session: str, version: int
) -> None:
    """A state is read, and then others write: their looks are in the history already, and not in the state."""
    state = states(service, session)[version]
    scenario = scenario_of(service, state)
    place = looked_from(service).place(state, scenario, 0, 64)
    assert_same(place, expected(service, scenario, [1] if version < 3 else [1, 3]))


def test_scans_from_before_looks_were_recorded_do_not_count(service: Service, session: str) -> None:
    """The record of such a session begins with its next look, and its history has older scans from the same place."""
    state = states(service, session)[-1]
    scenario, record = scenario_of(service, state), record_of(state.looks)
    begun = replace(record, places=(replace(record.places[0], looks=1), record.places[1]))
    place = looked_from(service).place(replace(state, looks=begun.text()), scenario, 0, 64)
    assert_same(place, expected(service, scenario, [4]))


def test_a_session_that_is_deleted_meanwhile_is_missing(service: Service, session: str) -> None:
    state = states(service, session)[-1]
    scenario = scenario_of(service, state)
    service.http.delete(f"/v1/sessions/{session}").raise_for_status()
    with pytest.raises(NotFound, match=session):
        looked_from(service).place(state, scenario, 0, 64)


def test_a_cache_without_room_changes_no_weight(service: Service, session: str) -> None:
    state = states(service, session)[-1]
    scenario = scenario_of(service, state)
    assert_same(looked_from(service, 1).place(state, scenario, 0, 64), expected(service, scenario, [1, 3, 4]))


def test_looks_from_before_the_belief_was_replaced_do_not_count(service: Service, session: str) -> None:
    service.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).raise_for_status()
    service.post(f"/v1/sessions/{session}/scans", seen_from(service, "E", "B"))
    state = states(service, session)[-1]
    scenario = scenario_of(service, state)
    assert record_of(state.looks).since == 5
    place = looked_from(service).place(state, scenario, 0, 64)
    assert place.looks == (6,)
    assert place.log_sums.tobytes() == expected(service, scenario, [3]).log_sums.tobytes()


def test_looks_beyond_the_first_part_of_a_history_count(
    service: Service, session: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voa_service.usecases.places._VERSIONS_AT_ONCE", 2)
    state = states(service, session)[-1]
    scenario = scenario_of(service, state)
    assert_same(looked_from(service).place(state, scenario, 0, 64), expected(service, scenario, [1, 3, 4]))


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    return count_comparisons(monkeypatch)


def test_the_weights_after_a_committed_look_are_kept_for_the_next(
    service: Service, session: str, counted: list[Any]
) -> None:
    service.post(f"/v1/sessions/{session}/scans", seen_from(service, "E", "A"))
    assert counted == []
    rankings = service.inside.rankings
    rankings.answer(rankings.of_session(session, VoaRequest()), check=lambda: None)
    assert counted == []


def test_scans_of_a_place_are_compared_before_the_transaction(
    service: Service, session: str, counted: list[Any]
) -> None:
    state = states(service, session)[-1]
    scenario, places = scenario_of(service, state), looked_from(service)
    request = ScanRequest.model_validate(seen_from(service, "E", "A"))
    scan = places.prepared(state, scan_observation(scenario, request))
    assert len(counted) == 3
    places.updated(state, scan)
    assert len(counted) == 3
