"""A service of scripted responses, and the two roles of robots that call it, sync and async."""

import json
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from typing import Any

from tests.voa_client.blocking import blocking, is_blocking, role_of
from tests.voa_client.test_attempts import SESSION, problem
from voa_client import Client, Retries
from voa_client._call import Call
from voa_client._responses import Response
from voa_client._transport import Receive, State
from voa_msgs.rankings import GraspNow, Look, RankedSensor, Ranking
from voa_msgs.sessions import Scan

COLOURS = ("sync", "async")
SCAN = Scan(ranges=[0.5, None])
ANNOUNCED = {"id": "look-1", "sensor": "Q1", "sensor_pose": None, "robot": None, "expires_at": "2026-01-01T00:02:00Z"}
Json = dict[str, Any]


def session(version: int = 0, **more: Any) -> Response:
    """A session; with an `update`, the response to a scan."""
    fields = json.loads(SESSION.body) | {"version": version}
    return Response(json.dumps(fields | more).encode())


def updated(version: int = 1, *, accepted: bool = True, **more: Any) -> Response:
    """A response to a scan or an outcome."""
    update = {
        "accepted": accepted,
        "reason": None if accepted else "no_beams",
        "log_evidence": None,
        "fit_rmsd_mm": None,
        "fit_hit_rmsd_mm": None,
        "best_fit_pose": None,
        "beams_compared": 2,
    }
    return session(version, update=update, **more)


def ranked(look: str | None, *, then: str | None = None, **net_values: float) -> Response:
    """A ranking with a recommended look (None: to grasp) and the net values of places."""
    looks = [
        RankedSensor(
            sensor=name,
            voa=value,
            standard_error=None,
            cost=0.0,
            net_value=value,
            expected_score_after=0.5,
            ties_with_first=False,
        )
        for name, value in net_values.items()
    ]
    advice: Look | GraspNow = GraspNow(action="grasp", grasp="G1", expected_score=0.9)
    if look is not None:
        advice = Look(action="look", sensor=look, net_value=0.1, then=then)
    ranking = Ranking(
        version=0,
        definition="posterior",
        method="exact",
        precision="float64",
        expected_score_before=0.5,
        best_grasp_before="G1",
        ranking=looks,
        recommendation=advice,
    )
    return Response(ranking.model_dump_json().encode())


GRASP = ranked(None)
NOT_THERE = problem("not-found", 404)


@dataclass
class Replies:
    """A transport that answers each kind of call from a list; the last reply of a list is repeated.

    Attributes:
        by_rpc: replies by the name of the call.
        events: bodies of sessions that each watch receives at once.
        sent: names and payloads of the calls, in order.
    """

    by_rpc: dict[str, list[Response | BaseException]]
    events: tuple[bytes, ...] = ()
    sent: list[tuple[str, Json]] = field(default_factory=list)
    poll_s = None

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        self.sent.append((call.rpc, json.loads(call.payload())))
        replies = self.by_rpc[call.rpc]
        reply = replies.pop(0) if len(replies) > 1 else replies[0]
        if isinstance(reply, BaseException):
            raise reply
        return reply

    @contextmanager
    def watch(self, session_id: str, seen: int | None, receive: Receive) -> Iterator[None]:
        for body in self.events:
            receive(State(body))
        yield

    def close(self) -> None:
        return

    def payloads(self, rpc: str) -> list[Json]:
        """Payloads of the calls of one kind."""
        return [payload for name, payload in self.sent if name == rpc]

    def rpcs(self) -> list[str]:
        """Names of the calls."""
        return [name for name, _ in self.sent]


@dataclass
class AsyncReplies:
    """`Replies` for an asynchronous client."""

    inside: Replies
    poll_s = None

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        return self.inside.send(call, key, seconds)

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, receive: Receive) -> AsyncIterator[None]:
        with self.inside.watch(session_id, seen, receive):
            yield

    async def close(self) -> None:
        return


@contextmanager
def calling(replies: Replies, colour: str) -> Iterator[Client]:
    """A client of scripted replies, which makes each call once."""
    once = Retries(within_s=0.0)
    if colour == "sync":
        with Client(replies, retries=once) as client:
            yield client
        return
    with blocking(AsyncReplies(replies), retries=once) as client:
        yield client


def sensor_role(client: Client, **more: Any) -> Any:
    """The robot that carries the lidar, in session "s"."""
    return role_of(client, "sensor", "s", **more)


def arm_role(client: Client) -> Any:
    """The arm, in session "s"."""
    return role_of(client, "arm", "s")


@dataclass
class Robot:
    """A robot that drives and scans, or fails.

    Attributes:
        been: names of the places, in order.
        failure: raised by the drive; None: it arrives.
        blind: raised by the scan; None: the lidar works.
    """

    been: list[str] = field(default_factory=list)
    failure: BaseException | None = None
    blind: BaseException | None = None

    def drive(self, name: str) -> None:
        self.been.append(name)
        if self.failure is not None:
            raise self.failure

    def take_scan(self) -> Scan:
        if self.blind is not None:
            raise self.blind
        return SCAN

    def run(self, client: Client, *args: Any, role: Any = None, **more: Any) -> Any:
        """Run a tour with this robot, by a client of either colour."""
        sensor = sensor_role(client) if role is None else role
        if not is_blocking(client):
            return sensor.run(self.drive, self.take_scan, *args, **more)

        async def drive(name: str) -> None:
            self.drive(name)

        async def take_scan() -> Scan:
            return self.take_scan()

        return sensor.run(drive, take_scan, *args, **more)
