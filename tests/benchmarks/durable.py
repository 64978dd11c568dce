"""Proves what it costs to keep every answer: a scan update of 500 poses, committed and synced, on both databases.

Without HTTP: the use case against the bare transaction (the raw driver reads, updates and appends blobs of the same
sizes, and commits), CPU and wall time of one update; then updates per second of 16 threads on 16 sessions and on one.
The echo beside is in `service`. PostgreSQL's own processes are not in the CPU time. Its tests run without fsync; this
does not.
"""

import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path
from statistics import median

import numpy as np
import psycopg
from starlette.testclient import TestClient

from tests.benchmarks.measure import Result
from tests.benchmarks.service import post, scan_of, scenario_of
from tests.support import postgres
from voa_msgs.sessions import ScanRequest
from voa_service import bootstrap
from voa_service.http.app import create_app
from voa_service.runtime import logs
from voa_service.settings import Settings
from voa_store.drivers import sqlite_driver
from voa_store.records import Write

_POSES, _UPDATES, _ROUNDS, _WRITERS = 500, 40, 5, 16
_REPORT = '{"accepted":true}' + 150 * " "

Commit = Callable[[], None]
Prepare = Callable[[bytes, str], Commit]


def run() -> list[Result]:
    """SQLite, then PostgreSQL."""
    logs.configure("WARNING")
    results = []
    with tempfile.TemporaryDirectory(prefix="voa-bench-") as folder, postgres.server(durable=True) as server:
        place = Path(folder)
        results += _of("SQLite", f"sqlite:///{place / 'voa.db'}", place, _bare_sqlite(place / "bare.db"))
        results += _of("PostgreSQL", server.new_database(), place, _bare_postgres(server.new_database()))
    return results


def _of(name: str, url: str, place: Path, bare: AbstractContextManager[Prepare]) -> list[Result]:
    with ExitStack() as stack:
        services = stack.enter_context(bootstrap.services(Settings(database_url=url)))
        http = TestClient(create_app(services), "http://127.0.0.1")
        scenario = post(http, "/v1/scenarios", scenario_of(http, place, "exponential", _POSES, 4))["id"]
        sessions = [str(post(http, "/v1/sessions", {"scenario": scenario})["id"]) for _ in range(_WRITERS)]
        scan = ScanRequest.model_validate(scan_of(http, scenario))
        received = scan.model_dump_json(exclude_unset=True)
        commit = stack.enter_context(bare)(np.zeros((2, _POSES)).tobytes(), received)

        def update(session: str) -> None:
            services.updates.apply_scan(session, scan, Write("scan", received, None, None))

        cpu, wall = _each([lambda: update(sessions[0]), commit])
        return [
            Result(f"durable scan update, {name} / bare transaction", cpu[1] / cpu[0], cpu[0], cpu[1], "ms CPU"),
            Result(f"durable scan update, {name} / bare transaction", wall[1] / wall[0], wall[0], wall[1], "ms wall"),
            Result(f"16 writers on 16 sessions, {name}", None, _per_second(update, sessions), None, "updates/s"),
            Result(f"16 writers on one session, {name}", None, _per_second(update, sessions[:1]), None, "updates/s"),
        ]


def _each(calls: list[Callable[[], None]]) -> tuple[list[float], list[float]]:
    """Median CPU and wall milliseconds of one call each, taken in turn."""
    cpu: list[list[float]] = [[] for _ in calls]
    wall: list[list[float]] = [[] for _ in calls]
    for _ in range(_ROUNDS):
        for index, call in enumerate(calls):
            spent, began = time.process_time(), time.perf_counter()
            for _ in range(_UPDATES):
                call()
            cpu[index].append(1e3 * (time.process_time() - spent) / _UPDATES)
            wall[index].append(1e3 * (time.perf_counter() - began) / _UPDATES)
    return [median(each) for each in cpu], [median(each) for each in wall]


def _per_second(update: Callable[[str], None], sessions: list[str]) -> float:
    turns = [sessions[index % len(sessions)] for index in range(_WRITERS * _UPDATES)]
    with ThreadPoolExecutor(_WRITERS) as pool:
        began = time.perf_counter()
        list(pool.map(update, turns))
        return len(turns) / (time.perf_counter() - began)


@contextmanager
def _bare_sqlite(path: Path) -> Iterator[Prepare]:
    """The same reads and writes by the raw driver."""
    connection = sqlite_driver().connect(str(path), isolation_level=None)
    for statement in (
        "PRAGMA journal_mode=WAL",
        "PRAGMA synchronous=FULL",
        "CREATE TABLE session (id INTEGER PRIMARY KEY, version INTEGER, belief BLOB)",
        "CREATE TABLE history (version INTEGER PRIMARY KEY, request TEXT, report TEXT, belief BLOB)",
    ):
        connection.execute(statement)

    def prepared(belief: bytes, request: str) -> Commit:
        connection.execute("INSERT INTO session VALUES (1, 0, ?)", (belief,))

        def commit() -> None:
            connection.execute("BEGIN IMMEDIATE")
            [version] = connection.execute("SELECT version, belief FROM session WHERE id = 1").fetchone()[:1]
            connection.execute("UPDATE session SET version = ?, belief = ? WHERE id = 1", (version + 1, belief))
            connection.execute("INSERT INTO history VALUES (?, ?, ?, ?)", (version + 1, request, _REPORT, belief))
            connection.execute("COMMIT")

        return commit

    yield prepared
    connection.close()


@contextmanager
def _bare_postgres(url: str) -> Iterator[Prepare]:
    """The same reads and writes by the raw driver."""
    connection = psycopg.connect(url)
    connection.execute("CREATE TABLE session (id INTEGER PRIMARY KEY, version INTEGER, belief BYTEA)")
    connection.execute("CREATE TABLE history (version INTEGER PRIMARY KEY, request TEXT, report TEXT, belief BYTEA)")
    connection.commit()

    def prepared(belief: bytes, request: str) -> Commit:
        connection.execute("INSERT INTO session VALUES (1, 0, %s)", (belief,))

        def commit() -> None:
            row = connection.execute("SELECT version, belief FROM session WHERE id = 1 FOR UPDATE").fetchone()
            assert row is not None
            version = row[0] + 1
            connection.execute("UPDATE session SET version = %s, belief = %s WHERE id = 1", (version, belief))
            connection.execute("INSERT INTO history VALUES (%s, %s, %s, %s)", (version, request, _REPORT, belief))
            connection.commit()

        return commit

    yield prepared
    connection.close()
