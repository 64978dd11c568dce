"""Child processes that get their input on stdin, and that can all be killed at once."""

import subprocess
import threading
from collections.abc import Mapping, Sequence


class Children:
    """The child processes that are running."""

    def __init__(self) -> None:
        self.closed = False
        self._running: set[subprocess.Popen[bytes]] = set()
        self._lock = threading.Lock()

    def run(
        self, command: Sequence[str], content: bytes, seconds: float, environment: Mapping[str, str]
    ) -> "subprocess.CompletedProcess[bytes]":
        """Run a command with `content` on its stdin, and wait for its end.

        Raises:
            subprocess.TimeoutExpired: the command took longer than `seconds`, and was killed.
            OSError: no process could be started.
        """
        pipe = subprocess.PIPE
        with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, env=environment) as process:  # noqa: S603 - ours
            with self._lock:
                self._running.add(process)
            try:
                if self.closed:
                    process.kill()
                out, errors = process.communicate(content, timeout=seconds)
            except BaseException:
                process.kill()
                raise
            finally:
                with self._lock:
                    self._running.discard(process)
            return subprocess.CompletedProcess(process.args, process.returncode, out, errors)

    def close(self) -> None:
        """Kill every child process, and every one that is started from now on."""
        with self._lock:
            self.closed = True
            for process in self._running:
                process.kill()
