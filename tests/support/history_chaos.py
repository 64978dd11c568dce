"""Writers on a service of two processes to which everything happens: kills, silence, cut networks, faults of the disk.

Each event happens after a number of responses. At the end the recorded calls are checked against the database.
"""

import random
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import httpx2

from tests.support.history_calls import Recorder, opened
from tests.support.history_store import check_answered, check_stored, stored
from tests.support.postgres import server
from tests.support.proxy import Wire, wire
from tests.support.replicas import Replica
from tests.support.storage_faults import Disk, How, On, faulty_disk

PROCESSES = 2
_STALL_S = 900.0
_SILENCE_S = 1.0
Event = Callable[[], None]


@dataclass(frozen=True)
class Plan:
    """Size of a run.

    Attributes:
        writes: number of writes that must be answered.
        writers: number of writers at a time; there is a reader beside them.
        sessions: number of sessions.
        events: number of events, spread over the writes.
        seed: of the events.
    """

    writes: int
    writers: int = 8
    sessions: int = 50
    events: int = 50
    seed: int = 0


@dataclass
class Endured:
    """Figures of a run.

    Attributes:
        answered: number of writes that were answered.
        failures: number of attempts that failed, by status; None: without a response.
        calls: number of recorded calls, reads included.
        versions: number of versions that they made, each replayed.
        events: number of events by name.
        writing_s: time of the writing, seconds.
        checking_s: time of the checks at the end, seconds.
    """

    answered: int
    failures: Counter[int | None]
    calls: int
    versions: int
    events: Counter[str]
    writing_s: float
    checking_s: float

    def __str__(self) -> str:
        events = ", ".join(f"{count} {name}" for name, count in sorted(self.events.items()))
        failed = ", ".join(f"{count} {status or 'without response'}" for status, count in self.failures.items())
        return (
            f"{self.answered} writes answered, attempts failed: {failed or 'none'}; {self.calls} calls recorded, "
            f"{self.versions} versions replayed; {events}; {self.writing_s:.0f} s + {self.checking_s:.0f} s of checks"
        )


@dataclass
class Lab:
    """Service on a database, behind proxies, and the events that may happen to it."""

    database_url: str
    replicas: list[Replica]
    wires: list[Wire]
    rng: random.Random
    events: dict[str, Event] = field(default_factory=dict)

    @property
    def urls(self) -> list[str]:
        """URLs of the processes, through the proxies."""
        return [f"http://127.0.0.1:{each.port}" for each in self.wires]

    def kill(self) -> None:
        """Kill a process and start it again."""
        victim = self.rng.choice(self.replicas)
        victim.kill()
        victim.start()

    def freeze(self) -> None:
        """Stop a process for a second, whatever it holds, and let it go on."""
        victim = self.rng.choice(self.replicas)
        victim.signal(signal.SIGSTOP)
        threading.Event().wait(_SILENCE_S)
        victim.signal(signal.SIGCONT)

    def drop_clients(self) -> None:
        """Close the connections of all clients of a process, with the responses that are on their way."""
        self.rng.choice(self.wires).drop()


def random_numbers(seed: int) -> random.Random:
    """Make the random numbers of a seed."""
    return random.Random(seed)  # noqa: S311 - not a secret


@contextmanager
def lab(kind: str, folder: Path, seed: int) -> Iterator[Lab]:
    """Run the service on a database of a kind, "sqlite" or "postgresql", with the events that fit it."""
    with ExitStack() as stack:
        opened_lab = _on_sqlite if kind == "sqlite" else _on_postgres
        own = opened_lab(stack, folder, random_numbers(seed))
        own.events |= {"kills": own.kill, "processes frozen": own.freeze, "clients cut": own.drop_clients}
        for replica in own.replicas:
            stack.callback(replica.end)
            replica.launch()
        for replica in own.replicas:
            replica.wait_until_ready()
        yield own


def _wires(stack: ExitStack, replicas: list[Replica]) -> list[Wire]:
    return [stack.enter_context(wire(httpx2.URL(each.url).port or 0)) for each in replicas]


def _on_sqlite(stack: ExitStack, folder: Path, rng: random.Random) -> Lab:
    file = folder / "voa.db"
    url = f"sqlite:///{file}"
    disks = [stack.enter_context(faulty_disk(folder, file, f"disk-{n}")) for n in range(PROCESSES)]
    replicas = [Replica(url, folder / f"{n}.log", environment=disk.environment) for n, disk in enumerate(disks)]
    own = Lab(url, replicas, _wires(stack, replicas), rng)

    def error() -> None:
        """Let some calls of one process fail."""
        disk = rng.choice(disks)
        disk.fail(
            rng.choice(list(On)),
            rng.choice([How.EIO, How.FULL, How.SHORT]),
            skip=rng.randrange(4),
            times=rng.choice([1, 2, 50]),
        )
        threading.Event().wait(_SILENCE_S)
        disk.mend()

    def tear() -> None:
        """Let a process die in the middle of writing a page, and start it again."""
        number = rng.randrange(PROCESSES)
        _torn(disks[number], replicas[number], rng.randrange(20))

    own.events |= {"faults of the disk": error, "torn pages": tear}
    return own


def _torn(disk: Disk, replica: Replica, skip: int) -> None:
    disk.fail(On.WRITE, How.TORN, skip=skip, times=1)
    replica.wait()
    disk.mend()
    replica.start()


def _on_postgres(stack: ExitStack, folder: Path, rng: random.Random) -> Lab:
    own_server = stack.enter_context(server(durable=True))
    direct = httpx2.URL(own_server.new_database())
    between = stack.enter_context(wire(direct.port or 0))
    url = str(direct.copy_with(port=between.port))
    replicas = [Replica(url, folder / f"{n}.log") for n in range(PROCESSES)]
    own = Lab(str(direct), replicas, _wires(stack, replicas), rng)

    def silence() -> None:
        """Forward nothing between service and database for a second."""
        between.cut()
        threading.Event().wait(_SILENCE_S)
        between.mend()

    def crash() -> None:
        """Kill the database's processes and start them again."""
        own_server.end()
        own_server.start()

    own.events |= {"database silent": silence, "database cut": between.drop, "database crashed": crash}
    return own


def endure(kind: str, folder: Path, plan: Plan, report: Callable[[str], None] = lambda _: None) -> Endured:
    """Let writers write until so many writes are answered, with events on the way, and check everything.

    Args:
        kind: of the database, "sqlite" or "postgresql".
        folder: for files and logs.
        plan: size of the run.
        report: called with a line after each event.

    Raises:
        AssertionError: something was lost, happened twice, or contradicts what was answered.
    """
    recorder, events, checked = Recorder(), Counter[str](), 0
    with lab(kind, folder, plan.seed) as own, stored(own.database_url) as store:
        sessions = opened(recorder, own.urls[0], plan.sessions)
        began = time.monotonic()
        with recorder.running(own.urls, sessions, plan.writers):
            names = sorted(own.events)
            for number in range(plan.events):
                recorder.wait_for(plan.writes // plan.events, _STALL_S)
                name = names[number % len(names)]
                answered = recorder.calls[checked:]
                own.events[name]()
                events[name] += 1
                check_answered(store, answered)
                checked += len(answered)
                report(f"{time.monotonic() - began:.0f} s: {recorder.answered} answered, {name}")
            recorder.wait_for(max(1, plan.writes - recorder.answered), _STALL_S)
        written = time.monotonic()
        versions = check_stored(own.database_url, recorder.calls)
    return Endured(
        recorder.answered,
        recorder.failures,
        len(recorder.calls),
        versions,
        events,
        written - began,
        time.monotonic() - written,
    )
