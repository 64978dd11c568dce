"""The service with spans inside its requests: `python -m tests.benchmarks.spanned --spans FILE --fd N ...`.

A span is the CPU time of the process from the call of a function to its return. Two sums, of numerics and of the store,
are kept in a file that the benchmark maps into memory too. The benchmark sends one request at a time, and no other part
of the process works while a span lasts; threads that do a span's work for it count.
"""

import argparse
import mmap
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from struct import pack_into, unpack_from
from typing import Any

from voa_service import serve
from voa_service.mapping import estimates
from voa_service.usecases import updates
from voa_service.usecases.places import LookedFrom
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
        self._inside = False

    def read(self) -> tuple[float, float]:
        """Return the sums: of numerics, of the store."""
        numerics, store = unpack_from(_LAYOUT, self._sums)
        return numerics, store

    @contextmanager
    def span(self, kind: int) -> Iterator[None]:
        """Add the CPU time of a `with` block to a sum: 0 of numerics, 1 of the store; within another span: nothing."""
        if self._inside:
            yield
            return
        self._inside, began = True, time.process_time()
        try:
            yield
        finally:
            sums = list(self.read())
            sums[kind] += time.process_time() - began
            pack_into(_LAYOUT, self._sums, 0, *sums)
            self._inside = False

    def around(self, kind: int, function: Callable[..., Any]) -> Callable[..., Any]:
        """Make a function that calls another within a span."""

        @wraps(function)
        def spanned(*arguments: Any, **named: Any) -> Any:
            with self.span(kind):
                return function(*arguments, **named)

        return spanned

    def around_transaction(self, change: Callable[..., Any]) -> Callable[..., Any]:
        """Make a context manager whose entry and exit, and not what is done between, are spans of the store."""

        @contextmanager
        @wraps(change)
        def spanned(*arguments: Any, **named: Any) -> Iterator[Any]:
            manager = change(*arguments, **named)
            with self.span(1):
                entered = manager.__enter__()
            try:
                yield entered
            except BaseException as error:
                if not manager.__exit__(type(error), error, error.__traceback__):
                    raise
            else:
                with self.span(1):
                    manager.__exit__(None, None, None)

        return spanned


def put_spans(spans: Spans) -> None:
    """Put spans around numerics and store of a scan update; raises AttributeError where a function has another name."""
    for owner, name in (
        (updates, "scan_observation"),
        (updates, "next_version"),
        (estimates, "best_grasp"),
        (LookedFrom, "prepared"),
        (LookedFrom, "updated"),
        (LookedFrom, "keep"),
    ):
        setattr(owner, name, spans.around(0, getattr(owner, name)))
    for name in ("get_session", "get_response"):
        setattr(SqlStore, name, spans.around(1, getattr(SqlStore, name)))
    setattr(SqlStore, "change", spans.around_transaction(SqlStore.change))  # noqa: B010 - mypy allows no other way


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--spans", type=Path, required=True)
    given, options = parser.parse_known_args()
    put_spans(Spans(given.spans))
    sys.exit(serve.main(options))
