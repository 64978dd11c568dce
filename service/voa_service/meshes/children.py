"""Processes that are fed on stdin and can all be ended at once."""

import subprocess
import threading
from collections.abc import Mapping, Sequence


class Children:
    """The processes under way."""

    def __init__(self) -> None:
        self.closed = False
        self._running: set[subprocess.Popen[bytes]] = set()
        self._lock = threading.Lock()

    def run(
        self, command: Sequence[str], content: bytes, seconds: float, environment: Mapping[str, str]
    ) -> "subprocess.CompletedProcess[bytes]":
        """Run a command on `content`, and wait for its end.

        Raises:
            subprocess.TimeoutExpired: it took longer than `seconds`, and was killed.
            OSError: there is no room for another process.
        """
        pipe = subprocess.PIPE
        with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, env=environment) as process:  # noqa: S603 - ours
            with self._lock:
                self._running.add(process)
            try:
                if self.closed:
                    process.kill()
                out, said = process.communicate(content, timeout=seconds)
            except BaseException:
                process.kill()
                raise
            finally:
                with self._lock:
                    self._running.discard(process)
            return subprocess.CompletedProcess(process.args, process.returncode, out, said)

    def close(self) -> None:
        """Kill every process, and any that is begun from now on."""
        with self._lock:
            self.closed = True
            for process in self._running:
                process.kill()
