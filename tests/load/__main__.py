"""Measure how many sessions at 5 Hz a service carries: `python -m tests.load --out build/load.json`."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from rich.console import Console

from tests.load import report, services
from tests.load.scans import prepared
from tests.load.services import Start, Target
from tests.load.steps import Step

REPOSITORY = Path(__file__).parents[2]
SCENARIO = "goblet"
_RAISED = (10, 20, 40, 60, 80, 100, 120, 160, 200, 240, 320, 400)
_FLOOD = (600,)
_WIDTH = 130


@dataclass(frozen=True)
class Subject:
    """A service to measure.

    Attributes:
        start: starts it.
        sessions: numbers of sessions, one step each.
        processes: of the service.
    """

    start: Start
    sessions: tuple[int, ...]
    processes: int = 1


SUBJECTS = {
    "one process on SQLite": Subject(services.on_sqlite, _RAISED),
    "one process on PostgreSQL": Subject(services.on_postgres, _RAISED),
    "scans by Zenoh": Subject(services.on_zenoh, _RAISED),
    "two replicas on PostgreSQL": Subject(services.two_replicas, _RAISED, processes=2),
    "all robots with one key": Subject(services.with_a_key, (20, 60)),
    "too many for one process": Subject(services.on_sqlite, _FLOOD),
    "too many for two replicas": Subject(services.two_replicas, _FLOOD, processes=2),
}
SHORT = {name: replace(SUBJECTS[name], sessions=(4,)) for name in ("one process on SQLite", "scans by Zenoh")}


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(prog="python -m tests.load", description=__doc__)
    parser.add_argument("--out", type=Path, help="where to write the results as JSON")
    parser.add_argument("--short", action="store_true", help="a few sessions for a second, to see that it works")
    parser.add_argument("--only", choices=SUBJECTS, action="append", help="this service alone; may be repeated")
    parser.add_argument("--scenario", default=SCENARIO, help=f"shipped scenario (default {SCENARIO})")
    given = parser.parse_args()
    console = Console()
    console = console if console.is_terminal else Console(width=_WIDTH)
    when = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    loads = " ".join(f"{load:.1f}" for load in os.getloadavg())
    console.print(f"{when}, {os.cpu_count()} cores, load averages before {loads}", highlight=False)
    measured: dict[str, list[Step]] = {}
    subjects = SHORT if given.short else {name: SUBJECTS[name] for name in given.only or SUBJECTS}
    for name, subject in subjects.items():
        with console.status(name):
            steps = list(_measure(subject, given.scenario, 1.0 if given.short else 8.0))
        measured[name] = steps
        console.print(report.table(name, steps))
        console.print(f" {report.verdict(steps, subject.processes)}\n", highlight=False, soft_wrap=True)
    console.print(report.summary(measured))
    if given.out is not None:
        report.write(given.out, measured, when=when, cores=os.cpu_count(), load_before=loads, scenario=given.scenario)


def _measure(subject: Subject, scenario: str, seconds: float) -> Iterator[Step]:
    """Start a service and yield the figures of each number of sessions."""
    with tempfile.TemporaryDirectory(prefix="voa-load-") as folder, subject.start(Path(folder)) as target:
        bodies = Path(folder) / "bodies.json"
        prepared(target.url, scenario, bodies, target.key)
        yield from _driven(target, bodies, subject.sessions, seconds)


def _driven(target: Target, bodies: Path, sessions: tuple[int, ...], seconds: float) -> Iterator[Step]:
    """Run the process of the robots; it is one of its own, because Locust replaces parts of Python's library."""
    module = "tests.load.robots" if target.zenoh is None else "tests.load.bus_robots"
    command = [sys.executable, "-m", module, target.url, str(bodies), "--seconds", str(seconds)]
    command += ["--pids", json.dumps(target.pids), "--sessions", *map(str, sessions)]
    command += [] if target.key is None else ["--key", target.key]
    command += [] if target.zenoh is None else ["--zenoh", target.zenoh]
    robots = subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True)
    with robots:
        assert robots.stdout is not None
        for line in robots.stdout:
            yield Step(**json.loads(line))
    if robots.returncode != 0:
        raise SystemExit(f"the robots ended with exit code {robots.returncode}")


if __name__ == "__main__":
    main()
