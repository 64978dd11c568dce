"""The end of the process in bounded time, whatever its threads do."""

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Self

import structlog

_LOG_SECONDS = 0.2


class Deadline:
    """Ends the process some seconds after `begin`, whatever its threads do; used in a `with` statement.

    Nothing is lost: a write is committed and synced before it is answered.

    Args:
        seconds: from `begin` to the end.
        end: ends the process with an exit code.
    """

    def __init__(self, seconds: float, end: Callable[[int], object] = os._exit) -> None:
        self._seconds = seconds
        self._end = end
        # A signal handler may interrupt anything, also code that holds a lock: it writes a byte and takes none.
        self._write, self._read = os.pipe()[::-1]
        self._thread = threading.Thread(target=self._wait, name="voa-deadline", daemon=True)

    def begin(self) -> None:
        """Start the countdown; may be called by a signal handler, and more than once."""
        with suppress(BrokenPipeError):  # the countdown has begun already
            os.write(self._write, b".")

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
