"""Robots that send scans at 5 Hz by HTTP, played by Locust.

    python -m tests.load.robots URL BODIES --sessions 10 20 --seconds 8

prints one line of JSON for each number of sessions, up to the first that the service does not carry. A robot opens a
session, sends its scans each with an idempotency key of its own, and begins with another. Where the service refuses a
scan, the robot waits as long as `Retry-After` says and sends it again under its key, as the thin client does.
"""

import json
import math
import random
import time
import uuid
from collections.abc import Iterator
from typing import Any

from locust import FastHttpUser, task
from locust.contrib.fasthttp import FastResponse
from locust.env import Environment

from tests.load import rounds
from tests.load.rounds import Given, Tally
from tests.load.steps import HZ

_SCANS = "scans"
_SPAWNED_PER_S = 50.0
_TIMEOUT_S = 30.0
_PROBLEM = "application/problem+json"


class Robots:
    """All robots of a run; Locust makes its users from a class, which therefore gets them as an attribute."""

    def __init__(self, given: Given) -> None:
        self.given = given
        self.tally = Tally()
        self.random = random.Random(5)  # noqa: S311 - not a secret
        own = type("OwnRobot", (Robot,), {"robots": self})
        self._runner = Environment(user_classes=[own], host=given.url).create_local_runner()

    def grow(self, sessions: int) -> None:
        """Let so many robots send scans."""
        more = sessions - self._runner.user_count
        self._runner.start(sessions, spawn_rate=_SPAWNED_PER_S)
        time.sleep(more / _SPAWNED_PER_S)

    def end(self) -> None:
        """Stop all robots."""
        self._runner.quit()

    def count(self, response: FastResponse, took_ms: float) -> None:
        """Count the response to a scan."""
        tally = self.tally
        if response.status_code == 200:
            tally.times_ms.append(took_ms)
            return
        if response.status_code == 0:  # an idle connection that was closed as the scan was sent, or a time-out
            error = getattr(response, "error", None)
            tally.refused["none"] += 1
            tally.causes.setdefault(type(error).__name__, str(error))
            return
        tally.refused[str(response.status_code)] += 1
        headers: Any = response.headers or {}
        if headers.get("content-type") != _PROBLEM or not headers.get("retry-after"):
            tally.impolite += 1
            return
        problem = json.loads(response.text or "")
        tally.causes.setdefault(problem["type"].rpartition(":")[2], problem["detail"])


class Robot(FastHttpUser):
    """Robot that sends a scan at each beat of 0.2 s of its own, or as soon as the last one was answered."""

    abstract = True
    network_timeout = _TIMEOUT_S
    connection_timeout = _TIMEOUT_S
    robots: Robots

    def on_start(self) -> None:
        """Begin at a moment of the robot's own."""
        self._due = time.monotonic() + self.robots.random.random() / HZ
        time.sleep(self._due - time.monotonic())
        self._path = ""
        self._bodies: Iterator[str] = iter(())

    def wait_time(self) -> float:
        """Return the time until the next beat, seconds; beats during which the last scan waited are left out.

        Locust's own pacing counts from the last scan: robots that waited together for a busy service would send at the
        same moment from then on.
        """
        now = time.monotonic()
        passed = math.floor((now - self._due) * HZ) / HZ
        self._due += max(1.0 / HZ, passed)
        return max(0.0, self._due - now)

    @task
    def scan(self) -> None:
        """Send the next scan, until it is answered."""
        body = next(self._bodies, None) or self._first()
        headers = self._headers()
        answered = False
        while not answered:
            began = time.perf_counter()
            with self.client.post(self._path, data=body, headers=headers, name=_SCANS, catch_response=True) as response:
                self.robots.count(response, 1e3 * (time.perf_counter() - began))
                response.success()
                answered = response.status_code == 200
                pause = 0.0 if answered else float((response.headers or {}).get("retry-after", 0.1))
            time.sleep(pause)

    def _first(self) -> str:
        """Open a session, and return its first scan."""
        work = self.robots.given.work
        body = json.dumps({"scenario": work["scenario"]})
        session = None
        while session is None:
            opened = self.client.post("/v1/sessions", data=body, headers=self._headers(), name="sessions")
            if opened.status_code == 201:
                session = opened.json()["id"]
            else:
                time.sleep(1.0)
        self._path = f"/v1/sessions/{session}/scans"
        self._bodies = iter(self.robots.random.choice(work["tours"]))
        return next(self._bodies)

    def _headers(self) -> dict[str, str]:
        key = self.robots.given.key
        own = {} if key is None else {"Authorization": f"Bearer {key}"}
        return own | {"Content-Type": "application/json", "Idempotency-Key": uuid.uuid4().hex}


if __name__ == "__main__":
    rounds.main(Robots, __doc__)
