"""Server-sent events: the current state first, then each version once and in order, whichever process made it."""

import json
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import httpx2
import pytest

from tests.support.postgres import Server
from tests.support.replicas import Replica, replicas
from tests.support.serving import Json, data_scenario, scan_of

TIMEOUT = 120.0
END_SECONDS = 2.0
MOST_COMMENTS = 5  # one every 15 s


class Event(NamedTuple):
    """Event as it was sent."""

    event: str
    id: str | None
    data: Json

    @property
    def version(self) -> int:
        """Version of a session, which must equal the id of the event."""
        assert self.event == "session"
        assert self.id == str(self.data["version"])
        return int(self.data["version"])


class World:
    """Two processes on one database."""

    def __init__(self, pair: list[Replica], here: httpx2.Client, there: httpx2.Client) -> None:
        self.pair = pair
        self.here = here
        self.there = there
        self.scenario = here.post("/v1/scenarios", json=data_scenario()).json()["id"]

    def session(self, moved: int = 0) -> str:
        id_ = str(self.here.post("/v1/sessions", json={"scenario": self.scenario}).json()["id"])
        for _ in range(moved):
            move(self.here, id_)
        return id_


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def world(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    folder: Path = tmp_path_factory.mktemp("events")
    url = f"sqlite:///{folder / 'voa.db'}"
    if request.param == "postgresql":
        own: Server = request.getfixturevalue("postgres")
        url = own.new_database()
    with (
        replicas(url, folder, 2) as pair,
        httpx2.Client(base_url=pair[0].url, timeout=TIMEOUT) as here,
        httpx2.Client(base_url=pair[1].url, timeout=TIMEOUT) as there,
    ):
        yield World(pair, here, there)


def move(http: httpx2.Client, session: str) -> Json:
    answer = http.post(f"/v1/sessions/{session}/scans", json=scan_of([0.5, 0.5, None, 1.0]))
    assert answer.status_code == 200, answer.text
    body: Json = answer.json()
    return body


@contextmanager
def following(http: httpx2.Client, session: str, last: str | None = None) -> Iterator[Iterator[Event]]:
    """The events of a session; they end where the stream does."""
    headers = {} if last is None else {"Last-Event-ID": last}
    with http.stream("GET", f"/v1/sessions/{session}/events", headers=headers) as answer:
        assert answer.status_code == 200
        assert answer.headers["content-type"].startswith("text/event-stream")
        yield events_of(answer.iter_lines())


def dump() -> None:
    import subprocess
    out = subprocess.run("for p in $(pgrep -f voa_service); do echo == $p; /tmp/spy/bin/py-spy dump --pid $p; done", shell=True, capture_output=True, text=True).stdout
    open("/tmp/ev_dump.txt", "a").write(out)


def events_of(lines: Iterator[str]) -> Iterator[Event]:
    """Read events; comments that keep the connection alive must not hide that no event comes."""
    fields: dict[str, str] = {}
    comments = 0
    for line in lines:
        if line == "":
            if "event" in fields:
                yield Event(fields["event"], fields.get("id"), json.loads(fields["data"]))
                comments = 0
            fields = {}
        elif line.startswith(":"):
            comments += 1
            dump()
            assert comments < MOST_COMMENTS, "no event came, only comments that keep the connection alive"
        else:
            name, _, value = line.partition(": ")
            fields[name] = value


def test_the_current_state_comes_first_and_is_the_session_body(world: World) -> None:
    session = world.session(moved=2)
    with following(world.here, session) as events:
        first = next(events)
    assert first.version == 2
    assert first.data == world.here.get(f"/v1/sessions/{session}").json()


def test_each_version_comes_once_in_order_whichever_process_made_it(world: World) -> None:
    session = world.session()
    with following(world.here, session) as mine, following(world.there, session) as theirs:
        assert [next(mine).version, next(theirs).version] == [0, 0]
        for version in range(1, 9):
            state = move(world.here if version % 3 else world.there, session)
            state.pop("update")
            for events in (mine, theirs):
                event = next(events)
                assert event.version == version
                assert event.data == state


def test_events_show_absence_and_places_and_announcements_make_none(world: World) -> None:
    ranges = {"P1": [0.4] * 4, "P2": [0.5] * 4, "P3": [0.6] * 4}
    body = data_scenario(name="absent", absent=0.2, predictions={"Q1": ranges, "Q2": ranges})
    scenario = world.here.post("/v1/scenarios", json=body).raise_for_status().json()["id"]
    session = world.here.post("/v1/sessions", json={"scenario": scenario}).json()["id"]
    path = f"/v1/sessions/{session}"
    with following(world.there, session) as events:
        assert next(events).data["absent"] == 0.2
        look = world.here.post(f"{path}/looks", json={"sensor": "Q2"}).raise_for_status().json()
        for ranges_seen, sensor in (([None] * 4, "Q1"), ([0.5] * 4, "Q1")):
            gone = [number for number, value in enumerate(ranges_seen) if value is None]
            answer = world.here.post(f"{path}/scans", json=scan_of(ranges_seen, sensor, no_return=gone)).json()
            answer.pop("update")
            event = next(events)
            assert event.data == answer
            assert event.data["under_way"] == [look]
        assert [place["looks"] for place in event.data["places"]] == [1]
        assert event.version == 2


def test_a_burst_of_another_process_comes_completely(world: World) -> None:
    session = world.session()
    with following(world.here, session) as events:
        assert next(events).version == 0
        for _ in range(20):
            move(world.there, session)
        assert [next(events).version for _ in range(20)] == list(range(1, 21))


def test_a_scan_that_is_not_accepted_is_no_event(world: World) -> None:
    session = world.session()
    with following(world.here, session) as events:
        assert next(events).version == 0
        answer = world.here.post(f"/v1/sessions/{session}/scans", json=scan_of([None] * 4))
        assert answer.json()["update"]["accepted"] is False
        move(world.here, session)
        assert next(events).version == 1


@pytest.mark.parametrize(("last", "expected"), [("0", [1, 2, 3, 4]), ("2", [3, 4]), ("3", [4])])
def test_last_event_id_continues_after_that_version(world: World, last: str, expected: list[int]) -> None:
    session = world.session(moved=3)
    with following(world.there, session, last) as events:
        before = [next(events).version for _ in expected[:-1]]
        move(world.here, session)
        assert [*before, next(events).version] == expected


@pytest.mark.parametrize("last", ["99", "9" * 18])
def test_last_event_id_of_the_future_gets_the_current_state(world: World, last: str) -> None:
    session = world.session(moved=1)
    with following(world.here, session, last) as events:
        assert next(events).version == 1


@pytest.mark.parametrize("last", ["-1", "v1", "1.0", "9" * 19, "²"])
def test_a_last_event_id_that_is_none_is_422(world: World, last: str) -> None:
    headers = httpx2.Headers([(b"Last-Event-ID", last.encode("latin-1"))])
    answer = world.here.get(f"/v1/sessions/{world.session()}/events", headers=headers)
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"


def test_versions_missed_while_away_come_all(world: World) -> None:
    session = world.session(moved=130)  # more than are read at a time
    with following(world.there, session, "0") as events:
        assert [next(events).version for _ in range(130)] == list(range(1, 131))


def test_a_deleted_session_says_so_and_the_stream_ends(world: World) -> None:
    session = world.session()
    with following(world.here, session) as mine, following(world.there, session) as theirs:
        assert [next(mine).version, next(theirs).version] == [0, 0]
        assert world.here.delete(f"/v1/sessions/{session}").status_code == 204
        for events in (mine, theirs):
            assert [event.event for event in events] == ["deleted"]


def test_there_are_no_events_of_a_session_that_is_not_there(world: World) -> None:
    answer = world.here.get("/v1/sessions/nothing/events")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"


def test_followers_that_leave_do_not_stay_behind(world: World) -> None:
    session = world.session()
    for _ in range(30):
        with following(world.here, session) as events:
            assert next(events).version == 0
    with following(world.here, session) as events:
        assert next(events).version == 0
        move(world.here, session)
        assert next(events).version == 1


def test_a_stream_and_its_process_end_soon_after_sigterm(world: World) -> None:
    session = world.session()
    with following(world.there, session) as one, following(world.there, session) as other:
        assert [next(one).version, next(other).version] == [0, 0]
        began = time.monotonic()
        world.pair[1].signal(signal.SIGTERM)
        assert (list(one), list(other)) == ([], [])
        assert time.monotonic() - began < END_SECONDS
        world.pair[1].wait()
        assert time.monotonic() - began < 2 * END_SECONDS
    world.pair[1].start()
    with following(world.there, session, "0") as events:
        move(world.here, session)
        assert next(events).version == 1
