"""Attacks on memory: the service as it is by default, in a group of 1 GB, with everything that it does at once."""

import os
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path

import httpx2

from tests.benchmarks.service import post, scenario_of
from tests.chaos.attack import Attack, Outcome
from tests.support.replicas import Replica
from tests.support.serving import box_obj, data_scenario, scan_of
from tests.support.waiting import wait_for

_LIMIT = 2**30
_UPLOADS, _SCANS = 8, 60
_PATIENT = httpx2.Timeout(300.0)
_HUNGRY_MESH = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + b" 1 2 3" * 2_500_000
"""15 MB that take two gigabytes to read."""


@contextmanager
def _group() -> Iterator[Path | None]:
    """A memory cgroup of `_LIMIT` bytes below this process's own; None where this machine allows none."""
    folder = None
    for line in Path("/proc/self/cgroup").read_text(encoding="utf-8").splitlines():
        _, controllers, path = line.split(":", 2)
        if "memory" in controllers.split(","):
            folder, name = Path("/sys/fs/cgroup/memory" + path), "memory.limit_in_bytes"
        elif controllers == "" and folder is None:
            folder, name = Path("/sys/fs/cgroup" + path), "memory.max"
    own = None
    with suppress(OSError):
        assert folder is not None
        own = Path(tempfile.mkdtemp(prefix="voa-chaos-", dir=folder))
        (own / name).write_text(str(_LIMIT), encoding="ascii")
    usable = own if own is not None and (own / name).exists() else None
    try:
        yield usable
    finally:
        if own is not None:
            with suppress(OSError, AssertionError):
                wait_for(
                    lambda: not (own / "cgroup.procs").read_text(encoding="ascii").split(), "the group to be empty"
                )
            with suppress(OSError):
                own.rmdir()


def _tree_bytes(pid: int) -> int:
    """Memory of a process and its children, what they share counted once."""
    total, waiting = 0, [pid]
    while waiting:
        process = waiting.pop()
        with suppress(OSError, ValueError):
            maps = Path(f"/proc/{process}/smaps_rollup").read_text(encoding="utf-8")
            total += next((int(line.split()[1]) for line in maps.splitlines() if line.startswith("Pss:")), 0) * 1024
            for task in Path(f"/proc/{process}/task").iterdir():
                waiting += [int(child) for child in (task / "children").read_text(encoding="ascii").split()]
    return total


class _Peak:
    """The most memory that a process and its children held, seen from beside."""

    def __init__(self, pid: int) -> None:
        self.bytes = 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, args=(pid,), daemon=True)
        self._thread.start()

    def _watch(self, pid: int) -> None:
        while not self._ended.wait(0.05):
            self.bytes = max(self.bytes, _tree_bytes(pid))

    def end(self) -> int:
        """Stop watching; the most bytes."""
        self._ended.set()
        self._thread.join()
        return self.bytes


def _statuses(answers: list[int]) -> str:
    return ", ".join(f"{answers.count(status)} x {status}" for status in sorted(set(answers)))


def _everything_at_once(folder: Path) -> Outcome:
    with _group() as group:
        replica = Replica(f"sqlite:///{folder / 'voa.db'}", folder / "service.log", "--log-level", "WARNING")
        if group is None:
            os.environ["VOA_MEMORY_MEBIBYTES"] = str(_LIMIT // 2**20)
        try:
            replica.launch()
            if group is not None:
                (group / "cgroup.procs").write_text(str(replica.pid), encoding="ascii")
            replica.wait_until_ready()
            return _attack(folder, replica, "a cgroup" if group is not None else "the setting")
        finally:
            os.environ.pop("VOA_MEMORY_MEBIBYTES", None)
            replica.end()


def _attack(folder: Path, replica: Replica, limited_by: str) -> Outcome:
    peak, pid = _Peak(replica.pid), replica.pid
    with httpx2.Client(base_url=replica.url, timeout=_PATIENT) as http, ThreadPoolExecutor(24) as pool:
        budget = http.get("/readyz").json().get("memory", {})
        large = post(http, "/v1/scenarios", scenario_of(http, folder, "exponential", poses=2_500, sensors=12))["id"]
        small = post(http, "/v1/scenarios", data_scenario())["id"]
        session = post(http, "/v1/sessions", {"scenario": small})["id"]

        def rank(gain: int) -> int:
            body = {"scenario": large, "belief": None, "outcomes": True, "min_gain": 0.001 * gain}
            return httpx2.post(f"{replica.url}/v1/rankings", json=body, timeout=_PATIENT).status_code

        def upload(mesh: bytes) -> int:
            files = {"file": ("thing.obj", mesh)}
            return httpx2.post(f"{replica.url}/v1/objects", files=files, timeout=_PATIENT).status_code

        def scan(_: int) -> int:
            path = f"{replica.url}/v1/sessions/{session}/scans"
            return httpx2.post(path, json=scan_of([0.5, 0.5, None, 1.0]), timeout=_PATIENT).status_code

        began = time.monotonic()
        calls = [pool.submit(rank, gain) for gain in range(4)]
        uploads = [pool.submit(upload, _HUNGRY_MESH) for _ in range(_UPLOADS)]
        scans = list(map(scan, range(_SCANS)))
        rankings = [call.result() for call in calls]
        meshes = [call.result() for call in uploads]
        seconds = time.monotonic() - began
        afterwards = [upload(box_obj().encode()), scan(0)]
    alive = Path(f"/proc/{pid}/exe").exists()
    most = peak.end()
    figure = f"{most / 2**20:.0f} MiB of 1024 (limited by {limited_by}; budgeted {budget.get('sum_mebibytes')})"
    survived = (
        f"{'alive' if alive else 'killed'} after {seconds:.0f} s; rankings {_statuses(rankings)}; hungry meshes "
        f"{_statuses(meshes)}; scans {_statuses(scans)}; afterwards {_statuses(afterwards)}"
    )
    held = alive and most <= _LIMIT and set(scans) == {200} and set(afterwards) <= {200, 201} and set(rankings) == {200}
    return Outcome(figure, survived, held)


ATTACKS: list[Attack] = [Attack("everything at once in 1 GB of memory", "killed", "1 GB, alive", _everything_at_once)]
