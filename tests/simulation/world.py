"""The simulated laboratory: replicas on one database, a network that loses and repeats, clients, and what they saw."""

import math
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from tests.simulation.database import Disk
from tests.simulation.plan import REPLICAS, SLOTS, Plan, Weather
from tests.simulation.replica import Replica
from tests.simulation.requests import Reply, Request, outcome_of, reply_of
from tests.simulation.scheduler import Scheduler, Signal, Task
from tests.support.histories import Call
from voa_service.guard import EXPECTED_ERRORS
from voa_service.mapping.models import Model
from voa_store.records import SessionState

PATIENCE_SECONDS = 2.0
"""Time that a client waits for a response before it sends its request again."""
MEMORY = Path("/dev/shm")  # noqa: S108 - a folder in memory, in which a folder of our own is made
_LATENCY_SECONDS = 0.02
_SLOW_SECONDS = 6.0


@dataclass(frozen=True)
class Publication:
    """A commit that a process has announced: the session's state, None where it was deleted."""

    replica: str
    session: str
    state: SessionState | None
    at: float


@dataclass(frozen=True)
class Seen:
    """An answered call about announced looks, or a read of a session, with all that was answered."""

    request: Request
    reply: Reply
    started: float
    ended: float


@dataclass(frozen=True)
class Settled:
    """Session that the robot belongs to, as a process found it or decided it, and when."""

    session: str | None
    started: float
    ended: float


@dataclass(frozen=True)
class Applied:
    """Result of a look of the mapped robot: "accepted", "kept", "taken", or the kind of a failure."""

    number: int
    session: str
    result: str


@dataclass(frozen=True)
class PublishedLook:
    """A look of the mapped robot: its number, the body of its request, and when it was published."""

    number: int
    body: str
    at: float


@dataclass
class Records:
    """All that the clients and processes of a run have seen."""

    calls: list[Call] = field(default_factory=list)
    seen: list[Seen] = field(default_factory=list)
    publications: list[Publication] = field(default_factory=list)
    settled: list[Settled] = field(default_factory=list)
    claims: list[Settled] = field(default_factory=list)
    """Explicit claims of the robot."""
    applied: list[Applied] = field(default_factory=list)
    looks: list[PublishedLook] = field(default_factory=list)
    creations: list[Request] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    """Refusals that no client has deserved."""
    writes: int = 0
    """Writes that processes have worked on, repetitions included."""


class World:
    """All parts of one run.

    Args:
        plan: of the run.
        scheduler: of its tasks.
        folder: with the database, which exists already.
        model: of the scenario, by its id.
    """

    def __init__(self, plan: Plan, scheduler: Scheduler, folder: Path, model: dict[str, Model]) -> None:
        self.plan = plan
        self.scheduler = scheduler
        self.records = Records()
        self.scenario = next(iter(model))
        self.disk = Disk(scheduler, 0.0)
        self.url = f"sqlite:///{folder / 'voa.db'}"
        self.replicas = [Replica("abcdef"[index], scheduler, self.url, model, self) for index in range(REPLICAS)]
        self.sessions: list[str] = [""] * SLOTS
        self.known: dict[tuple[int, str], int] = {}
        """Newest version that each client knows of a session."""
        self.weather = Weather()
        self.busy = 0
        """Clients that are not done yet."""

    def send(self, request: Request, replica: Replica, name: str) -> Reply | None:
        """Send a request, and wait for the response; None: none came in time. Called by a task of a client."""
        scheduler, task = self.scheduler, self._client()
        started, replies, signal = scheduler.now, list[Reply](), Signal()

        def answer(reply: Reply) -> None:
            replies.append(reply)
            scheduler.notify(signal)

        repeated = (
            task.random.random() < self.weather.repeated and request.key is not None
        )  # as a client would, or a proxy
        for copy in range(1 + repeated):
            if task.random.random() >= self.weather.lost:
                work = self._work(request, replica, f"{name}.{copy}", answer)
                scheduler.at(self._delay(task), work)
        scheduler.note(f"sends {request.kind} to {replica.name}")
        end = started + PATIENCE_SECONDS
        while not replies and scheduler.now < end:
            scheduler.wait(signal, end - scheduler.now)
        reply = replies[0] if replies else None
        self._record(request, reply, started)
        return reply

    def claim(self, replica: Replica, name: str, session: str, robot: str) -> None:
        """Have a process claim a robot for a session, without a response."""
        sent = self.scheduler.now

        def arrive() -> None:
            inside = replica.inside

            def work() -> None:
                if inside is None:
                    return
                try:
                    with suppress(*EXPECTED_ERRORS):
                        inside.claims.claim(robot, session)
                finally:
                    self.records.claims.append(Settled(session, sent, self.scheduler.now))

            self.scheduler.spawn(f"{replica.name}.{replica.life}/{name}", work, replica)

        self.scheduler.at(self._delay(self._client()), arrive)

    def published(self, replica: str, session: str, state: SessionState | None) -> None:
        """Record that a process announced a commit."""
        self.scheduler.step("announces a commit")
        self.records.publications.append(Publication(replica, session, state, self.scheduler.now))

    def settled(self, session: str | None, began: float) -> None:
        """Record the session that a look of the robot belongs to."""
        self.records.settled.append(Settled(session, began, self.scheduler.now))
        self.scheduler.note(f"its robot belongs to {session}")

    def applied(self, number: int, session: str, result: str) -> None:
        """Record the result of a look of the robot in a process."""
        self.records.writes += 1
        self.records.applied.append(Applied(number, session, result))
        self.scheduler.note(f"look {number}: {result}")

    def _work(
        self, request: Request, replica: Replica, name: str, answer: Callable[[Reply], None]
    ) -> Callable[[], None]:
        """Make what happens when a request arrives: nothing, where the process is dead by then."""

        def work() -> None:
            task, inside = self._client(), replica.inside
            if inside is None:
                return
            self.records.writes += request.kind != "read"
            reply = reply_of(request, inside, lambda: replica.now().timestamp())
            self.scheduler.step(f"answers {request.kind}")
            if task.random.random() >= self.weather.lost:
                self.scheduler.at(self._delay(task), lambda: answer(reply))

        def arrive() -> None:
            if replica.inside is not None:
                self.scheduler.spawn(f"{replica.name}.{replica.life}/{name}", work, replica)

        return arrive

    def _delay(self, task: Task) -> float:
        slow = task.random.random() < self.weather.slow
        return task.random.random() * (_SLOW_SECONDS if slow else _LATENCY_SECONDS)

    def _record(self, request: Request, reply: Reply | None, started: float) -> None:
        outcome, version = ("unknown", None) if reply is None else outcome_of(request, reply)
        ended = self.scheduler.now if reply is not None else math.inf
        facts = {} if reply is None else reply.facts
        session = str(facts.get("id", "")) if request.kind == "create" else request.session
        if reply is not None:
            self.records.seen.append(Seen(request, reply, started, ended))
            self.scheduler.note(f"got {outcome} {version}")
        if not session:
            return
        belief = facts.get("belief")
        self.records.calls.append(
            Call(
                request.kind,
                session,
                started,
                ended,
                outcome,
                version,
                request.key,
                request.body,
                None if reply is None or reply.response is None else reply.response.body,
                None if belief is None else tuple(belief),
            )
        )

    def _client(self) -> Task:
        task = self.scheduler.current
        if task is None:
            raise RuntimeError("only a task can send requests")
        return task


def folder_in_memory() -> "tempfile.TemporaryDirectory[str]":
    """Make a temporary folder, in memory where there is such a file system."""
    with suppress(OSError):
        return tempfile.TemporaryDirectory(prefix="voa-simulation-", dir=MEMORY)
    return tempfile.TemporaryDirectory(prefix="voa-simulation-")
