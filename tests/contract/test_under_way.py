"""Announced looks: listed until a scan from their place, a deletion or two minutes end them; they make no version."""

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.support.places import seen_from, spread_scenario
from tests.support.serving import Json, Service, client, data_scenario, json_of, scan_of
from voa_msgs.rankings import MOST_PENDING
from voa_service.bootstrap import services
from voa_service.rpc.entry import Rpc
from voa_service.settings import Settings
from voa_store.records import SessionState

START = datetime(2026, 1, 2, 12, tzinfo=UTC)
FREE: Json = {"x": 0.3, "y": 0.1, "yaw_rad": math.pi, "height_m": None, "std": None}
GOOD = [0.5, 0.5, None, 1.0]


@dataclass
class Clock:
    """A clock that a test sets."""

    time: datetime = field(default=START)

    def __call__(self) -> datetime:
        return self.time

    def after(self, seconds: float) -> None:
        """Let some seconds pass."""
        self.time += timedelta(seconds=seconds)


@contextmanager
def service_at(database: Path, clock: Clock) -> Iterator[Service]:
    settings = Settings(database_url=f"sqlite:///{database}", workers=2, cache_mebibytes=64)
    with services(settings, clock) as inside, client(inside) as http:
        yield Service(http, inside, database)


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def own(tmp_path: Path, clock: Clock) -> Iterator[Service]:
    with service_at(tmp_path / "voa.db", clock) as running:
        yield running


@pytest.fixture
def scenario(own: Service) -> str:
    return own.create(data_scenario())


@pytest.fixture
def session(own: Service, scenario: str) -> str:
    return own.open(scenario)


def announce(own: Service, session: str, sensor: str | Json = "Q1", key: str | None = None, **more: Any) -> Json:
    place = {"sensor": sensor} if isinstance(sensor, str) else {"sensor_pose": sensor}
    headers = {} if key is None else {"Idempotency-Key": key}
    answer = own.http.post(f"/v1/sessions/{session}/looks", json=place | more, headers=headers)
    assert answer.status_code == 201, answer.text
    body: Json = answer.json()
    return body


def cancel(own: Service, session: str, look: str, key: str | None = None) -> httpx2.Response:
    headers = {} if key is None else {"Idempotency-Key": key}
    return own.http.delete(f"/v1/sessions/{session}/looks/{look}", headers=headers)


def under_way(own: Service, session: str) -> list[Json]:
    looks: list[Json] = own.get(f"/v1/sessions/{session}")["under_way"]
    return looks


def ids(own: Service, session: str) -> list[str]:
    return [look["id"] for look in under_way(own, session)]


def problem(answer: Any) -> tuple[int, str]:
    return answer.status_code, answer.json()["type"].removeprefix("urn:voa:problem:")


# ---------------------------------------------------------------------------------------------------- announcing


def test_an_announced_look_is_listed_with_its_end(own: Service) -> None:
    session = own.open(spread_scenario(own))
    look = announce(own, session, "E", robot="scout")
    assert look == {
        "id": look["id"],
        "sensor": "E",
        "sensor_pose": None,
        "robot": "scout",
        "expires_at": "2026-01-02T12:02:00Z",
    }
    pose = announce(own, session, FREE | {"std": {"xy_m": 0.01, "yaw_rad": 0.02}})
    assert pose["sensor"] is pose["robot"] is None
    assert pose["sensor_pose"] == FREE | {"std": {"xy_m": 0.01, "yaw_rad": 0.02}}
    assert under_way(own, session) == [look, pose]
    assert look["id"] != pose["id"]


def test_an_announcement_makes_no_version_and_no_event(own: Service, session: str) -> None:
    published: list[tuple[str, int | None]] = []
    before = own.get(f"/v1/sessions/{session}")

    def note(id_: str, state: SessionState | None) -> None:
        published.append((id_, None if state is None else state.version))

    with own.inside.changes.listening(note):
        answer = own.http.post(f"/v1/sessions/{session}/looks", json={"sensor": "Q1"})
        assert answer.headers["ETag"] == '"v0"'
        assert cancel(own, session, answer.json()["id"]).status_code == 204
        announce(own, session)
    assert published == []
    assert own.get(f"/v1/sessions/{session}") == before | {"under_way": under_way(own, session)}
    assert [entry["kind"] for entry in own.get(f"/v1/sessions/{session}/history")["items"]] == ["prior"]


def test_an_announcement_takes_no_if_match(own: Service, session: str) -> None:
    for method, path in (("POST", "looks"), ("DELETE", f"looks/{announce(own, session)['id']}")):
        body = {"sensor": "Q1"} if method == "POST" else None
        answer = own.http.request(method, f"/v1/sessions/{session}/{path}", json=body, headers={"If-Match": '"v7"'})
        assert answer.is_success


@pytest.mark.parametrize(
    ("body", "expected", "says"),
    [
        ({"sensor": "Q9"}, (422, "unknown-name"), "'Q1', 'Q2'"),
        ({}, (422, "invalid-request"), "exactly one of"),
        ({"sensor": "Q1", "sensor_pose": FREE}, (422, "invalid-request"), "exactly one of"),
        ({"sensor": "Q1", "robot": ""}, (422, "invalid-request"), "robot"),
        ({"sensor": "Q1", "until": 5}, (422, "invalid-request"), "until"),
        ({"sensor_pose": {"x": 0.0, "y": 0.0}}, (422, "invalid-request"), "yaw_rad"),
    ],
)
def test_a_bad_announcement_is_refused_and_keeps_nothing(
    own: Service, session: str, body: Json, expected: tuple[int, str], says: str
) -> None:
    before = own.stored()
    answer = own.http.post(f"/v1/sessions/{session}/looks", json=body)
    assert problem(answer) == expected
    assert says in answer.json()["detail"]
    assert own.stored() == before


def test_a_session_or_a_look_that_is_not_there_is_404(own: Service, session: str) -> None:
    assert problem(own.http.post("/v1/sessions/nothing/looks", json={"sensor": "Q1"})) == (404, "not-found")
    for where in ("nothing", session):
        answer = cancel(own, where, "nothing")
        assert problem(answer) == (404, "not-found")
        assert "'nothing'" in answer.json()["detail"]


def test_a_session_keeps_the_newest_64(own: Service, session: str) -> None:
    looks = [announce(own, session)["id"] for _ in range(MOST_PENDING + 2)]
    assert MOST_PENDING == 64
    assert ids(own, session) == looks[2:]
    assert problem(cancel(own, session, looks[1])) == (404, "not-found")


# -------------------------------------------------------------------------------------------------------- ending


def test_a_deletion_ends_it_once(own: Service, session: str) -> None:
    first, second = (announce(own, session)["id"] for _ in range(2))
    answer = cancel(own, session, first)
    assert (answer.status_code, answer.content) == (204, b"")
    assert ids(own, session) == [second]
    assert problem(cancel(own, session, first)) == (404, "not-found")


@pytest.mark.parametrize("ranges", [GOOD, [None] * 4], ids=["accepted", "not accepted"])
def test_a_scan_from_there_ends_it(own: Service, session: str, ranges: list[float | None]) -> None:
    announce(own, session, "Q1")
    other = announce(own, session, "Q2")["id"]
    announce(own, session, "Q1")
    answer = own.post(f"/v1/sessions/{session}/scans", scan_of(ranges))
    assert [look["id"] for look in answer["under_way"]] == ids(own, session) == [other]
    assert answer["version"] == answer["update"]["accepted"]


def test_a_scan_from_nearly_there_ends_it(own: Service) -> None:
    session = own.open(spread_scenario(own))
    announce(own, session, FREE)
    far = announce(own, session, FREE | {"x": 0.34})["id"]
    named = announce(own, session, "E")["id"]
    answer = own.post(f"/v1/sessions/{session}/scans", seen_from(own, FREE | {"x": 0.31}, "A"))
    assert [look["id"] for look in answer["under_way"]] == ids(own, session) == [far, named]


def test_other_writes_leave_it(own: Service, session: str) -> None:
    look = announce(own, session)
    own.post(f"/v1/sessions/{session}/grasp-outcomes", {"grasp": "G1", "success": True})
    answer = own.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).json()
    assert answer["under_way"] == under_way(own, session) == [look]


def test_it_ends_by_itself_after_two_minutes(own: Service, session: str, clock: Clock) -> None:
    early = announce(own, session)["id"]
    clock.after(60.0)
    late = announce(own, session)["id"]
    clock.after(59.999)
    assert ids(own, session) == [early, late]
    clock.after(0.001)
    assert ids(own, session) == [late]
    assert problem(cancel(own, session, early)) == (404, "not-found")
    clock.after(60.0)
    assert ids(own, session) == []
    assert own.get(f"/v1/sessions/{session}")["version"] == 0


def test_it_survives_a_restart_and_is_seen_by_other_processes(own: Service, session: str, clock: Clock) -> None:
    look = announce(own, session, robot="scout")
    assert under_way(own, session) == [look]  # which fills the cache of responses
    with service_at(own.database, clock) as other:
        assert under_way(other, session) == [look]
        second = announce(other, session)
        assert under_way(own, session) == [look, second]
        assert cancel(own, session, look["id"]).status_code == 204
        assert under_way(other, session) == [second]
        other.post(f"/v1/sessions/{session}/scans", scan_of([None] * 4))
    assert under_way(own, session) == []


# -------------------------------------------------------------------------------------------------- sent again


def test_an_announcement_sent_again_is_one(own: Service, session: str, clock: Clock) -> None:
    look = announce(own, session, key="k")
    clock.after(30.0)
    assert announce(own, session, key="k") == look
    assert under_way(own, session) == [look]
    answer = own.http.post(f"/v1/sessions/{session}/looks", json={"sensor": "Q2"}, headers={"Idempotency-Key": "k"})
    assert problem(answer) == (422, "idempotency-key-reused")
    clock.after(300.0)
    assert announce(own, session, key="k") == look, "the first answer, although the look has ended"
    assert under_way(own, session) == []


def test_a_deletion_sent_again_succeeds(own: Service, session: str) -> None:
    look, other = (announce(own, session)["id"] for _ in range(2))
    assert [cancel(own, session, look, "gone").status_code for _ in range(2)] == [204, 204]
    assert problem(cancel(own, session, other, "gone")) == (422, "idempotency-key-reused")
    assert ids(own, session) == [other]
    own.http.delete(f"/v1/sessions/{session}").raise_for_status()
    assert cancel(own, session, look, "gone").status_code == 204
    assert problem(cancel(own, session, other)) == (404, "not-found")


def test_a_repeated_scan_ends_no_announcement_made_since(own: Service, session: str) -> None:
    key = {"Idempotency-Key": "scan"}
    own.http.post(f"/v1/sessions/{session}/scans", json=scan_of(GOOD), headers=key).raise_for_status()
    look = announce(own, session)
    own.http.post(f"/v1/sessions/{session}/scans", json=scan_of(GOOD), headers=key).raise_for_status()
    assert under_way(own, session) == [look]


# ------------------------------------------------------------------------------------------------------ by Zenoh


def test_remote_calls_announce_and_withdraw(own: Service, session: str) -> None:
    rpc = Rpc(own.inside)
    payload = json_of({"session": session, "sensor": "Q1", "robot": "scout"})
    attachment = json_of({"id": "call"})
    answers = [rpc.answer("look.announce", payload, attachment) for _ in range(2)]
    assert answers[0] == answers[1]
    look = json.loads(answers[0].body)
    assert under_way(own, session) == [look]
    gone = [rpc.answer("look.cancel", json_of({"session": session, "look": look["id"]})) for _ in range(2)]
    assert [answer.is_problem for answer in gone] == [False, True]
    assert json.loads(gone[1].body)["type"] == "urn:voa:problem:not-found"
    assert under_way(own, session) == []


# ------------------------------------------------------------------------------------------------- their rankings


def test_rankings_take_them_into_account_unless_the_request_says_otherwise(own: Service, clock: Clock) -> None:
    exact = {"rule": "margin", "margin_m": 0.01, "no_return_m": 1.0}  # a second look from one place adds nothing
    session = own.open(own.create(data_scenario(update=exact)))
    path = f"/v1/sessions/{session}/voa"
    alone = own.get(path)
    look = announce(own, session, "Q1")
    pending = own.get(path)
    assert pending == own.post(path, {"pending": ["Q1"]}) == own.post(path, {})
    value = {each["sensor"]: each["voa"] for each in pending["ranking"]}
    assert value["Q1"] == pytest.approx(0.0, abs=1e-12)
    assert {each["sensor"]: each["voa"] for each in alone["ranking"]}["Q1"] > 0.2
    assert own.post(path, {"pending": []}) == alone
    announce(own, session, "Q1")
    assert own.get(path) == own.post(path, {"pending": ["Q1", "Q1"]})
    cancel(own, session, look["id"])
    assert own.get(path) == pending
    clock.after(120.0)
    assert own.get(path) == alone
