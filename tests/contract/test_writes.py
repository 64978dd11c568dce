"""The conventions of deploy/docs/contract.md as a table: every write x what may happen to it, and the promised answer.

| write | same key, same body | same key, other body | concurrent twice | stale If-Match | after a crash |
|---|---|---|---|---|---|
| create session | first answer | 422 | one session, one answer | (no If-Match) | first answer |
| scan, outcome, belief | first answer | 422 | one version, one answer | 412 | first answer |
| announced look | first answer | 422 | one look, one answer | (no If-Match) | first answer |
| delete | 204 | 422 | 204 and 204 | 412 | 204 |
"""

import json
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import NamedTuple

import httpx2
import pytest

from tests.support.replicas import Replica, replicas
from tests.support.serving import Json, data_scenario, scan_of

AT_ONCE = 4
TIMEOUT = 120.0


@dataclass(frozen=True)
class Call:
    """Write to a session; braces in it stand for the session, brackets for the scenario."""

    method: str
    path: str
    body: Json | None
    status: int
    moves: int = 1
    """Number of versions that the write makes."""

    def to(self, world: "World", session: str, key: str | None = None, if_match: str | None = None) -> httpx2.Response:
        headers = {"Content-Type": "application/json"}
        headers |= {"Idempotency-Key": key} if key else {}
        headers |= {"If-Match": if_match} if if_match else {}
        content = None if self.body is None else json.dumps(self.body).replace("[scenario]", world.scenario)
        return world.http.request(self.method, self.path.format(session), content=content, headers=headers)


class Write(NamedTuple):
    """A write, and another one of the same kind."""

    call: Call
    other: Call


def pair(call: Call, body: Json) -> Write:
    return Write(call, replace(call, body=body))


SCAN = Call("POST", "/v1/sessions/{}/scans", scan_of([0.5, 0.5, None, 1.0]), 200)
UNEXPLAINED = replace(SCAN, body=scan_of([None] * 4), moves=0)
OUTCOME = Call("POST", "/v1/sessions/{}/grasp-outcomes", {"grasp": "G1", "success": False}, 200)
BELIEF = Call("PUT", "/v1/sessions/{}/belief", {"belief": [0.5, 0.25, 0.25]}, 200)
CREATE = Call("POST", "/v1/sessions", {"scenario": "[scenario]"}, 201, moves=0)
DELETE = Call("DELETE", "/v1/sessions/{}", None, 204, moves=0)

MOVES = {
    "scan": pair(SCAN, scan_of([0.6, 0.5, None, 1.0])),
    "scan that is not accepted": pair(UNEXPLAINED, scan_of([0.5, 0.5, None, 1.0])),
    "outcome": pair(OUTCOME, {"grasp": "G1", "success": True}),
    "belief": pair(BELIEF, {"belief": None}),
}
CREATES = {"create session": pair(CREATE, {"scenario": "[scenario]", "prior": [1.0, 0.0, 0.0]})}
DELETES = {"delete": Write(DELETE, SCAN)}  # it has no body: the other use of its key is another call
ANNOUNCEMENTS = {
    "announced look": pair(Call("POST", "/v1/sessions/{}/looks", {"sensor": "Q1"}, 201, moves=0), {"sensor": "Q2"})
}
WRITES = CREATES | MOVES | ANNOUNCEMENTS | DELETES

every_write = pytest.mark.parametrize("write", WRITES.values(), ids=list(WRITES))


class World:
    """A process, and what its calls need."""

    def __init__(self, replica: Replica, http: httpx2.Client) -> None:
        self.replica = replica
        self.http = http
        self.scenario = str(http.post("/v1/scenarios", json=data_scenario()).json()["id"])
        self._keys = count()

    def session(self, moved: int = 0) -> str:
        """A new session at version `moved`."""
        id_ = str(self.http.post("/v1/sessions", json={"scenario": self.scenario}).json()["id"])
        for _ in range(moved):
            assert BELIEF.to(self, id_).is_success
        return id_

    def key(self) -> str:
        return f"key {next(self._keys)}"

    def state(self, session: str) -> Json | None:
        """All that can be read of a session, and how many there are."""
        answer = self.http.get(f"/v1/sessions/{session}")
        if answer.status_code == 404:
            return None
        history = self.http.get(f"/v1/sessions/{session}/history").json()
        sessions = self.http.get("/v1/sessions?limit=1000").json()["items"]
        return {"session": answer.json(), "history": history, "sessions": len(sessions)}


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    folder: Path = tmp_path_factory.mktemp("writes")
    with (
        replicas(f"sqlite:///{folder / 'voa.db'}", folder) as (replica,),
        httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http,
    ):
        yield World(replica, http)


def assert_same(first: httpx2.Response, again: httpx2.Response) -> None:
    assert (again.status_code, again.content) == (first.status_code, first.content)
    assert again.headers.get("ETag") == first.headers.get("ETag")


def assert_problem(answer: httpx2.Response, status: int, kind: str) -> None:
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["type"] == f"urn:voa:problem:{kind}"


def assert_moved(world: World, session: str, by: int) -> None:
    state = world.state(session)
    if state is not None:
        assert state["session"]["version"] == by
        assert [entry["version"] for entry in state["history"]["items"]] == list(range(by + 1))


@every_write
def test_same_key_and_body_gets_the_first_answer_and_changes_nothing(world: World, write: Write) -> None:
    session, key = world.session(), world.key()
    first = write.call.to(world, session, key)
    assert first.status_code == write.call.status, first.text
    assert_moved(world, session, write.call.moves)
    before = world.state(session)
    assert_same(first, write.call.to(world, session, key))
    assert world.state(session) == before


@every_write
def test_same_key_and_other_body_is_422_and_changes_nothing(world: World, write: Write) -> None:
    session, key = world.session(), world.key()
    write.call.to(world, session, key)
    before = world.state(session)
    assert_problem(write.other.to(world, session, key), 422, "idempotency-key-reused")
    assert world.state(session) == before
    if before is not None:
        assert write.other.to(world, session, world.key()).is_success, "it was the key, not the body"


@every_write
def test_concurrent_twice_has_one_effect_and_the_same_answer(world: World, write: Write) -> None:
    session, key = world.session(), world.key()
    sessions = len(world.http.get("/v1/sessions?limit=1000").json()["items"])
    barrier = threading.Barrier(AT_ONCE)

    def send(_: int) -> httpx2.Response:
        barrier.wait(TIMEOUT)
        return write.call.to(world, session, key)

    with ThreadPoolExecutor(AT_ONCE) as pool:
        first, *more = pool.map(send, range(AT_ONCE))
    assert first.status_code == write.call.status
    for again in more:
        assert_same(first, again)
    assert_moved(world, session, write.call.moves)
    opened = {"create session": 1, "delete": -1}
    (name,) = [name for name, each in WRITES.items() if each is write]
    listed = len(world.http.get("/v1/sessions?limit=1000").json()["items"])
    assert listed == sessions + opened.get(name, 0)


@pytest.mark.parametrize("write", (MOVES | DELETES).values(), ids=list(MOVES | DELETES))
def test_stale_if_match_is_412_and_changes_nothing_and_its_key_stays_free(world: World, write: Write) -> None:
    session, key = world.session(moved=2), world.key()
    before = world.state(session)
    for tag in ('"v1"', '"v3"', '"v0", "v1"', '"other"', 'W/"v2"'):
        answer = write.call.to(world, session, key, tag)
        assert_problem(answer, 412, "stale-version")
        assert answer.json()["version"] == 2
    assert world.state(session) == before
    first = write.call.to(world, session, key, '"v2"')
    assert first.status_code == write.call.status, first.text
    assert_same(first, write.call.to(world, session, key, '"v2"'))  # the key comes before If-Match, now stale
    assert_same(first, write.call.to(world, session, key, '"v0"'))


def test_if_match_means_nothing_to_a_creation(world: World) -> None:
    assert CREATE.to(world, "", world.key(), '"v7"').status_code == 201


@pytest.mark.parametrize("tag", ["*", '"v2"', '"v1", "v2"', "v2"])
def test_if_match_lets_through_what_names_the_version(world: World, tag: str) -> None:
    assert SCAN.to(world, world.session(moved=2), None, tag).status_code == 200


@pytest.mark.parametrize("write", (MOVES | ANNOUNCEMENTS).values(), ids=list(MOVES | ANNOUNCEMENTS))
def test_a_write_sent_again_after_its_session_was_deleted_finds_no_session(world: World, write: Write) -> None:
    session, key = world.session(), world.key()
    write.call.to(world, session, key)
    DELETE.to(world, session)
    assert_problem(write.call.to(world, session, key), 404, "not-found")
    assert_problem(write.other.to(world, session, key), 404, "not-found")
    assert_problem(write.call.to(world, session, world.key()), 404, "not-found")
    assert_problem(write.call.to(world, session), 404, "not-found")


def test_a_delete_without_a_key_is_404_the_second_time(world: World) -> None:
    session = world.session()
    assert DELETE.to(world, session).status_code == 204
    assert_problem(DELETE.to(world, session), 404, "not-found")


def test_after_a_crash_every_write_gets_its_first_answer_and_changes_nothing(world: World) -> None:
    sent = {name: (write.call, world.session(), world.key()) for name, write in WRITES.items()}
    first = {name: call.to(world, session, key) for name, (call, session, key) in sent.items()}
    before = {name: world.state(session) for name, (_, session, _) in sent.items()}
    world.replica.kill()
    world.replica.start()
    for name, (call, session, key) in sent.items():
        assert world.state(session) == before[name], name
        assert_same(first[name], call.to(world, session, key))
        assert_problem(WRITES[name].other.to(world, session, key), 422, "idempotency-key-reused")
        assert world.state(session) == before[name], name
