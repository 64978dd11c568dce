"""Rounds of a fleet of robots: one number of sessions after another, each measured for some seconds."""

import argparse
import json
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Protocol

from tests.load.steps import Step, step_of
from tests.load.usage import cpu_seconds, machine_seconds

_SETTLE = 0.25
"""Share of a round's duration that passes before it is measured."""


@dataclass
class Tally:
    """Responses to the scans of one round; the fields are those of a `Step`."""

    times_ms: list[float] = field(default_factory=list)
    refused: Counter[str] = field(default_factory=Counter)
    impolite: int = 0
    causes: dict[str, str] = field(default_factory=dict)


class Fleet(Protocol):
    """Robots that send scans at 5 Hz, and count the responses in `tally`, which is replaced for each round."""

    tally: Tally

    def grow(self, sessions: int) -> None:
        """Let so many sessions send scans, those that do so already included."""
        ...

    def end(self) -> None:
        """Send no more."""
        ...


def rounds(fleet: Fleet, sessions: list[int], seconds: float, pids: dict[str, list[int]]) -> Iterator[Step]:
    """Yield the figures of one number of sessions after another, up to the first that the service does not carry.

    A number at which it is late is measured a second time, because another program may have disturbed the first.
    """
    for number in sessions:
        fleet.grow(number)
        step = _round(fleet, number, seconds, pids)
        if step.reason in ("late", "behind"):
            step = _round(fleet, number, seconds, pids)
        yield step
        if step.reason is not None:
            break
    fleet.end()


def _round(fleet: Fleet, number: int, seconds: float, pids: dict[str, list[int]]) -> Step:
    time.sleep(_SETTLE * seconds)
    tally = fleet.tally = Tally()
    before, began = _spent(pids), time.monotonic()
    time.sleep(seconds)
    took = time.monotonic() - began
    spent = {part: own - before[part] for part, own in _spent(pids).items()}
    fleet.tally = Tally()
    return step_of(number, took, tally.times_ms, tally.refused, tally.impolite, spent, tally.causes)


def _spent(pids: dict[str, list[int]]) -> dict[str, float]:
    """Return the CPU seconds so far by part; "robots" are this process, and "machine" is everything."""
    parts = {part: cpu_seconds(own) for part, own in pids.items()}
    return parts | {"robots": time.process_time(), "machine": machine_seconds()}


@dataclass(frozen=True)
class Given:
    """Arguments of a process of robots.

    Attributes:
        url: of the service.
        work: id of the scenario, and for each pose the bodies of a session's scans.
        key: of the caller, or None.
        zenoh: endpoint of a router, or None.
    """

    url: str
    work: dict[str, Any]
    key: str | None
    zenoh: str | None


def main(make: Callable[[Given], Fleet], description: str | None) -> None:
    """Run the rounds that the command line states, and print each as a line of JSON."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("url")
    parser.add_argument("bodies", type=Path, help="file of tests.load.scans")
    parser.add_argument("--sessions", type=int, nargs="+", required=True)
    parser.add_argument("--seconds", type=float, default=8.0, help="measured in each round")
    parser.add_argument("--pids", type=json.loads, default={}, help='processes by part, {"service": [1]}')
    parser.add_argument("--key", help="of the caller")
    parser.add_argument("--zenoh", help="endpoint of a router")
    given = parser.parse_args()
    work = json.loads(given.bodies.read_text(encoding="utf-8"))
    fleet = make(Given(given.url, work, given.key, given.zenoh))
    for step in rounds(fleet, given.sessions, given.seconds, given.pids):
        print(json.dumps(asdict(step)), flush=True)
