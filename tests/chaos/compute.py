"""Attacks on the workers: rankings that nobody waits for, the same one many times, stuck writers, many followers."""

import json
import signal
import socket
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import httpx2

from tests.benchmarks.service import post, scenario_of
from tests.chaos.attack import Attack, Outcome
from tests.support.replicas import Replica, replicas
from tests.support.serving import data_scenario, scan_of
from tests.support.waiting import wait_for

_RANKINGS = 18
_POSES = 1_500
_WRITERS = 20
_FOLLOWERS = 500
_LOCKED_S = 12.0
_SCANS = 40
_PATIENT = httpx2.Timeout(300.0)


@contextmanager
def _service(folder: Path, *options: str) -> Iterator[tuple[Replica, httpx2.Client]]:
    url = f"sqlite:///{folder / 'voa.db'}"
    with (
        replicas(url, folder, 1, "--log-level", "WARNING", *options) as (replica,),
        httpx2.Client(base_url=replica.url, timeout=_PATIENT) as http,
    ):
        yield replica, http


def _request(url: str, path: str, body: object) -> socket.socket:
    """Send a POST on a connection of its own and do not wait for the response."""
    host, _, port = url.removeprefix("http://").partition(":")
    content = json.dumps(body).encode()
    head = f"POST {path} HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\nContent-Length: {len(content)}"
    connection = socket.create_connection((host, int(port)), timeout=60.0)
    connection.sendall(head.encode() + b"\r\n\r\n" + content)
    return connection


def _gauge(http: httpx2.Client, name: str) -> float:
    lines = http.get("/metrics").text.splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith(f"{name} "))


def _heavy_scenario(http: httpx2.Client, folder: Path) -> str:
    return str(post(http, "/v1/scenarios", scenario_of(http, folder, "beam", poses=_POSES, sensors=12))["id"])


def _places(seed: int) -> list[dict[str, float]]:
    """12 sensor poses that no other ranking has: nothing about them is kept yet."""
    return [{"x": 0.3 + 1e-4 * seed, "y": 1e-3 * place, "yaw_rad": 3.1} for place in range(12)]


@contextmanager
def _under_way(folder: Path) -> Iterator[tuple[Replica, httpx2.Client, list[socket.socket], str]]:
    """A service with as many rankings under way or in line as fit, each another one."""
    with _service(folder) as (replica, http):
        scenario = _heavy_scenario(http, folder)
        bodies = [{"scenario": scenario, "belief": None, "sensors": _places(seed)} for seed in range(_RANKINGS)]
        held = [_request(replica.url, "/v1/rankings", body) for body in bodies]
        try:
            wait_for(lambda: _gauge(http, "voa_heavy_requests") >= _RANKINGS, "the rankings to be under way")
            yield replica, http, held, scenario
        finally:
            for connection in held:
                connection.close()


def _abandoned(folder: Path) -> Outcome:
    with _under_way(folder) as (_, http, held, scenario):
        began = time.monotonic()
        for connection in held:
            connection.close()
        wait_for(lambda: _gauge(http, "voa_heavy_requests") == 0, "the workers to be free", 150.0)
        seconds = time.monotonic() - began
        body = {"scenario": scenario, "belief": None, "sensors": _places(99)[:1]}
        answered = http.post("/v1/rankings", json=body).status_code
    return Outcome(
        f"workers free after {seconds:.1f} s", f"the next ranking: {answered}", seconds < 2 and answered == 200
    )


def _stopped(folder: Path) -> Outcome:
    with _under_way(folder) as (replica, http, _, _):
        http.close()
        began = time.monotonic()
        replica.signal(signal.SIGTERM)
        wait_for(lambda: not Path(f"/proc/{replica.pid}/exe").exists(), "the process to end", 150.0)
        seconds = time.monotonic() - began
        replica.wait()
        replica.start()
        ready = httpx2.get(f"{replica.url}/readyz", timeout=60).status_code
    return Outcome(f"ended {seconds:.1f} s after SIGTERM", f"started again: {ready}", seconds < 10 and ready == 200)


def _belief(seed: int) -> list[float]:
    """A belief over the poses of the heavy scenario."""
    shares = [1.0 + (seed + pose) % 7 for pose in range(_POSES)]
    return [share / sum(shares) for share in shares]


def _identical(folder: Path) -> Outcome:
    with _service(folder) as (_, http), ThreadPoolExecutor(_RANKINGS) as pool:
        scenario = _heavy_scenario(http, folder)

        def rank(seed: int) -> httpx2.Response:
            belief = _belief(seed)
            body = {"scenario": scenario, "belief": belief, "sensors": _places(0), "outcomes": True}
            return httpx2.post(f"{http.base_url}/v1/rankings", json=body, timeout=_PATIENT)

        rank(0)
        began = time.monotonic()
        rank(1)
        alone = time.monotonic() - began
        began = time.monotonic()
        answers = list(pool.map(rank, [2] * _RANKINGS))
        together = time.monotonic() - began
    equal = {answer.text for answer in answers if answer.status_code == 200}
    refused = sum(answer.status_code != 200 for answer in answers)
    figure = f"{together:.2f} s, {together / alone:.1f} times the time of one, {refused} refused"
    return Outcome(figure, f"{len(equal)} answer", together < 5.0 * alone and refused == 0 and len(equal) == 1)


def _timed(call: Callable[[], httpx2.Response]) -> tuple[float, int]:
    began = time.monotonic()
    status = call().status_code
    return time.monotonic() - began, status


def _stuck_writers(folder: Path) -> Outcome:
    with _service(folder) as (replica, http), ThreadPoolExecutor(_WRITERS) as pool:
        scenario = post(http, "/v1/scenarios", data_scenario())["id"]
        sessions = [str(post(http, "/v1/sessions", {"scenario": scenario})["id"]) for _ in range(_WRITERS)]

        def write(session: str) -> int:
            body = scan_of([0.5, 0.5, None, 1.0])
            return httpx2.post(f"{replica.url}/v1/sessions/{session}/scans", json=body, timeout=_PATIENT).status_code

        write(sessions[0])  # kernels are loaded at the first scan
        lock = sqlite3.connect(folder / "voa.db", isolation_level=None)
        lock.execute("BEGIN IMMEDIATE")
        began = time.monotonic()
        writes = [pool.submit(write, session) for session in sessions]
        latencies: list[float] = [0.0]
        statuses: dict[str, set[int]] = {"/readyz": set(), f"/v1/sessions/{sessions[0]}": set()}
        while time.monotonic() - began < _LOCKED_S:
            for path, seen in statuses.items():
                seconds, status = _timed(lambda path=path: http.get(path))  # type: ignore[misc] # bound in each round, which mypy cannot infer
                latencies.append(seconds)
                seen.add(status)
        lock.execute("ROLLBACK")
        lock.close()
        written = {call.result(120) for call in writes}
        afterwards = write(sessions[0])
    late = sorted(latencies)[len(latencies) * 99 // 100]
    ready, read = statuses.values()  # it is not ready once writes have waited in vain for as long as they may
    figure = (
        f"99 % of reads and /readyz within {late:.2f} s, all within {max(latencies):.2f} s: reads {sorted(read)}, "
        f"/readyz {sorted(ready)}"
    )
    survived = f"writes answered {sorted(written)}, then {afterwards}"
    return Outcome(figure, survived, late < 0.5 and read == {200} and ready <= {200, 503} and afterwards == 200)


class _Follower:
    """One raw connection that follows a session."""

    def __init__(self, url: str, session: str) -> None:
        host, _, port = url.removeprefix("http://").partition(":")
        self._connection = socket.create_connection((host, int(port)), timeout=60.0)
        self._connection.sendall(f"GET /v1/sessions/{session}/events HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())

    def read_until(self, version: int) -> list[int]:
        """The versions that came, once the given one is among them."""
        self._connection.settimeout(60.0)
        text = b""
        while f"\nid: {version}\n".encode() not in text.replace(b"\r", b""):
            chunk = self._connection.recv(65_536)
            assert chunk, text[:200]
            text += chunk
        return [int(line[4:]) for line in text.decode().splitlines() if line.startswith("id: ")]

    def close(self) -> None:
        self._connection.close()


def _many_followers(folder: Path) -> Outcome:
    with _service(folder) as (replica, http):
        scenario = post(http, "/v1/scenarios", data_scenario())["id"]
        session = str(post(http, "/v1/sessions", {"scenario": scenario})["id"])
        followers = [_Follower(replica.url, session) for _ in range(_FOLLOWERS)]
        for follower in followers:
            follower.read_until(0)
        received: list[list[int]] = []
        reader = threading.Thread(target=lambda: received.extend(each.read_until(_SCANS) for each in followers))
        path, body = f"/v1/sessions/{session}/scans", scan_of([0.5, 0.5, None, 1.0])
        latencies: list[float] = []
        refused = tries = 0
        reader.start()
        while len(latencies) < _SCANS and tries < 10 * _SCANS:
            tries += 1
            seconds, status = _timed(lambda: http.post(path, json=body))
            if status == 200:
                latencies.append(seconds)
            else:
                refused += 1
        reader.join(120.0)
        for follower in followers:
            follower.close()
        wanted = list(range(1, _SCANS + 1))
        complete = sum(versions == wanted for versions in received)
    worst = sorted(latencies)[len(latencies) * 9 // 10]
    figure = f"{refused} scans refused, 90 % answered within {worst:.2f} s"
    survived = f"{complete} of {_FOLLOWERS} followers received every version in order"
    return Outcome(figure, survived, refused == 0 and worst < 0.5 and complete == _FOLLOWERS)


ATTACKS: list[Attack] = [
    Attack("18 rankings that nobody waits for", "99 s", "2 s", _abandoned),
    Attack("SIGTERM with 18 rankings under way", "82 s", "10 s", _stopped),
    Attack("the same ranking 18 times at once", "14 times the time of one", "5 times the time of one", _identical),
    Attack("20 writers that wait for a lock of the database", "late by 44 s", "0.5 s", _stuck_writers),
    Attack("500 followers of one session", "5 of 45 scans refused, 0.79 s", "no scan refused, 0.5 s", _many_followers),
]
