"""Records calls of a running service over HTTP, with their times, for `tests.support.histories`.

Writers repeat each write under its key until there is a response, as clients do; each attempt is recorded.
"""

import hashlib
import json
import math
import random
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from math import cos, sin
from typing import Any

import httpx2

from tests.support.histories import Call, Kind, Outcome
from tests.support.serving import LIDAR, Json, box_obj, data_scenario, mesh_scenario, scan_of

TIMEOUT = 120.0
AGAIN_SHARE = 0.03
"""Share of writes that are sent once more after their response."""
_AGAIN_S = 0.05


@dataclass(frozen=True)
class Sent:
    """Write that is identical each time it is sent."""

    method: str
    path: str
    body: str
    key: str

    @property
    def session(self) -> str:
        """Id of the session in the path; empty where a session is created."""
        parts = self.path.split("/")
        return parts[3] if len(parts) > 3 else ""

    def to(self, http: httpx2.Client, base: str = "") -> httpx2.Response:
        """Send it, to a client's own service or to that at `base`."""
        headers = {"Content-Type": "application/json", "Idempotency-Key": self.key}
        return http.request(self.method, base + self.path, content=self.body, headers=headers)


@dataclass
class Recorder:
    """Record of the calls of all writers and readers.

    Attributes:
        calls: each attempt, in the order of the responses.
        answered: number of writes with a response, each counted once.
        sent_again: number of attempts without a response that says that the write is done.
        failures: number of these by status; None: without a response.
        ended: True if writers and readers are to stop.
        now: clock of the calls, seconds.
    """

    calls: list[Call] = field(default_factory=list)
    answered: int = 0
    sent_again: int = 0
    failures: Counter[int | None] = field(default_factory=Counter)
    ended: bool = False
    now: Callable[[], float] = time.monotonic
    _changed: threading.Condition = field(default_factory=threading.Condition)

    def write(self, http: httpx2.Client, sent: Sent, base: str = "") -> httpx2.Response | None:
        """Send a write once and record the attempt; None: there was no response."""
        kind: Kind = "write" if sent.session else "create"
        return self._attempt(kind, sent, lambda: sent.to(http, base))

    def response(self, http: httpx2.Client, sent: Sent, base: str = "") -> httpx2.Response:
        """Send a write once, record the attempt, and return its response, which there must be."""
        response = self.write(http, sent, base)
        assert response is not None, "there was no response"
        return response

    def give_up(self, sent: Sent, send: Callable[[], object]) -> None:
        """Record an attempt that `send` makes and whose response nobody reads."""
        started = self.now()
        send()
        with self._changed:
            self.calls.append(
                Call("write", sent.session, started, math.inf, "unknown", key=sent.key, request=sent.body)
            )

    def version(self, http: httpx2.Client, session: str) -> int:
        """Read a session, record it, and return its version."""
        response = self.read(http, session)
        assert response is not None, "there was no response"
        return int(response.raise_for_status().json()["version"])

    def write_until_answered(self, http: httpx2.Client, sent: Sent, bases: Callable[[], str]) -> httpx2.Response:
        """Repeat a write under its key until there is a response that is no failure of the service."""
        while True:
            response = self.write(http, sent, bases())
            if response is not None and response.status_code < 500:
                assert response.is_success, response.text
                with self._changed:
                    self.answered += 1
                    self._changed.notify_all()
                return response
            with self._changed:
                self.sent_again += 1
                self.failures[None if response is None else response.status_code] += 1
                self._changed.wait(_AGAIN_S)

    def read(self, http: httpx2.Client, session: str, base: str = "") -> httpx2.Response | None:
        """Read a session once and record the attempt; None: there was no response."""
        path = f"/v1/sessions/{session}"
        return self._attempt("read", Sent("GET", path, "", ""), lambda: http.get(base + path))

    def create(self, http: httpx2.Client, scenario: str, key: str, base: str = "") -> str:
        """Open a session on a scenario under a key and return its id."""
        sent = Sent("POST", "/v1/sessions", json.dumps({"scenario": scenario}), key)
        response = self.response(http, sent, base)
        assert response.status_code == 201, response.text
        return str(response.json()["id"])

    def wait_for(self, more: int, seconds: float = TIMEOUT) -> None:
        """Wait until `more` further writes got a response."""
        with self._changed:
            goal = self.answered + more
            self._changed.wait_for(lambda: self.answered >= goal or self.ended, seconds)
            assert self.answered >= goal, "the writers came to a stop"

    def end(self) -> None:
        """Let all writers and readers end."""
        with self._changed:
            self.ended = True
            self._changed.notify_all()

    @contextmanager
    def running(self, urls: Sequence[str], sessions: Sequence[str], writers: int) -> Iterator[None]:
        """Run writers and a reader for the duration of a `with`, and raise what one of them raises."""
        with ThreadPoolExecutor(writers + 1) as pool:
            jobs = [pool.submit(_until_ended, _write, f"w{n}", urls, sessions, self) for n in range(writers)]
            jobs.append(pool.submit(_until_ended, _read, "r", urls, sessions, self))
            try:
                yield
            finally:
                self.end()
                for job in jobs:
                    job.result()

    def wait_for_a_write(self, seconds: float) -> None:
        """Wait for the response to any write, for at most so many seconds."""
        with self._changed:
            self._changed.wait(seconds)

    def _attempt(self, kind: Kind, sent: Sent, send: Callable[[], httpx2.Response]) -> httpx2.Response | None:
        written = kind != "read"
        call = Call(
            kind,
            sent.session,
            self.now(),
            math.inf,
            "unknown",
            key=sent.key if written else None,
            request=sent.body if written else None,
        )
        response = None
        try:
            response = send()
        except httpx2.TransportError:
            pass
        else:
            call = _answered(call, response, self.now())
        with self._changed:
            self.calls.append(call)
        return response


def _answered(call: Call, response: httpx2.Response, ended: float) -> Call:
    """Complete a call by its response."""
    if not response.is_success:
        return replace(call, outcome=_failure(call.kind, response.status_code), ended=ended)
    body = response.json()
    return replace(
        call,
        session=body["id"],
        ended=ended,
        outcome=_success(call.kind, body),
        version=body["version"],
        answer=hashlib.sha256(response.content).hexdigest()[:16] if call.key is not None else None,
        belief=tuple(body["belief"]),
    )


def _failure(kind: Kind, status: int) -> Outcome:
    if status >= 500:
        return "unknown"
    return "gone" if kind == "read" and status == 404 else "refused"


def _success(kind: Kind, body: Json) -> Outcome:
    if kind == "read":
        return "read"
    # A replaced belief always makes a version, and says nothing about an update.
    return "made" if body.get("update", {"accepted": True})["accepted"] else "kept"


# --------------------------------------------------------------------------------------------- writers and readers


def some_write(rng: random.Random, session: str, key: str) -> Sent:
    """Make any write: mostly scans, some of which are not accepted."""
    kind = rng.choices(["scan", "outcome", "belief", "nothing"], [70, 15, 10, 5])[0]
    root = f"/v1/sessions/{session}"
    if kind == "outcome":
        body: Json = {"grasp": rng.choice(["G1", "G2"]), "success": rng.random() < 0.5}
        body |= {"object_moved": 0.25} if rng.random() < 0.2 else {}
        return Sent("POST", f"{root}/grasp-outcomes", json.dumps(body), key)
    if kind == "belief":
        first, second = sorted((rng.random(), rng.random()))
        given = rng.choice([None, [first, second - first, 1.0 - second]])
        return Sent("PUT", f"{root}/belief", json.dumps({"belief": given}), key)
    ranges: list[float | None] = (
        [None] * 4 if kind == "nothing" else [round(rng.uniform(0.2, 1.2), 6) for _ in range(4)]
    )
    return Sent("POST", f"{root}/scans", json.dumps(scan_of(ranges, rng.choice(["Q1", "Q2"]), stamp=key)), key)


def padded_scan(session: str, number: int) -> Sent:
    """Make a scan whose request is 20 kB long."""
    body = scan_of([0.5, 0.5 + number / 1000, None, 1.0], stamp=f"{number} " + "x" * 20_000)
    return Sent("POST", f"/v1/sessions/{session}/scans", json.dumps(body), f"key {number}")


def assert_not_ready(response: httpx2.Response) -> None:
    """Assert that a response is a problem document that says to try again."""
    assert response.status_code == 503, response.text
    assert response.headers["content-type"] == "application/problem+json"
    assert response.json()["type"] in ("urn:voa:problem:not-ready", "urn:voa:problem:overloaded")
    assert int(response.headers["Retry-After"]) > 0


def _until_ended(work: "Worker", name: str, urls: Sequence[str], sessions: Sequence[str], recorder: Recorder) -> None:
    """Run a writer or reader on any of the sessions, each time by any process; a failure ends all others too."""
    rng = random.Random(name)  # noqa: S311 - not a secret
    try:
        with httpx2.Client(timeout=TIMEOUT) as http:
            count = 0
            while not recorder.ended:
                work(recorder, http, rng, urls, rng.choice(sessions), f"{name}-{count}")
                count += 1
    finally:
        recorder.end()


def _write(
    recorder: Recorder, http: httpx2.Client, rng: random.Random, urls: Sequence[str], session: str, key: str
) -> None:
    """Repeat a write under its key, to any process, until there is a response; some are then sent once more."""
    sent = some_write(rng, session, key)
    recorder.write_until_answered(http, sent, lambda: rng.choice(urls))
    if rng.random() < AGAIN_SHARE:
        recorder.write(http, sent, rng.choice(urls))


def _read(
    recorder: Recorder, http: httpx2.Client, rng: random.Random, urls: Sequence[str], session: str, _key: str
) -> None:
    """Read once after each response to a write."""
    recorder.read(http, session, rng.choice(urls))
    recorder.wait_for_a_write(1.0)


Worker = Callable[[Recorder, httpx2.Client, random.Random, Sequence[str], str, str], None]


def opened(recorder: Recorder, url: str, count: int) -> list[str]:
    """Open `count` sessions: the first of two on a scenario of data, the second on a scenario with a spread."""
    with httpx2.Client(base_url=url, timeout=TIMEOUT) as http:
        box = http.post("/v1/objects", files={"file": ("box.obj", box_obj())}).raise_for_status().json()["id"]
        scenarios = [stored_scenario(http, body) for body in (data_scenario(), spread_scenario(box))]
        return [recorder.create(http, scenarios[number % 2], f"session {number}") for number in range(count)]


def stored_scenario(http: httpx2.Client, body: Json) -> str:
    """Store a scenario and return its id."""
    response = http.post("/v1/scenarios", json=body)
    assert response.is_success, response.text
    return str(response.json()["id"])


def spread_scenario(object_: str) -> Json:
    """Box that spreads about three poses and may be absent, seen by four beams; every scan is evidence."""
    poses: list[dict[str, Any]] = [
        {"name": f"P{yaw}", "position": [0.0, 0.0, 0.0], "quaternion_wxyz": [cos(yaw / 2), 0.0, 0.0, sin(yaw / 2)]}
        for yaw in (0.0, 0.5, 1.0)
    ]
    return mesh_scenario(
        object_,
        poses=poses,
        scores={"attempts": 10, "successes": [[9, 5, 1], [2, 6, 8]]},
        sensors=[
            {"name": "Q1", "x": 0.3, "y": 0.0, "yaw_rad": 3.0},
            {"name": "Q2", "x": 0.0, "y": 0.3, "yaw_rad": -1.7},
        ],
        lidar=LIDAR | {"height_m": 0.02},
        update={"rule": "exponential", "no_return_m": 1.0, "on_nothing_seen": "evidence"},
        spread={"xy_m": 0.01, "yaw_rad": 0.1},
        absent=0.1,
    )
