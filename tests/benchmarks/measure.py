"""Timing on a machine that others use too: CPU time, interleaved, medians, ratios of one run."""

import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import NamedTuple

Call = Callable[[], object]


class Result(NamedTuple):
    """Result of a benchmark: a line of the table, and an item of the JSON.

    Attributes:
        name: what was measured, on what, against whom; and what the ratio is where it is no quotient of times.
        ratio: peer / ours: how many times faster ours is, unless the name says otherwise.
        ours, peer: the two figures, in `unit`; ratio and peer are None for a figure that has no peer.
        unit: usually "ms", of CPU time.
    """

    name: str
    ratio: float | None
    ours: float
    peer: float | None
    unit: str


def cpu_seconds(call: Call) -> float:
    """CPU time of one call, over all threads of this process."""
    start = time.process_time()
    call()
    return time.process_time() - start


def interleaved(calls: Sequence[Call], rounds: int = 5) -> list[float]:
    """Median CPU seconds of each call, all taken in turn, so that a disturbance meets them alike.

    One round more comes first, uncounted: it compiles, touches memory and fills caches.
    """
    for call in calls:
        call()
    taken = [[cpu_seconds(call) for call in calls] for _ in range(rounds)]
    return [median(each) for each in zip(*taken, strict=True)]


def faster(name: str, ours_s: float, peer_s: float) -> Result:
    """A result in milliseconds from two CPU times in seconds."""
    return Result(name, peer_s / ours_s, 1e3 * ours_s, 1e3 * peer_s, "ms")


def require(holds: bool, message: str) -> None:
    """A benchmark of a wrong answer is worthless: stop the run.

    Raises:
        AssertionError: it does not hold.
    """
    if not holds:
        raise AssertionError(message)
