"""Robots that send scans at 5 Hz, played by Locust.

    python -m tests.load.robots URL BODIES --sessions 10 20 --seconds 8

Each number of sessions is one step; it prints one line of JSON, and the first step that a service does not carry is the
last. A robot opens a session, sends its scans each with an idempotency key of its own, and begins with another. Where
the service refuses a scan, the robot waits as long as `Retry-After` says and sends it again under its key, as the thin
client does.
"""

import argparse
import json
import random
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from locust import FastHttpUser, constant_pacing, task
from locust.contrib.fasthttp import FastResponse
from locust.env import Environment

from tests.load.steps import HZ, Step, step_of
from tests.load.usage import cpu_seconds, machine_seconds

_SCANS = "scans"
_SETTLE = 0.25
"""Share of a step's duration that passes before it is measured."""
_SPAWNED_PER_S = 50.0
_TIMEOUT_S = 30.0
_PROBLEM = "application/problem+json"


class Tally:
    """Responses of one step."""

    def __init__(self) -> None:
        self.times_ms: list[float] = []
        self.refused: Counter[str] = Counter()
        self.impolite = 0
        self.causes: dict[str, str] = {}

    def count(self, response: FastResponse, took_ms: float) -> None:
        """Count the response to a scan."""
        if response.status_code == 200:
            self.times_ms.append(took_ms)
            return
        error = getattr(response, "error", None)
        if response.status_code == 0:  # an idle connection that was closed as the scan was sent, or a time-out
            self.refused["none"] += 1
            self.causes.setdefault(type(error).__name__, str(error))
            return
        self.refused[str(response.status_code)] += 1
        headers: Any = response.headers or {}
        if headers.get("content-type") != _PROBLEM or not headers.get("retry-after"):
            self.impolite += 1
            return
        problem = json.loads(response.text or "")
        self.causes.setdefault(problem["type"].rpartition(":")[2], problem["detail"])


class Robot(FastHttpUser):
    """Robot that sends a scan each 0.2 s, or as soon as the last one was answered."""

    abstract = True
    wait_time = constant_pacing(1.0 / HZ)
    network_timeout = _TIMEOUT_S
    connection_timeout = _TIMEOUT_S
    work: dict[str, Any]
    key: str | None
    tally: Tally
    random = random.Random(5)  # noqa: S311 - not a secret

    def on_start(self) -> None:
        """Begin at a moment of the robot's own."""
        time.sleep(self.random.random() / HZ)
        self._path = ""
        self._bodies: Iterator[str] = iter(())

    @task
    def scan(self) -> None:
        """Send the next scan, until it is answered."""
        body = next(self._bodies, None) or self._first()
        headers = self._headers()
        answered = False
        while not answered:
            began = time.perf_counter()
            with self.client.post(self._path, data=body, headers=headers, name=_SCANS, catch_response=True) as response:
                self.tally.count(response, 1e3 * (time.perf_counter() - began))
                response.success()
                answered = response.status_code == 200
                pause = 0.0 if answered else float((response.headers or {}).get("retry-after", 0.1))
            time.sleep(pause)

    def _first(self) -> str:
        """Open a session, and return its first scan."""
        body = json.dumps({"scenario": self.work["scenario"]})
        session = None
        while session is None:
            opened = self.client.post("/v1/sessions", data=body, headers=self._headers(), name="sessions")
            if opened.status_code == 201:
                session = opened.json()["id"]
            else:
                time.sleep(1.0)
        self._path = f"/v1/sessions/{session}/scans"
        self._bodies = iter(self.random.choice(self.work["tours"]))
        return next(self._bodies)

    def _headers(self) -> dict[str, str]:
        own = {} if self.key is None else {"Authorization": f"Bearer {self.key}"}
        return own | {"Content-Type": "application/json", "Idempotency-Key": uuid.uuid4().hex}


def steps(
    robot: type[Robot], url: str, sessions: list[int], seconds: float, pids: dict[str, list[int]]
) -> Iterator[Step]:
    """Yield the figures of one number of sessions after another, up to the first that the service does not carry."""
    environment = Environment(user_classes=[robot], host=url, reset_stats=False)
    runner = environment.create_local_runner()
    for number in sessions:
        time_to_spawn = (number - runner.user_count) / _SPAWNED_PER_S
        runner.start(number, spawn_rate=_SPAWNED_PER_S)
        time.sleep(time_to_spawn + _SETTLE * seconds)
        tally = robot.tally = Tally()
        before, began = _spent(pids), time.monotonic()
        time.sleep(seconds)
        took = time.monotonic() - began
        spent = {part: seconds - before[part] for part, seconds in _spent(pids).items()}
        robot.tally = Tally()
        step = step_of(number, took, tally.times_ms, tally.refused, tally.impolite, spent, tally.causes)
        yield step
        if step.reason is not None:
            break
    runner.quit()


def _spent(pids: dict[str, list[int]]) -> dict[str, float]:
    """Return the CPU seconds so far by part; "robots" are this process, and "machine" is everything."""
    parts = {part: cpu_seconds(own) for part, own in pids.items()}
    return parts | {"robots": time.process_time(), "machine": machine_seconds()}


def main() -> None:
    """Play the robots."""
    parser = argparse.ArgumentParser(prog="python -m tests.load.robots", description=__doc__)
    parser.add_argument("url")
    parser.add_argument("bodies", type=Path, help="file of tests.load.scans")
    parser.add_argument("--sessions", type=int, nargs="+", required=True)
    parser.add_argument("--seconds", type=float, default=8.0, help="measured in each step")
    parser.add_argument("--pids", type=json.loads, default={}, help='processes by part, {"service": [1]}')
    parser.add_argument("--key", help="of the caller")
    given = parser.parse_args()

    class Own(Robot):
        """Robot of this run."""

        work = json.loads(given.bodies.read_text(encoding="utf-8"))
        key = given.key
        tally = Tally()

    for step in steps(Own, given.url, given.sessions, given.seconds, given.pids):
        print(json.dumps(asdict(step)), flush=True)


if __name__ == "__main__":
    main()
