"""Robots that put raw scans on Zenoh at 5 Hz, each under an id of its own.

    python -m tests.load.bus_robots URL BODIES --zenoh tcp/127.0.0.1:7447 --sessions 10 20 --seconds 8

prints one line of JSON for each number of sessions, up to the first that the service does not carry. Zenoh does not
answer a put: the time of a scan ends with the belief that the service publishes after its commit, or with a refusal.
"""

import heapq
import json
import random
import threading
import time
import uuid
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import httpx2
import zenoh
from zenoh import CongestionControl, Encoding
from zenoh.handlers import Callback

from tests.load import rounds
from tests.load.rounds import Given, Tally
from tests.load.steps import HZ
from voa_msgs.keys import Keys
from voa_msgs.links import session_config


@dataclass(order=True)
class _Robot:
    """Robot, ordered by the time of its next scan."""

    due: float
    session: str = field(compare=False, default="")
    bodies: Iterator[str] = field(compare=False, default_factory=lambda: iter(()))


class BusRobots:
    """All robots of a run, as one publisher in a thread of its own."""

    def __init__(self, given: Given) -> None:
        assert given.zenoh is not None
        self.tally = Tally()
        self._work, self._keys = given.work, Keys()
        self._random = random.Random(5)  # noqa: S311 - not a secret
        self._http = httpx2.Client(base_url=given.url, timeout=60.0)
        self._robots: list[_Robot] = []
        self._sent: dict[str, deque[float]] = defaultdict(deque)
        self._lock = threading.Lock()
        self._ended = threading.Event()
        config = zenoh.Config()
        for path, value in session_config([given.zenoh], open_ms=5_000).items():
            config.insert_json5(path, json.dumps(value))
        self._bus = zenoh.open(config)
        self._subscribers = [
            self._bus.declare_subscriber(self._keys.belief("*"), Callback(self._applied, indirect=False)),
            self._bus.declare_subscriber(self._keys.refused("*", "*"), Callback(self._refused, indirect=False)),
        ]
        self._thread = threading.Thread(target=self._drive, daemon=True)
        self._thread.start()

    def grow(self, sessions: int) -> None:
        """Let so many robots put scans, at moments of their own."""
        with self._lock:
            for _ in range(sessions - len(self._robots)):
                heapq.heappush(self._robots, _Robot(time.monotonic() + self._random.random() / HZ))

    def end(self) -> None:
        """Stop all robots."""
        self._ended.set()
        self._thread.join()
        self._bus.close()  # type: ignore[no-untyped-call] # zenoh has no types here
        self._http.close()

    def _drive(self) -> None:
        while not self._ended.is_set():
            with self._lock:
                robot = self._robots[0] if self._robots else None
            if robot is None or robot.due > time.monotonic():
                self._ended.wait(0.001)
                continue
            self._put(robot)
            robot.due += 1.0 / HZ
            with self._lock:
                heapq.heapreplace(self._robots, robot)

    def _put(self, robot: _Robot) -> None:
        """Put a robot's next scan; opens a session first where it has none left."""
        body = next(robot.bodies, None)
        if body is None:
            opened = self._http.post("/v1/sessions", json={"scenario": self._work["scenario"]}).raise_for_status()
            robot.session = opened.json()["id"]
            robot.bodies = iter(self._random.choice(self._work["tours"]))
            body = next(robot.bodies)
        self._sent[robot.session].append(time.perf_counter())
        self._bus.put(
            self._keys.scan(robot.session, "load"),
            body,
            encoding=Encoding.APPLICATION_JSON,
            attachment=json.dumps({"id": uuid.uuid4().hex}),
            congestion_control=CongestionControl.BLOCK,
        )

    def _applied(self, sample: zenoh.Sample) -> None:
        """Count the oldest scan of a session as applied; called in a Zenoh thread, as `_refused` is."""
        took = self._took(self._keys.last(str(sample.key_expr)))
        if took is not None:
            self.tally.times_ms.append(1e3 * took)

    def _refused(self, sample: zenoh.Sample) -> None:
        session = str(sample.key_expr).split("/")[-2]
        problem: dict[str, Any] = json.loads(sample.payload.to_bytes())
        if self._took(session) is not None:
            self.tally.refused[str(problem.get("status"))] += 1
            self.tally.causes.setdefault(problem["type"].rpartition(":")[2], problem["detail"])

    def _took(self, session: str) -> float | None:
        """Return the seconds since the oldest scan of a session was put; None for the sample of a new session."""
        waiting = self._sent[session]
        return time.perf_counter() - waiting.popleft() if waiting else None


if __name__ == "__main__":
    rounds.main(BusRobots, __doc__)
