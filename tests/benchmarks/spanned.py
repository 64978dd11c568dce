"""The service with spans inside its requests: `python -m tests.benchmarks.spanned --spans FILE --fd N ...`.

A span is the CPU time of the process from the call of a function to its return. Two sums, of numerics and of the store,
are kept in a file that the benchmark maps into memory too. The benchmark sends one request at a time, and no other part
of the process works while a span lasts; threads that do a span's work for it count.
"""

import argparse
import mmap
import sys
import time
from collections.abc import Callable
from functools import partial, wraps
from pathlib import Path
from struct import pack_into, unpack_from
from typing import Any

from voa_service import serve
from voa_service.mapping import estimates
from voa_service.mapping.observations import ReceivedScan
from voa_service.usecases import updates
from voa_service.usecases.places import LookedFrom
from voa_store.records import SessionChange, Step, Write
from voa_store.sql import SqlStore

_LAYOUT = "2d"
_SIZE = 16


class Spans:
    """CPU seconds of numerics and of the store so far, in a file that two processes map.

    Args:
        file: of the sums; made, with sums of 0, if it is missing.
    """

    def __init__(self, file: Path) -> None:
        if not file.exists():
            file.write_bytes(bytes(_SIZE))
        with file.open("r+b") as opened:
            self._sums = mmap.mmap(opened.fileno(), _SIZE)
        self._inside, self._since = False, 0.0

    def read(self) -> tuple[float, float]:
        """Return the sums: of numerics, of the store."""
        numerics, store = unpack_from(_LAYOUT, self._sums)
        return numerics, store

    def within(self, kind: int, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        """Call a function, and add its CPU time to a sum, 0 of numerics or 1 of the store, unless a span lasts."""
        if self._inside:
            return function(*arguments, **named)
        self._inside, self._since = True, time.process_time()
        try:
            return function(*arguments, **named)
        finally:
            self._add(kind)
            self._inside = False

    def without(self, kind: int, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function within a span of a kind, whose time does not count as that span's."""
        self._add(kind)
        self._inside = False
        try:
            return function(*arguments)
        finally:
            self._inside, self._since = True, time.process_time()

    def _add(self, kind: int) -> None:
        pack_into("d", self._sums, 8 * kind, self.read()[kind] + time.process_time() - self._since)


def put_spans(spans: Spans) -> None:
    """Put spans around numerics and store of a scan update; raises AttributeError where a function has another name."""
    for owner, name in (
        (updates, "received_scan"),
        (ReceivedScan, "predicted"),
        (ReceivedScan, "observation"),
        (updates, "next_version"),
        (updates, "belief_summary"),
        (estimates, "belief_summary"),
        (LookedFrom, "prepared"),
        (LookedFrom, "updated"),
        (LookedFrom, "keep"),
    ):
        setattr(owner, name, _around(spans, 0, getattr(owner, name)))
    for name in ("get_session", "get_response"):
        setattr(SqlStore, name, _around(spans, 1, getattr(SqlStore, name)))
    setattr(SqlStore, "change", _around_change(spans, SqlStore.change))  # noqa: B010 - mypy allows no other


def _around_change(spans: Spans, change: Callable[..., SessionChange]) -> Callable[..., SessionChange]:
    """Make a function that changes a session within a span of the store, which the step does not count in."""

    def spanned(store: SqlStore, id_: str, write: Write, step: Step) -> SessionChange:
        changed: SessionChange = spans.within(1, change, store, id_, write, partial(spans.without, 1, step))
        return changed

    return spanned


def _around(spans: Spans, kind: int, function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function that calls another within a span."""

    @wraps(function)
    def spanned(*arguments: Any, **named: Any) -> Any:
        return spans.within(kind, function, *arguments, **named)

    return spanned


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--spans", type=Path, required=True)
    given, options = parser.parse_known_args()
    put_spans(Spans(given.spans))
    sys.exit(serve.main(options))
