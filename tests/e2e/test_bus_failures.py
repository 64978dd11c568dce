"""Routers, services and robots that fail and restart: every scan with a response is stored exactly once."""

import json
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import httpx2
from zenoh import ConsolidationMode, Encoding, QueryTarget

from tests.support.bus import Stranger, stranger
from tests.support.postgres import Server
from tests.support.proxy import wire
from tests.support.replicas import Replica, replicas
from tests.support.routers import REPOSITORY, router
from tests.support.scale import scaled
from tests.support.serving import Json, data_scenario, scan_of
from tests.support.waiting import wait_for
from voa_client import Client
from voa_msgs.sessions import ScanRequest

ROBOTS = 20
CUT_OFF_SECONDS = scaled(3.0, 15.0)
PUTS = scaled(200, 1000)
ACKNOWLEDGED = scaled(30, 200)
END_SECONDS = scaled(10.0, 2.0)
"""Longest time of a process to end after SIGTERM; CI machines are slow."""
SECONDS = 120.0
GOOD = [0.5, 0.5, None, 1.0]


def post(url: str, body: Json) -> Json:
    answer = httpx2.post(url, json=body, timeout=SECONDS)
    assert answer.is_success, answer.text
    return dict(answer.json())


def opened(service: Replica, count: int) -> list[str]:
    """Open `count` sessions on one scenario."""
    scenario = post(f"{service.url}/v1/scenarios", data_scenario())["id"]
    return [str(post(f"{service.url}/v1/sessions", {"scenario": scenario})["id"]) for _ in range(count)]


def stamps(service: Replica, session: str) -> Counter[str]:
    """Count each stamp in the history of a session."""
    with Client(service.url) as client:
        scans = [ScanRequest.model_validate(e.request) for e in client.history(session) if e.kind == "scan"]
    return Counter(json.dumps(request.scan.stamp) for request in scans)


class Robots:
    """Process that runs all robots."""

    def __init__(self, file: Path, robots: list[tuple[str, str]]) -> None:
        self._file = file
        command = [sys.executable, "-m", "tests.support.scripted_robots", str(file)]
        self.process = subprocess.Popen([*command, *(f"{url}={session}" for url, session in robots)], cwd=REPOSITORY)

    def answered(self) -> Counter[str]:
        """Count the scans of each robot that got a response."""
        if not self._file.exists():
            return Counter()
        return Counter(line.split()[0] for line in self._file.read_text().splitlines())

    def each_gets(self, more: int, what: str, but: frozenset[str] = frozenset()) -> None:
        """Wait until `more` further scans of each robot got a response."""
        before = self.answered()
        names = [f"robot-{index}" for index in range(ROBOTS)]

        def enough() -> bool:
            now = self.answered()
            return all(now[name] >= before[name] + more for name in names if name not in but)

        wait_for(enough, what, SECONDS)


@contextmanager
def running(file: Path, robots: list[tuple[str, str]]) -> Iterator[Robots]:
    own = Robots(file, robots)
    try:
        yield own
    finally:
        own.process.kill()
        own.process.wait()


def ends(send: Callable[[], None], wait: Callable[[], int]) -> float:
    """Send the signal to end, and return the seconds until the process ended with exit code 0."""
    began = time.monotonic()
    send()
    assert wait() == 0
    return time.monotonic() - began


def test_twenty_robots_lose_nothing_that_was_answered(tmp_path: Path) -> None:
    with ExitStack() as stack:
        bus = stack.enter_context(router())
        cable = stack.enter_context(wire(bus.port))
        url = f"sqlite:///{tmp_path / 'voa.db'}"
        (service,) = stack.enter_context(replicas(url, tmp_path, 1, "--zenoh", bus.endpoint))
        sessions = opened(service, 4)
        direct, cuttable = f"zenoh://127.0.0.1:{bus.port}", f"zenoh://127.0.0.1:{cable.port}"
        robots = [(cuttable if index == 0 else direct, sessions[index % 4]) for index in range(ROBOTS)]
        fleet = stack.enter_context(running(tmp_path / "answered", robots))
        fleet.each_gets(3, "every robot's first answers")

        bus.kill()
        wait_for(lambda: service.zenoh == "connecting", "the service to notice that the router is gone")
        bus.start()
        fleet.each_gets(3, "answers after the router's restart")

        service.kill()
        service.start()
        fleet.each_gets(3, "answers after the service's restart")

        cable.cut()
        others = frozenset({"robot-0"})
        end = time.monotonic() + CUT_OFF_SECONDS
        while time.monotonic() < end:
            fleet.each_gets(2, "answers of everybody else", but=others)
        cable.mend()
        fleet.each_gets(3, "answers after one robot was cut off")

        took = ends(lambda: fleet.process.send_signal(signal.SIGTERM), lambda: fleet.process.wait(SECONDS))
        counts = {session: stamps(service, session) for session in sessions}
        took_service = ends(lambda: service.signal(signal.SIGTERM), service.wait)
        answered = (tmp_path / "answered").read_text().splitlines()
        print(f"{len(answered)} scans answered; robots ended in {took:.2f} s, the service in {took_service:.2f} s")
        for line in answered:
            name, number = line.split()
            session = robots[int(name.removeprefix("robot-"))][1]
            assert counts[session][json.dumps([name, int(number)])] == 1, line
        assert {count for session in sessions for count in counts[session].values()} == {1}
        assert max(took, took_service) < END_SECONDS


def count_replies(bus: Stranger, session: str) -> int:
    """Count the replies to a query of which all replicas could answer."""
    replies = bus.session.get(
        bus.keys.rpc("session.get"),
        payload=json.dumps({"session": session}),
        encoding=Encoding.APPLICATION_JSON,
        target=QueryTarget.BEST_MATCHING,
        consolidation=ConsolidationMode.NONE,
        timeout=20.0,
    )
    return len(list(replies))


def test_two_replicas_take_every_scan_once_also_when_one_is_killed(postgres: Server, tmp_path: Path) -> None:
    with ExitStack() as stack:
        bus = stack.enter_context(router())
        both = stack.enter_context(replicas(postgres.new_database(), tmp_path, 2, "--zenoh", bus.endpoint))
        for service in both:
            wait_for(lambda own=service: own.zenoh == "connected", "a replica on the bus")  # type: ignore[misc] # bound in each round, which mypy cannot infer
        robot = stack.enter_context(stranger(bus.endpoint))
        wait_for(lambda: len(list(robot.session.liveliness().get(robot.keys.replica("*")))) == 2, "both tokens")
        sessions = opened(both[0], 4)
        published_samples = robot.subscribe(robot.keys.belief("*"))
        assert [count_replies(robot, sessions[0]) for _ in range(20)] == [1] * 20

        answered: list[int] = []

        def apply_scans() -> None:
            with Client(f"zenoh://127.0.0.1:{bus.port}") as client:
                for number in range(ACKNOWLEDGED):
                    request: Any = scan_of(GOOD, stamp=["call", number])
                    client.apply_scan(sessions[0], ScanRequest.model_validate(request))
                    answered.append(number)

        sender = threading.Thread(target=apply_scans, daemon=True)
        sender.start()
        for number in range(PUTS):
            if number == PUTS // 2:
                wait_for(lambda: len(answered) > 3, "some answers before one is killed", SECONDS)
                both[0].kill()
            robot.put_scan(sessions[number % 4], scan_of(GOOD, stamp=["put", number]))
        left = both[1]

        def applied() -> Counter[str]:
            return sum((stamps(left, session) for session in sessions), Counter())

        wait_for(lambda: len(applied()) >= PUTS + ACKNOWLEDGED, "every scan", SECONDS)
        sender.join(SECONDS)
        assert len(answered) == ACKNOWLEDGED
        counts = applied()
        assert set(counts.values()) == {1}
        assert {stamp for stamp in counts if "put" in stamp} == {json.dumps(["put", n]) for n in range(PUTS)}
        assert {stamp for stamp in counts if "call" in stamp} == {json.dumps(["call", n]) for n in range(ACKNOWLEDGED)}
        published = Counter((sample.key, sample.attachment) for sample in published_samples)
        assert set(published.values()) == {1}, "a version was published twice"
        assert count_replies(robot, sessions[0]) == 1
