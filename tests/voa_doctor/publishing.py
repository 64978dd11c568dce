"""Robots that publish on a router for as long as a doctor looks."""

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from tests.support.routers import Router
from tests.voa_recordings.files.bags import laser_scan
from voa_client import ZenohAddress
from voa_client.zenoh_session import joined
from voa_ros.cdr import encode_laser_scan
from voa_ros.messages import LaserScan, Stamp

_EVERY_S = 0.01

Messages = Callable[[int], Iterable[tuple[str, bytes]]]
"""The keys and payloads that are put in one step, by its number."""


@contextmanager
def publishing(router: Router, messages: Messages, every_s: float = _EVERY_S) -> Iterator[None]:
    """Put step after step, one in `every_s` seconds, for the length of a `with`."""
    ended = threading.Event()
    with joined(ZenohAddress.parse(router.endpoint)) as robot:

        def run() -> None:
            step = 0
            while not ended.wait(every_s):
                for key, payload in messages(step):
                    robot.put(key, payload)
                step += 1

        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()


def scan(step: int, *, frame_id: str = "base_scan", at: Stamp | None = None, **changes: Any) -> LaserScan:
    """A revolution with noise, stamped now unless `at` says otherwise."""
    ranges = [0.5 + (step * 7 + beam) % 10 / 1000 for beam in range(360)]
    stamp = Stamp.of(time.time()) if at is None else at
    return replace(laser_scan(ranges), stamp=stamp, frame_id=frame_id, **changes)


def sent(key: str, make: Callable[[int], LaserScan]) -> Messages:
    """Make messages of one scan per step, on one key."""
    return lambda step: [(key, encode_laser_scan(make(step)))]
