"""Repeated attempts of a call and their time limit: a scripted transport, and a clock that only sleeping moves."""

import asyncio
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest

from voa_client import (
    AsyncClient,
    Client,
    InvalidRequestError,
    NotFoundError,
    OverloadedError,
    ProblemError,
    Retries,
    TimedOutError,
    UnavailableError,
    UnexpectedResponseError,
    UnreachableError,
    UsageError,
    VoaClientError,
    WireVersionError,
)
from voa_client._attempts import Patience
from voa_client._call import Call
from voa_client._responses import Response
from voa_client._transport import Receive
from voa_msgs import WIRE_VERSION
from voa_msgs.sessions import BeliefRequest

READY = Response(b'{"status": "ready"}')
SESSION = Response(
    json.dumps(
        {
            "id": "s",
            "scenario": "c",
            "version": 1,
            "poses": ["P"],
            "belief": [1.0],
            "best_grasp": None,
            "expected_score": 0.0,
            "entropy_nats": 0.0,
            "last_fit_rmsd_mm": None,
            "created_at": "2026-01-01T00:00:00Z",
            "updated_at": "2026-01-01T00:00:00Z",
        }
    ).encode()
)
NOWHERE = UnreachableError("nobody")
BACK = BeliefRequest(belief=None)


def problem(kind: str, status: int, retry_after_s: float | None = None, **more: Any) -> Response:
    document = {"type": f"urn:voa:problem:{kind}", "title": "No", "status": status, "detail": "because"} | more
    return Response(json.dumps(document).encode(), refused=True, retry_after_s=retry_after_s)


@dataclass
class Script:
    """A transport that plays a list of replies and errors, then the last one again and again."""

    replies: Sequence[Response | Exception]
    takes_s: float = 0.0
    time: float = 0.0
    slept: list[float] = field(default_factory=list)
    sent: list[tuple[str, str | None, float]] = field(default_factory=list)
    poll_s = None

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        reply = self.replies[min(len(self.sent), len(self.replies) - 1)]
        self.sent.append((call.rpc, key, seconds))
        self.time += min(self.takes_s, seconds)
        if isinstance(reply, Exception):
            raise reply
        return reply

    @contextmanager
    def watch(self, session_id: str, seen: int | None, receive: Receive) -> Iterator[None]:
        raise AssertionError("not in these tests")

    def close(self) -> None:
        return

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.time += seconds

    def client(self, chance: float = 0.0, **more: Any) -> Client:
        numbers = iter(range(1000))
        return Client(
            self,
            clock=lambda: self.time,
            sleep=self.sleep,
            chance=lambda: chance,
            keys=lambda: f"key {next(numbers)}",
            **more,
        )

    @property
    def keys(self) -> list[str | None]:
        return [key for _, key, _ in self.sent]


@pytest.mark.parametrize(
    "failure",
    [
        NOWHERE,
        TimedOutError("late"),
        problem("overloaded", 503),
        problem("not-ready", 503),
        problem("http-error", 502),
        problem("http-error", 504),
    ],
)
def test_what_may_pass_is_tried_again(failure: Response | Exception) -> None:
    script = Script([failure, failure, READY])
    assert script.client().ready().status == "ready"
    assert script.slept == [0.1, 0.2]


@pytest.mark.parametrize(
    ("failure", "kind"),
    [
        (problem("not-found", 404), NotFoundError),
        (problem("invalid-request", 422), InvalidRequestError),
        (problem("malformed-json", 400), InvalidRequestError),
        (problem("too-large", 413), InvalidRequestError),
        (problem("internal", 500), ProblemError),
        (UsageError("no"), UsageError),
        (Response(b"<h1>Welcome</h1>"), UnexpectedResponseError),
        (Response(b"<h1>No</h1>", refused=True), UnexpectedResponseError),
    ],
)
def test_what_will_not_pass_is_raised_at_once(failure: Response | Exception, kind: type[VoaClientError]) -> None:
    script = Script([failure])
    with pytest.raises(kind):
        script.client().ready()
    assert (len(script.sent), script.slept) == (1, [])


def test_waits_double_up_to_the_longest_and_end_with_the_time_of_the_call() -> None:
    script = Script([NOWHERE])
    with pytest.raises(UnreachableError, match="nobody"):
        script.client(timeout_s=10.0).ready()
    assert script.slept == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.6, 2.0, 2.0, 2.0])
    assert script.time < 10.0


def test_jitter_shortens_a_wait_by_up_to_a_half() -> None:
    script = Script([NOWHERE, NOWHERE, READY])
    script.client(chance=0.999_999).ready()
    assert script.slept == pytest.approx([0.05, 0.1], rel=1e-5)
    assert Retries().wait_s(5_000, 0.0) == 2.0


def test_the_service_says_when_to_come_back() -> None:
    document = json.dumps(json.loads(problem("overloaded", 503).body) | {"retry_after_s": 3.0}).encode()
    script = Script([problem("overloaded", 503, 7.0), Response(document, refused=True), READY])
    script.client().ready()
    assert script.slept == [7.0, 3.0]
    script = Script([problem("overloaded", 503, 7.0)])
    with pytest.raises(OverloadedError) as refused:
        script.client(timeout_s=6.0).ready()
    assert (refused.value.retry_after_s, refused.value.kind, script.slept) == (7.0, "overloaded", [])


def test_no_attempt_begins_after_the_time_of_the_retries() -> None:
    script = Script([NOWHERE])
    with pytest.raises(UnreachableError):
        script.client(retries=Retries(within_s=0.0)).ready()
    assert len(script.sent) == 1
    script = Script([NOWHERE])
    with pytest.raises(UnreachableError):
        script.client(retries=Retries(first_s=1.0, most_s=1.0, within_s=3.0)).ready()
    assert len(script.sent) == 4


def test_an_attempt_has_its_own_limit_and_never_more_than_is_left() -> None:
    script = Script([TimedOutError("late")], takes_s=60.0)
    with pytest.raises(TimedOutError):
        script.client(timeout_s=12.0).ready()
    assert [seconds for *_, seconds in script.sent] == pytest.approx([5.0, 5.0, 1.7])
    assert script.time == pytest.approx(12.0)


def test_a_heavy_call_has_one_long_attempt() -> None:
    script = Script([TimedOutError("late")], takes_s=1_000.0)
    with pytest.raises(TimedOutError):
        script.client(timeout_s=60.0).rank_looks("s")
    assert [seconds for *_, seconds in script.sent] == [60.0]
    assert script.time == 60.0


def test_a_heavy_call_that_finds_nobody_is_tried_again() -> None:
    script = Script([NOWHERE, Response(b'{"items": []}')])
    assert script.client().stable_poses("o").items == []


def test_all_attempts_of_a_write_share_one_key_and_the_next_write_has_another() -> None:
    script = Script([NOWHERE, problem("overloaded", 503), SESSION])
    client = script.client()
    assert client.put_belief("s", BACK).version == 1
    client.put_belief("s", BACK)
    client.put_belief("s", BACK, key="mine")
    client.get_session("s")
    assert script.keys == ["key 0", "key 0", "key 0", "key 1", "mine", None]


def test_keys_differ_between_clients_and_calls() -> None:
    keys = {Patience().keys() for _ in range(100)}
    assert len(keys) == 100
    assert all(len(key) == 32 for key in keys)


def test_health_makes_a_single_attempt() -> None:
    script = Script([problem("not-ready", 503), READY])
    with pytest.raises(UnavailableError):
        script.client().health()
    assert script.slept == []


@pytest.mark.parametrize(
    ("reply", "side"),
    [
        (Response(b"{}", wire=WIRE_VERSION + 1), "update this program"),
        (Response(b"{}", wire=WIRE_VERSION - 1), "update the service"),
        (Response(problem("wire-version", 400).body, refused=True), "because"),
        (Response(problem("wire-version", 400).body, refused=True, wire=WIRE_VERSION + 1), "update this program"),
    ],
)
def test_another_version_of_the_messages_says_which_side_to_update(reply: Response, side: str) -> None:
    with pytest.raises(WireVersionError, match=side):
        Script([reply]).client().ready()


def test_an_answer_without_a_version_is_taken_as_it_is() -> None:
    assert Script([Response(b'{"status": "ready", "mood": "fine"}', wire=None)]).client().ready().status == "ready"


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("inf"), float("nan")])
def test_there_is_always_a_time_out(seconds: float) -> None:
    with pytest.raises(UsageError, match="timeout_s"):
        Script([READY]).client(timeout_s=seconds)


def test_the_asynchronous_client_decides_alike() -> None:
    script = Script([NOWHERE, problem("overloaded", 503, 7.0), SESSION])

    class Scripted:
        poll_s = None
        watch = script.watch

        async def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
            return script.send(call, key, seconds)

        async def close(self) -> None:
            return

    async def sleep(seconds: float) -> None:
        script.sleep(seconds)

    async def main() -> None:
        transport: Any = Scripted()
        async with AsyncClient(
            transport, clock=lambda: script.time, sleep=sleep, chance=lambda: 0.0, keys=lambda: "key"
        ) as client:
            assert (await client.put_belief("s", BACK)).version == 1

    asyncio.run(main())
    assert script.slept == [0.1, 7.0]
    assert script.sent == [("belief.put", "key", 5.0)] * 3
