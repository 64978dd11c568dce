"""Attacks by the disk: errors of every call, a bit flipped in every byte, writes that were changed or lost silently."""

import os
import signal
from collections import Counter
from contextlib import closing
from pathlib import Path

import httpx2

from tests.chaos.attack import Attack, Outcome
from tests.support.history_calls import TIMEOUT, Recorder, opened, padded_scan, some_write
from tests.support.history_chaos import random_numbers
from tests.support.history_damage import Tried, try_cells, try_file
from tests.support.history_store import missing, verified
from tests.support.replicas import replicas
from tests.support.storage_faults import How, On, faulty_disk
from voa_store.drivers import sqlite_driver

SHARE = float(os.environ.get("CHAOS_BITS", "1"))
"""Share of the bytes of a stored history in which a bit is flipped."""
_WRITES = 12


def _written(folder: Path) -> Path:
    """Write a history of every kind of write by the service; returns the file, which nobody has open."""
    file, recorder, rng = folder / "voa.db", Recorder(), random_numbers(0)
    with (
        replicas(f"sqlite:///{file}", folder) as (replica,),
        httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http,
    ):
        sessions = opened(recorder, replica.url, 2)
        for number in range(_WRITES):
            recorder.response(http, some_write(rng, sessions[number % 2], f"{number}"))
        replica.signal(signal.SIGTERM)
        replica.wait()
    with closing(sqlite_driver().connect(str(file))) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    return file


def bits_of_rows(folder: Path) -> Outcome:
    """Flip a bit of each byte of each row of two sessions, their histories and their mesh."""
    return _outcome(try_cells(f"sqlite:///{_written(folder)}", SHARE))


def bits_of_the_file(folder: Path) -> Outcome:
    """Flip a bit of each 16th byte of the file."""
    return _outcome(try_file(_written(folder), folder, max(1, round(16 / SHARE))))


def _outcome(tried: Tried) -> Outcome:
    figure = f"{tried.named} of {tried.tried} named, {len(tried.missed)} missed"
    survived = f"{tried.harmless} in no row of a session; missed: {', '.join(tried.missed[:3]) or 'none'}"
    return Outcome(figure, survived, not tried.missed and tried.named > 0)


def silent_faults(folder: Path) -> Outcome:
    """Change or lose a write of a page silently, write on, kill the process, and verify the database."""
    seen: Counter[str] = Counter()
    for number, (how, skip) in enumerate((how, skip) for how in (How.FLIPPED, How.LOST) for skip in range(6)):
        own = folder / str(number)
        own.mkdir()
        seen[_silent_fault(own, how, skip)] += 1
    figure = ", ".join(f"{count} {name}" for name, count in sorted(seen.items()))
    return Outcome(figure, "answered writes of 12 databases", seen["LOST SILENTLY"] == 0)


def _silent_fault(folder: Path, how: How, skip: int) -> str:
    file, recorder = folder / "voa.db", Recorder()
    url = f"sqlite:///{file}"
    with (
        faulty_disk(folder, file) as disk,
        replicas(url, folder, environment=disk.environment) as (replica,),
        httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http,
    ):
        (session,) = opened(recorder, replica.url, 1)
        disk.fail(On.WRITE, how, skip=skip, times=1)
        for number in range(_WRITES):
            recorder.response(http, padded_scan(session, number))
        replica.kill()
    named, lost = not verified(url), missing(url, recorder.calls)
    if lost is None or lost > 1:
        return "lost and named" if named else "LOST SILENTLY"
    if lost == 1:  # the newest commit cannot be told from one that was not finished
        return "newest write lost"
    return "named, nothing lost" if named else "without effect"


ATTACKS = [
    Attack("disk: a bit of each byte of a history", "not tried", "all named", bits_of_rows),
    Attack("disk: a bit of each 16th byte of the file", "not tried", "all named", bits_of_the_file),
    Attack("disk: writes changed or lost silently", "not tried", "named", silent_faults),
]
