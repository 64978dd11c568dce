"""The end of the process: it drains first, and ends in bounded time, whatever its threads do."""

import math
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Self

import structlog

_LOG_SECONDS = 0.2


class Drain:
    """First part of a stop, in which the process serves as before and reports that it is not ready.

    A balancer sends requests until its probes have seen that a process is not ready: a process that refused
    connections at once would fail those requests.

    Args:
        seconds: from `begin` to the end of the drain; 0: there is none.
        clock: returns seconds that never go back.
    """

    def __init__(self, seconds: float = 0.0, clock: Callable[[], float] = time.monotonic) -> None:
        self.seconds = seconds
        self._clock = clock
        self._ends_at = math.inf

    def begin(self) -> None:
        """Begin to drain; takes no lock, for a signal handler may call it."""
        self._ends_at = self._clock() + self.seconds

    @property
    def has_begun(self) -> bool:
        """True if the process is about to end."""
        return self._ends_at < math.inf

    @property
    def is_over(self) -> bool:
        """True if the time in which balancers learn of the end has passed."""
        return self._clock() >= self._ends_at


class Deadline:
    """Ends the process some seconds after `begin`, whatever its threads do; used in a `with` statement.

    No answered write is lost: it is committed and synced before it is answered.

    Args:
        seconds: from `begin` to the end.
        end: ends the process with an exit code.
    """

    def __init__(self, seconds: float, end: Callable[[int], object] = os._exit) -> None:
        self._seconds = seconds
        self._end = end
        self._ends_at = math.inf
        # A signal handler may interrupt anything, also code that holds a lock: it writes a byte and takes none.
        self._write, self._read = os.pipe()[::-1]
        self._thread = threading.Thread(target=self._wait, name="voa-deadline", daemon=True)

    def begin(self) -> None:
        """Start the countdown; may be called by a signal handler, and more than once."""
        self._ends_at = min(self._ends_at, time.monotonic() + self._seconds)
        with suppress(BrokenPipeError):  # the countdown has begun already
            os.write(self._write, b".")

    @property
    def left(self) -> float:
        """Seconds until the process is ended; all of them where the countdown has not begun."""
        return max(0.0, min(self._seconds, self._ends_at - time.monotonic()))

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Stop waiting for `begin`; a countdown that has begun goes on, as threads may hang the interpreter's exit."""
        os.close(self._write)

    def _wait(self) -> None:
        begun = os.read(self._read, 1)
        os.close(self._read)
        if not begun:
            return
        threading.Event().wait(self._seconds)
        log_thread = threading.Thread(target=self._log, daemon=True)  # a blocked stderr must not delay the end
        log_thread.start()
        log_thread.join(_LOG_SECONDS)
        self._end(0)

    def _log(self) -> None:
        structlog.get_logger("voa").warning(
            "stopped with work under way", seconds=self._seconds, hint="every answered write is stored"
        )
