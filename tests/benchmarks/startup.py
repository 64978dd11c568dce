"""Proves that a start is quick, and that a service which reports that it is ready has nothing left to load.

First update: CPU time of the server for the first scan that a process receives, against the tenth; the ratio says how
many times dearer the first is. Sessions and scenarios are in the database, as after a restart, and kernels are on the
disk. Each scan comes after a pause, as from robots: in a pause a process loses the processor's caches to others, and a
scan that follows at once would say how fast caches are, not what a new process has still to load. The tenth of ten
more, without pauses, is printed beside. CPU time, without peer, from the start of the process to its first `/readyz`,
and of `voa --help`.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import httpx2

from tests.benchmarks.measure import Result
from tests.benchmarks.service import cpu_seconds, post
from tests.support.serving import data_scenario, scan_of
from voa_client.local import running

_STARTS, _UPDATES = 3, 10
_PAUSE_S = 0.25
_SCAN = scan_of([0.5, 0.5, None, 1.0])


def run() -> list[Result]:
    """The first update after each of several starts, the starts, and the help of the command."""
    with tempfile.TemporaryDirectory(prefix="voa-bench-") as folder:
        starts = _starts(Path(folder))
    first, tenth, at_once, ready = (median(each) for each in zip(*starts, strict=True))
    return [
        Result("first scan update after a start / tenth", first / tenth, 1e3 * first, 1e3 * tenth, "ms CPU"),
        Result("tenth scan update, after a pause / at once", tenth / at_once, 1e3 * tenth, 1e3 * at_once, "ms CPU"),
        Result("start to ready, caches warm (at most 2 s)", None, ready, None, "s CPU"),
        Result("voa --help (at most 0.3 s)", None, median(_help() for _ in range(_STARTS)), None, "s CPU"),
    ]


def _starts(place: Path) -> list[tuple[float, float, float, float]]:
    """CPU seconds after each start: of the first and tenth update, of the tenth without pauses, and of the start."""
    options = ["--database-url", f"sqlite:///{place / 'start.db'}", "--log-level", "WARNING"]
    with running("voa_service", options, place / "log") as service, httpx2.Client(base_url=service.url) as http:
        scenario = post(http, "/v1/scenarios", data_scenario())
        path = f"/v1/sessions/{post(http, '/v1/sessions', {'scenario': scenario['id']})['id']}/scans"
        post(http, path, _SCAN)
    taken = []
    for _ in range(_STARTS):
        with running("voa_service", options, place / "log") as service, httpx2.Client(base_url=service.url) as http:
            ready = cpu_seconds(service.pid)
            updates = []
            for pause in _UPDATES * [_PAUSE_S] + _UPDATES * [0.0]:
                time.sleep(pause)
                before = cpu_seconds(service.pid)
                post(http, path, _SCAN)
                updates.append(cpu_seconds(service.pid) - before)
            taken.append((updates[0], updates[_UPDATES - 1], updates[-1], ready))
    return taken


def _help() -> float:
    """CPU seconds of one `voa --help`."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [str(Path(sys.executable).with_name("voa")), "--help"]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
