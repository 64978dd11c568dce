"""Proves what it costs to keep every answer: a scan update of 500 poses, committed and synced, on both databases.

Without HTTP: the use case against the bare transaction of the same rows in the same database (`bare`), CPU and wall
time of one update; then how many updates 16 threads make in a second on 16 sessions, against as many bare transactions
by 16 threads with a connection each, taken in turn; and on one session. The echo beside is in `service`. PostgreSQL's
own processes are not in the CPU time. Its tests run without fsync; this does not.

The time of one sync of the disk is printed first: it decides what the updates are compared with. A bare transaction
waits for one of its own, while some eight updates share one.
"""

import os
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import median

from starlette.testclient import TestClient

from tests.benchmarks import bare
from tests.benchmarks.measure import Result
from tests.benchmarks.service import post, scan_of, scenario_of
from tests.support import postgres
from voa_msgs.sessions import ScanRequest
from voa_service import bootstrap
from voa_service.http.app import create_app
from voa_service.runtime import logs
from voa_service.settings import Settings
from voa_store.records import Write

_POSES, _UPDATES, _ROUNDS, _WRITERS = 500, 40, 5, 16

Call = Callable[[], None]


def run() -> list[Result]:
    """SQLite, then PostgreSQL."""
    logs.configure("WARNING")
    with tempfile.TemporaryDirectory(prefix="voa-bench-") as folder, postgres.server(durable=True) as server:
        place = Path(folder)
        results = [Result("sync of 4 KiB to the disk", None, _sync_ms(place / "synced"), None, "ms wall")]
        file, url = place / "voa.db", server.new_database()
        results += _of("SQLite", f"sqlite:///{file}", place, bare.sqlite(str(file)))
        results += _of("PostgreSQL", url, place, bare.postgres(url))
    return results


def _sync_ms(file: Path) -> float:
    """Median wall milliseconds of a write of 4 KiB, and its sync, in a file that has its length already."""
    block, taken = os.urandom(4096), []
    with file.open("wb", buffering=0) as opened:
        opened.write(block)
        for _ in range(_ROUNDS * _UPDATES):
            began = time.perf_counter()
            os.pwrite(opened.fileno(), block, 0)
            os.fdatasync(opened.fileno())
            taken.append(1e3 * (time.perf_counter() - began))
    return median(taken)


def _of(name: str, url: str, place: Path, dialect: bare.Dialect) -> list[Result]:
    with ExitStack() as stack:
        services = stack.enter_context(bootstrap.services(Settings(database_url=url)))
        http = TestClient(create_app(services), "http://127.0.0.1")
        scenario = post(http, "/v1/scenarios", scenario_of(http, place, "exponential", _POSES, 4))["id"]
        sessions = [str(post(http, "/v1/sessions", {"scenario": scenario})["id"]) for _ in range(2 * _WRITERS)]
        scan = ScanRequest.model_validate(scan_of(http, scenario))
        received = scan.model_dump_json(exclude_unset=True)

        def update(session: str) -> None:
            services.updates.apply_scan(session, scan, Write("scan", received, None, None))

        updates = [partial(update, session) for session in sessions[:_WRITERS]]
        updates[0]()
        rows = dialect.read(sessions[0])
        transactions = []
        for session in sessions[_WRITERS:]:
            transact, disconnect = dialect.writer(session, rows)
            stack.callback(disconnect)
            transactions.append(transact)
        cpu, wall = _each([updates[0], transactions[0]])
        ours, peers = _rates([updates, transactions])
        title = f"durable scan update, {name} / bare transaction"
        many = f"durable scan updates, 16 writers on 16 sessions, {name} / bare transactions by 16 threads"
        return [
            Result(title, cpu[1] / cpu[0], cpu[0], cpu[1], "ms CPU"),
            Result(title, wall[1] / wall[0], wall[0], wall[1], "ms wall"),
            Result(many, ours / peers, ours, peers, "1/s"),
            Result(f"16 writers on one session, {name}", None, _per_second(updates[:1] * _WRITERS), None, "updates/s"),
        ]


def _each(calls: list[Call]) -> tuple[list[float], list[float]]:
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


def _rates(parties: Sequence[Sequence[Call]]) -> list[float]:
    """Median calls per second of each party's writers, the parties taken in turn."""
    rates = [[_per_second(writers) for writers in parties] for _ in range(_ROUNDS)]
    return [median(each) for each in zip(*rates, strict=True)]


def _per_second(writers: Sequence[Call]) -> float:
    """Calls per second of writers that each call again and again, in a thread of its own."""
    with ThreadPoolExecutor(len(writers)) as pool:
        began = time.perf_counter()
        list(pool.map(_repeat, writers))
        return len(writers) * _UPDATES / (time.perf_counter() - began)


def _repeat(call: Call) -> None:
    for _ in range(_UPDATES):
        call()
