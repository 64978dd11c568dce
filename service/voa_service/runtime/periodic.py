"""Work that a process repeats in the background."""

import threading
from collections.abc import Callable

import structlog

from voa_service.runtime.logs import reason_of

_END_SECONDS = 5.0


class Periodic:
    """Thread that does some work at intervals, until it is closed.

    Args:
        name: of the thread.
        work: to be done; its argument sleeps for so many seconds, and returns true to end early.
        interval_s: from the end of one round to the next, seconds.
        first_s: from the start to the first round, seconds.
    """

    def __init__(
        self,
        name: str,
        work: Callable[[Callable[[float], object]], object],
        interval_s: float,
        first_s: float = 0.0,
    ) -> None:
        self._work, self._interval_s, self._first_s = work, interval_s, first_s
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """Stop the thread, and wait some seconds for the end of its round."""
        self._closed.set()
        if self._thread.ident is not None:
            self._thread.join(_END_SECONDS)

    def _run(self) -> None:
        self._closed.wait(self._first_s)
        while not self._closed.is_set():
            try:
                self._work(self._closed.wait)
            except Exception as error:  # whatever it is: the next round tries again
                log = structlog.get_logger("voa")
                log.warning("background work has to wait", work=self._thread.name, **reason_of(error))
            self._closed.wait(self._interval_s)
