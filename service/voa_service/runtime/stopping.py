"""The end of the process: requests are given some seconds, and nothing that hangs delays it further."""

import asyncio
import os
import socket
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Self

import structlog
import uvicorn

from voa_service.http.connections.guard import Guard
from voa_service.runtime.changes import Changes

_LAST_WORD_SECONDS = 0.2
_ANSWERED_BY = 0.4
"""Of the time to stop: by then what is still under way is answered 503."""
_DRAINED_BY = 0.5


class Deadline:
    """Ends the process some seconds after `begin`, whatever its threads do; used in a `with`.

    What was answered is committed and synced before it is answered, so nothing is lost.

    Args:
        seconds: from `begin` to the end.
        end: ends the process, with its exit code.
    """

    def __init__(self, seconds: float, end: Callable[[int], object] = os._exit) -> None:
        self._seconds = seconds
        self._end = end
        # A signal handler may interrupt anything, also code that holds a lock: it writes a byte and takes none.
        self._write, self._read = os.pipe()[::-1]
        self._thread = threading.Thread(target=self._wait, name="voa-deadline", daemon=True)

    def begin(self) -> None:
        """Start the time; may be called by a signal handler, and more than once."""
        os.write(self._write, b".")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Stop waiting for `begin`; once begun the time runs on, as threads may hang the end of the interpreter."""
        os.close(self._write)

    def _wait(self) -> None:
        begun = os.read(self._read, 1)
        os.close(self._read)
        if not begun:
            return
        threading.Event().wait(self._seconds)
        said = threading.Thread(target=self._say, daemon=True)  # whoever reads the log may hang too
        said.start()
        said.join(_LAST_WORD_SECONDS)
        self._end(0)

    def _say(self) -> None:
        structlog.get_logger("voa").warning(
            "stopped with work under way", seconds=self._seconds, hint="what was answered is stored"
        )


class Server(uvicorn.Server):
    """The HTTP server, which stops in bounded time.

    Args:
        config: of uvicorn.
        changes: ends the streams that would never end by themselves.
        guard: of the connections.
        deadline: begins when the process is told to stop.
        stop_seconds: from there to the end.
    """

    def __init__(
        self, config: uvicorn.Config, changes: Changes, guard: Guard, deadline: Deadline, stop_seconds: float
    ) -> None:
        config.timeout_graceful_shutdown = max(1, round(stop_seconds * _DRAINED_BY))
        super().__init__(config)
        self._changes = changes
        self._guard = guard
        self._deadline = deadline
        self._answered_by = stop_seconds * _ANSWERED_BY

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to stop."""
        self._deadline.begin()
        self._changes.close()
        super().handle_exit(sig, frame)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Let requests end, then answer them that the service is stopping."""
        late = asyncio.get_running_loop().call_later(self._answered_by, self._guard.end)
        try:
            await super().shutdown(sockets)
        finally:
            late.cancel()
