"""Attacks on the store in a file: long deletions, full disks, flipped bits, two processes, lists of much."""

import math
import resource
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2

from tests.chaos.attack import Attack, Outcome
from tests.chaos.small_service import client, opened, scan, service
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from voa_store.drivers import sqlite_driver

_VERSIONS = 100_000
_SPAN_S = 3.0


def _grow(database: Path, session: str, versions: int) -> None:
    """Give a session a long history, row by row like the newest one, behind the service's back.

    Its rows are no chain: nothing but a deletion may touch it.
    """
    with closing(sqlite_driver().connect(str(database), isolation_level=None)) as connection:
        columns = [row[1] for row in connection.execute("PRAGMA table_info(history)")]
        others = ", ".join(name for name in columns if name not in ("version", "belief", "request"))
        connection.execute("BEGIN IMMEDIATE")
        connection.execute(
            "WITH RECURSIVE n(v) AS (SELECT 1 UNION ALL SELECT v + 1 FROM n WHERE v < ?) "  # noqa: S608 - our own names
            f"INSERT INTO history (version, request, belief, {others}) "
            f"SELECT v, hex(zeroblob(1500)), zeroblob(8000), {others} FROM n, history "
            "WHERE session = ? AND version = 0",
            (versions, session),
        )
        connection.execute("UPDATE sessions SET version = ? WHERE id = ?", (versions, session))
        connection.execute("COMMIT")
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")  # or the next write would have all of it to do


@dataclass
class Scans:
    """Scans to one session, one after another; when each was answered, and how long that took."""

    ended: bool = False
    done: list[tuple[float, float]] = field(default_factory=list)

    def run(self, http: httpx2.Client, session: str) -> None:
        """Send scans until ended."""
        while not self.ended:
            began = time.monotonic()
            scan(http, session, len(self.done)).raise_for_status()
            self.done.append((time.monotonic(), time.monotonic() - began))

    def worst(self, since: float, until: float) -> float:
        """The longest of those that were answered in a span of time."""
        return max(took for at, took in list(self.done) if since <= at < until)


def delete_of_a_long_session(folder: Path) -> Outcome:
    """Delete 100 000 versions while another session gets scans; kill the process on the way."""
    database = folder / "voa.db"
    with service(f"sqlite:///{database}", folder) as replica, client(replica) as http, ThreadPoolExecutor(1) as pool:
        long, other = opened(http), opened(http)
        _grow(database, long, _VERSIONS)
        scan(http, other).raise_for_status()
        scans, began = Scans(), time.monotonic()
        running = pool.submit(scans.run, http, other)
        time.sleep(_SPAN_S)
        deleted = time.monotonic()
        gone = http.delete(f"/v1/sessions/{long}")
        answered = time.monotonic()
        unseen = http.get(f"/v1/sessions/{long}").status_code == 404
        time.sleep(_SPAN_S)  # while rows are being removed
        scans.ended = True
        running.result()
        usual, worst = scans.worst(began, deleted), scans.worst(deleted, math.inf)
        replica.kill()
        left = _rows(database, long)
        replica.start()
        wait_for(lambda: _rows(database, long) == 0, "the rest to be removed", 90.0)
        still = http.get(f"/v1/sessions/{long}").status_code == 404
        version = http.get(f"/v1/sessions/{other}").json()["version"]
    figure = f"another session's scan {worst:.2f} s at worst (before: {usual:.2f} s), DELETE {answered - deleted:.2f} s"
    survived = f"{len(scans.done)} scans of the other; {left} rows left by the kill were removed at the start"
    held = worst - usual <= 0.25 and gone.status_code == 204 and unseen and still
    return Outcome(figure, survived, held and version == len(scans.done) + 1)


def _rows(database: Path, session: str) -> int:
    with closing(sqlite_driver().connect(str(database))) as connection:
        (count,) = connection.execute("SELECT count(*) FROM history WHERE session = ?", (session,)).fetchone()
    return int(count)


def disk_that_is_full(folder: Path) -> Outcome:
    """Let no file grow any more, as on a full disk, then let them grow again."""
    database = folder / "voa.db"
    with service(f"sqlite:///{database}", folder) as replica, client(replica) as http:
        session = opened(http)
        done = [scan(http, session, number).status_code for number in range(20)]
        size = max(path.stat().st_size for path in folder.glob("voa.db*"))
        _, most = resource.prlimit(replica.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(replica.pid, resource.RLIMIT_FSIZE, (size, most))
        refused = _until_refused(http, session, done)
        time.sleep(1.1)  # a successful probe is reported for up to a second
        ready = http.get("/readyz").status_code
        read = http.get(f"/v1/sessions/{session}").status_code
        resource.prlimit(replica.pid, resource.RLIMIT_FSIZE, (most, most))
        wait_for(lambda: http.get("/readyz").status_code == 200, "room again")
        version = scan(http, session, 999).raise_for_status().json()["version"]
    figure = f"/readyz {ready} while writes answer {refused}"
    survived = f"{done.count(200)} scans answered and there, reads {read}"
    return Outcome(figure, survived, (ready, refused, read) == (503, 503, 200) and version == done.count(200) + 1)


def _until_refused(http: httpx2.Client, session: str, done: list[int]) -> int:
    while (status := scan(http, session, len(done)).status_code) == 200:
        done.append(status)
    return status


def flipped_bit(folder: Path) -> Outcome:
    """Flip one bit of a stored belief and of a stored scan, as a disk may do."""
    database = folder / "voa.db"
    with service(f"sqlite:///{database}", folder) as replica, client(replica) as http:
        sessions = [opened(http) for _ in range(3)]
        for session in sessions:
            for number in range(5):
                scan(http, session, number).raise_for_status()
        _flip(
            database,
            "UPDATE sessions SET belief = ? WHERE id = ?",
            "SELECT belief FROM sessions WHERE id = ?",
            sessions[0],
        )
        _flip(
            database,
            "UPDATE history SET belief = ? WHERE session = ? AND version = 3",
            "SELECT belief FROM history WHERE session = ? AND version = 3",
            sessions[1],
        )
        scan(http, sessions[2], 9).raise_for_status()
        answers = [
            http.get(f"/v1/sessions/{sessions[0]}"),
            scan(http, sessions[0], 9),
            http.get(f"/v1/sessions/{sessions[1]}/history"),
        ]
        others = [
            http.get(f"/v1/sessions/{sessions[1]}").status_code,
            http.get(f"/v1/sessions/{sessions[2]}/history").status_code,
            http.get("/readyz").status_code,
        ]
    kinds = [f"{answer.status_code} {_kind(answer)}" for answer in answers]
    figure = "; ".join(kinds)
    held = all(answer.status_code == 500 and _kind(answer) == "damaged" for answer in answers)
    named = [answer.json().get("version") for answer in answers if answer.status_code == 500]
    return Outcome(figure, f"others answer {others}; versions named: {named}", held and others == [200, 200, 200])


def _flip(database: Path, put: str, get: str, session: str) -> None:
    with closing(sqlite_driver().connect(str(database), isolation_level=None)) as connection:
        (blob,) = connection.execute(get, (session,)).fetchone()
        connection.execute(put, (bytes([blob[0] ^ 1]) + blob[1:], session))


def _kind(answer: httpx2.Response) -> str:
    body: Any = answer.json()
    return str(body.get("type", "no problem")).rpartition(":")[2]


def two_services_on_one_file(folder: Path) -> Outcome:
    """Write to one SQLite file from two processes, and kill one on the way."""
    url = f"sqlite:///{folder / 'voa.db'}"
    with ExitStack() as stack:
        one, other = (stack.enter_context(service(url, folder)) for _ in range(2))
        http, there = (stack.enter_context(client(each)) for each in (one, other))
        session = opened(http)
        with ThreadPoolExecutor(8) as pool:
            answers = list(pool.map(lambda n: scan(there if n % 2 else http, session, n).status_code, range(400)))
        other.kill()
        version = http.get(f"/v1/sessions/{session}").json()["version"]
        database = http.get("/readyz").json().get("database")
    lost = answers.count(200) - version
    figure = f"{database}: {lost} of {answers.count(200)} lost"
    return Outcome(figure, f"version {version}", lost == 0 and database is not None)


def lists_of_much(folder: Path) -> Outcome:
    """List 60 scenarios of 1 MB each."""
    with service(f"sqlite:///{folder / 'voa.db'}", folder) as replica, client(replica) as http:
        for number in range(60):
            data = {"note": f"{number:04d}" + "x" * 950_000}
            http.post(
                "/v1/scenarios", json=data_scenario(grasps=[{"name": "G1", "data": data}, {"name": "G2"}])
            ).raise_for_status()
        before = _memory(replica.pid)
        began = time.monotonic()
        page = http.get("/v1/scenarios", params={"limit": 200}).raise_for_status()
        took, grown = time.monotonic() - began, _memory(replica.pid) - before
    figure = f"{took:.2f} s and {grown / 2**20:.0f} MB more"
    return Outcome(
        figure, f"{len(page.json()['items'])} listed in {len(page.content)} bytes", took < 0.25 and grown < 20e6
    )


def _memory(pid: int) -> int:
    """The most memory that a process has held so far, in bytes."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


ATTACKS = [
    Attack(
        "store: DELETE of 100 000 versions",
        "6.45 s at worst (2026-11-28)",
        "others at most 0.25 s late",
        delete_of_a_long_session,
    ),
    Attack("store: a disk that is full", "/readyz 200 (2026-11-28)", "/readyz 503", disk_that_is_full),
    Attack("store: a flipped bit", "200, unnoticed (2026-11-28)", "500 damaged, the version named", flipped_bit),
    Attack(
        "store: two services on one SQLite file",
        "0 of 400 lost, but on 3.40.1, which can",
        "0 lost, on a mended SQLite",
        two_services_on_one_file,
    ),
    Attack(
        "store: a list of 60 scenarios of 1 MB", "0.21 s and 55 MB more (2026-11-28)", "0.25 s, 20 MB", lists_of_much
    ),
]
