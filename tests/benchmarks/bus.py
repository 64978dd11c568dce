"""Proves what a question costs beyond the wire: round trips by Zenoh and by HTTP, beside bare ones.

A session of 135 poses is read: an answer of 4 kB, from the database, without numerics. By Zenoh, through a router,
against a queryable that replies as many bytes from its callback; by HTTP, on a connection that is kept, against a
FastAPI `def` endpoint that gives a pydantic message as long. Wall time, in turns; the gate is 0.5 (within 2x) at p50.
"""

import http.client
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import zenoh
from zenoh import Encoding

from tests.benchmarks.bare_queryable import KEY
from tests.benchmarks.measure import Result, require
from tests.support.routers import REPOSITORY, router
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from voa_client import Client
from voa_client.local import running
from voa_msgs.keys import Keys
from voa_msgs.links import session_config
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import SessionRequest

_POSES = 135
_ROUNDS, _REQUESTS = 10, 100
_SECONDS = 30.0


def run() -> list[Result]:
    """p50 and p99 of four ways to get 4 kB."""
    with tempfile.TemporaryDirectory(prefix="voa-bench-") as folder, ExitStack() as stack:
        place = Path(folder)
        bus = stack.enter_context(router())
        database = f"sqlite:///{place / 'bench.db'}"
        options = ["--database-url", database, "--log-level", "WARNING", "--zenoh", bus.endpoint]
        ours = stack.enter_context(running("voa_service", options, place / "service.log"))
        echo = stack.enter_context(running("tests.benchmarks.echo", [], place / "echo.log"))
        client = stack.enter_context(Client(f"zenoh://127.0.0.1:{bus.port}"))
        scenario = client.create_scenario(ScenarioRequest.model_validate(_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id))
        by_http, by_echo = (stack.enter_context(_kept(url)) for url in (ours.url, echo.url))
        answer = _get(by_http, f"/v1/sessions/{session.id}")
        require(3_500 < len(answer) < 4_500, f"expected an answer of about 4 kB, got {len(answer)} bytes")
        _put(by_echo, "/session", answer)
        stack.enter_context(_bare_queryable(bus.endpoint, len(answer)))
        own = stack.enter_context(zenoh.open(_config(bus.endpoint)))
        method, payload = Keys().rpc("session.get"), json.dumps({"session": session.id})
        for key in (KEY, method):
            wait_for(lambda key=key: list(own.get(key, payload=payload, timeout=_SECONDS)), f"{key} to be known")  # type: ignore[misc] # a default is bound now
        require(len(_reply(own, KEY, payload)) == len(_reply(own, method, payload)) == len(answer), "answers differ")
        taken = _in_turns(
            [
                lambda: _reply(own, method, payload),
                lambda: _reply(own, KEY, payload),
                lambda: _get(by_http, f"/v1/sessions/{session.id}"),
                lambda: _get(by_echo, "/session"),
            ]
        )
    results = []
    for way, mine, theirs in (
        ("Zenoh / bare queryable", taken[0], taken[1]),
        ("HTTP / bare FastAPI echo", taken[2], taken[3]),
    ):
        for name, share in (("p50", 0.50), ("p99", 0.99)):
            a, b = (1e3 * each[int(share * (len(each) - 1))] for each in (mine, theirs))
            results.append(Result(f"round trip of 4 kB by {way}, {name}", b / a, a, b, "ms wall"))
    return results


def _scenario() -> dict[str, object]:
    poses = [f"P{index}" for index in range(_POSES)]
    ranges = {pose: [0.5, 0.5, None, 0.2 + 0.001 * index] for index, pose in enumerate(poses)}
    return data_scenario(
        poses=[{"name": pose} for pose in poses],
        scores={"probabilities": [[0.5] * _POSES, [0.4] * _POSES]},
        sensors=[{"name": "Q1", "x": 0.0, "y": 0.0, "yaw_rad": 0.0}],
        predictions={"Q1": ranges},
    )


def _in_turns(calls: list[Callable[[], object]]) -> list[list[float]]:
    """Wall seconds of each call, ascending; a disturbance meets them alike. A round more comes first, uncounted."""
    taken: list[list[float]] = [[] for _ in calls]
    for number in range(_ROUNDS + 1):
        for call, times in zip(calls, taken, strict=True):
            for _ in range(_REQUESTS):
                began = time.perf_counter()
                call()
                if number:
                    times.append(time.perf_counter() - began)
    return [sorted(times) for times in taken]


def _config(endpoint: str) -> zenoh.Config:
    config = zenoh.Config()
    for path, value in session_config([endpoint], open_ms=10_000).items():
        config.insert_json5(path, json.dumps(value))
    return config


def _reply(session: zenoh.Session, key: str, payload: str) -> bytes:
    replies = session.get(key, payload=payload, encoding=Encoding.APPLICATION_JSON, timeout=_SECONDS)
    (reply,) = replies
    require(reply.ok is not None, f"{key} was refused")
    return b"" if reply.ok is None else reply.ok.payload.to_bytes()


@contextmanager
def _kept(url: str) -> Iterator[http.client.HTTPConnection]:
    """A connection that is kept, by the thinnest client that there is."""
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=_SECONDS)
    try:
        yield connection
    finally:
        connection.close()


def _get(connection: http.client.HTTPConnection, path: str) -> bytes:
    connection.request("GET", path)
    answer = connection.getresponse()
    body = answer.read()
    require(answer.status == http.client.OK, f"{path}: {answer.status}")
    return body


def _put(connection: http.client.HTTPConnection, path: str, body: bytes) -> None:
    connection.request("PUT", path, body, {"Content-Type": "application/json"})
    answer = connection.getresponse()
    answer.read()
    require(answer.status == http.client.OK, f"{path}: {answer.status}")


@contextmanager
def _bare_queryable(endpoint: str, size: int) -> Iterator[None]:
    command = [sys.executable, "-m", "tests.benchmarks.bare_queryable", endpoint, str(size)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=REPOSITORY)
    try:
        require(process.stdout is not None and process.stdout.readline() == "listening\n", "no queryable")
        yield
    finally:
        process.terminate()
        process.wait()
