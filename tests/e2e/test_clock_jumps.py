"""Clocks that are set forward and back under a running service: nothing is lost, repeated or removed by that."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import httpx2

from tests.support.history_calls import TIMEOUT, Recorder, padded_scan, stored_scenario
from tests.support.history_store import check_stored
from tests.support.machine_clock import MachineClock
from tests.support.replicas import replicas
from tests.support.serving import data_scenario

DAY = 86_400.0
JUMPS = (400 * DAY, -400 * DAY, 3_600.0, -3_600.0, 0.0)
"""Seconds by which the clock is wrong, after each other."""


def announced(http: httpx2.Client, session: str) -> str:
    body = {"sensor": "Q1", "robot": "tb3"}
    return str(http.post(f"/v1/sessions/{session}/looks", json=body).raise_for_status().json()["id"])


def under_way(http: httpx2.Client, session: str) -> list[str]:
    looks = http.get(f"/v1/sessions/{session}").raise_for_status().json()["under_way"]
    return [str(look["id"]) for look in looks]


def test_a_clock_that_is_set_changes_no_version_and_no_answer_and_removes_nothing(tmp_path: Path) -> None:
    url, recorder, clock = f"sqlite:///{tmp_path / 'voa.db'}", Recorder(), MachineClock(tmp_path / "clock")
    environment = clock.environment | {"VOA_RETENTION_DAYS": "30"}
    with (
        replicas(url, tmp_path, environment=environment) as (replica,),
        httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http,
    ):
        session = recorder.create(http, stored_scenario(http, data_scenario()), "session")
        for number, ahead_s in enumerate(JUMPS):
            sent = padded_scan(session, number)
            first = recorder.response(http, sent)
            clock.set(ahead_s)
            stamp = datetime.fromisoformat(
                recorder.response(http, padded_scan(session, 100 + number)).json()["updated_at"]
            )
            assert abs(stamp - datetime.now(UTC) - timedelta(seconds=ahead_s)) < timedelta(seconds=60), "it is set"
            assert recorder.response(http, sent).content == first.content
            assert recorder.version(http, session) == 2 * (number + 1)
            assert http.get("/readyz").status_code == 200

        look = announced(http, session)
        assert under_way(http, session) == [look]
        clock.set(-3_600.0)
        assert under_way(http, session) == [], "it would last for an hour"
        clock.set(0.0)
        announced(http, session)
        clock.set(121.0)
        assert under_way(http, session) == []

        replica.kill()
        clock.set(400 * DAY)
        replica.start()
        assert recorder.version(http, session) == 2 * len(JUMPS), "a clock that is wrong at the start is set right soon"
        assert recorder.response(http, sent).content == first.content
        assert [line for line in replica.log.read_text().splitlines() if "removed" in line] == []
    assert check_stored(url, recorder.calls) == 2 * len(JUMPS)
