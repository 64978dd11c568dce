"""Attacks on the store over a network: a PostgreSQL that does not answer any query."""

import os
import signal
import subprocess
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import httpx2

from tests.chaos.attack import Attack, Outcome
from tests.chaos.small_service import client, opened, scan, service
from tests.support.postgres import server
from tests.support.proxy import wire
from tests.support.replicas import Replica
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for

_BOUND_S = 10.0


def _under_silence(replica: Replica, silence: Callable[[], None], speak: Callable[[], None]) -> Outcome:
    """Send every kind of request while the database is silent, then end the service meanwhile."""
    with client(replica) as http, ThreadPoolExecutor(24) as pool:
        session = opened(http)
        before = scan(http, session).raise_for_status().json()["version"]
        silence()
        calls: list[Callable[[], httpx2.Response]] = [
            lambda: scan(http, session),
            lambda: http.get(f"/v1/sessions/{session}"),
            lambda: http.get("/v1/sessions"),
            lambda: http.get(f"/v1/sessions/{session}/history"),
            lambda: http.post("/v1/scenarios", json=data_scenario(name="another")),
        ]
        answers = list(pool.map(_timed, calls * 4))
        # What /readyz said before may be said for a moment; now it must know.
        answers += [_timed(call) for call in [*calls, lambda: http.get("/readyz")]]
        speak()
        wait_for(lambda: http.get("/readyz").status_code == 200, "the database to be back")
        again = scan(http, session).raise_for_status().json()["version"]
        silence()
        with suppress(httpx2.HTTPError):
            http.get("/v1/sessions", timeout=1.0)
        began = time.monotonic()
        ended = _ended(replica)
        stopped = time.monotonic() - began
        speak()
    worst = max(seconds for seconds, _ in answers)
    statuses = sorted({status for _, status in answers})
    figure = f"{len(answers)} requests: {statuses}, the last after {worst:.1f} s; SIGTERM ends after {stopped:.1f} s"
    held = statuses == [503] and worst <= _BOUND_S and ended and stopped <= _BOUND_S
    return Outcome(figure, f"scans afterwards: version {before} then {again}", held and again >= before + 1)


def _timed(call: Callable[[], httpx2.Response]) -> tuple[float, int]:
    began = time.monotonic()
    try:
        status = call().status_code
    except httpx2.HTTPError:
        status = 0
    return time.monotonic() - began, status


def _ended(replica: Replica) -> bool:
    replica.signal(signal.SIGTERM)
    try:
        replica.wait()
    except subprocess.TimeoutExpired:
        return False
    return True


def postgres_that_is_stopped(folder: Path) -> Outcome:
    """Stop (SIGSTOP) every process of PostgreSQL."""
    with server() as own, service(own.new_database(), folder) as replica:
        pids: list[int] = []

        def silence() -> None:
            pids[:] = own.pids
            for pid in pids:
                os.kill(pid, signal.SIGSTOP)

        def speak() -> None:
            for pid in pids:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGCONT)
            pids.clear()

        try:
            return _under_silence(replica, silence, speak)
        finally:
            speak()


def postgres_behind_a_frozen_network(folder: Path) -> Outcome:
    """Drop every packet between the service and PostgreSQL without closing the connection."""
    with server() as own:
        url = httpx2.URL(own.new_database())
        with wire(url.port or 0) as between, service(str(url.copy_with(port=between.port)), folder) as replica:
            try:
                return _under_silence(replica, between.cut, between.mend)
            finally:
                between.mend()


ATTACKS = [
    Attack(
        "store: PostgreSQL stopped",
        "hangs for 120 s and more (2026-11-28)",
        "503 and SIGTERM within 10 s",
        postgres_that_is_stopped,
    ),
    Attack(
        "store: PostgreSQL, network frozen",
        "?",
        "503 and SIGTERM within 10 s",
        postgres_behind_a_frozen_network,
    ),
]
