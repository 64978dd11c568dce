"""Old sessions are removed whole, and only those that have not moved."""

from collections.abc import Callable
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from tests.support.audit import audited
from tests.support.serving import Service, data_scenario, serving
from tests.support.waiting import wait_for
from voa_service.bootstrap import utc_now
from voa_service.runtime.steady import SteadyClock
from voa_service.usecases.retention import Retention
from voa_store.sql import SqlStore

UNIFORM = {"belief": [0.2, 0.3, 0.5]}


def retention_of(service: Service, at: Callable[[], datetime], days: float | None) -> Retention:
    sessions = service.inside.sessions
    return Retention(sessions.store, sessions.delete_version, SteadyClock(at), days, 7.0)


def after_days(days: float) -> Callable[[], datetime]:
    return lambda: utc_now() + timedelta(days=days)


def test_sessions_are_removed_once_their_newest_version_is_too_old(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        old, other = (service.open(service.create(data_scenario())) for _ in range(2))
        assert retention_of(service, after_days(29), 30.0).apply(lambda _: False) == 0
        assert retention_of(service, after_days(31), None).apply(lambda _: False) == 0
        assert len(service.get("/v1/sessions")["items"]) == 2
        assert retention_of(service, after_days(31), 30.0).apply(lambda _: False) == 2
        assert service.get("/v1/sessions")["items"] == []
        assert {service.http.get(f"/v1/sessions/{id_}").status_code for id_ in (old, other)} == {404}


def test_each_removed_session_is_in_the_audit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voa_service.bootstrap._FIRST_RETENTION_SECONDS", 0.0)
    with serving(tmp_path) as service:
        session = service.open(service.create(data_scenario()))
    with audited() as audit, serving(tmp_path, retention_days=1e-9) as service:
        wait_for(lambda: service.get("/v1/sessions")["items"] == [], "the removal")
        assert audit.of("session.delete", "caller", "session", "result") == [("retention", session, 204)]


def test_a_session_that_moves_meanwhile_stays(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        session = service.open(service.create(data_scenario()))
        sessions = service.inside.sessions

        def delete(id_: str, version: int) -> bool:
            assert service.http.put(f"/v1/sessions/{id_}/belief", json=UNIFORM).status_code == 200
            return sessions.delete_version(id_, version)

        retention = Retention(sessions.store, delete, SteadyClock(after_days(31)), 30.0, 7.0)
        assert retention.apply(lambda _: False) == 0
        assert service.get(f"/v1/sessions/{session}")["version"] == 1


def test_whoever_waits_for_the_session_is_notified(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        session = service.open(service.create(data_scenario()))
        notified: list[tuple[str, object]] = []
        own = replace(service.inside.sessions, committed=lambda id_, state: notified.append((id_, state)))
        assert own.delete_version(session, 0)
        assert notified == [(session, None)]


def test_a_clock_that_is_set_forward_removes_neither_sessions_nor_responses(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        session = service.open(service.create(data_scenario()))
        ahead = [timedelta()]

        def wall() -> datetime:
            return utc_now() + ahead[0]

        sessions = service.inside.sessions
        store = SqlStore(f"sqlite:///{service.database}", seconds=lambda: wall().timestamp())
        retention = Retention(store, sessions.delete_version, SteadyClock(wall), 30.0, 7.0)
        path, key = f"/v1/sessions/{session}/belief", {"Idempotency-Key": "again"}
        first = service.http.put(path, json=UNIFORM, headers=key).json()
        ahead[0] = timedelta(days=400)
        assert retention.apply(lambda _: False) == 0
        assert service.http.put(path, json=UNIFORM, headers=key).json() == first
        started_after = Retention(store, sessions.delete_version, SteadyClock(wall), 30.0, 7.0)
        assert started_after.apply(lambda _: False) == 1
        store.close()
