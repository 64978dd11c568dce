"""Worker process as the page sees it: started, given a task, and killed with all that it started."""

import asyncio
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Self

from voa_console.new_object.messages import Reply, Task

_LINE_BYTES = 64 * 2**20
_PASSED_ON = (
    "HOME", "LANG", "LC_", "LD_LIBRARY_PATH", "MPLCONFIGDIR", "NUMBA_", "PATH", "PYTHON", "SSL_CERT_FILE", "TMPDIR",
    "VIRTUAL_ENV", "XDG_CACHE_HOME",
)  # fmt: skip
"""Environment variables that the process needs to run; none of them is a secret."""
_KEYS = ("VOA_KEY", "VOA_KEY_FILE")
"""Environment variables with the key by which the process calls the service."""


class TaskFailed(Exception):
    """A task cannot be done; the message is a sentence for a person."""


class WorkerProcess:
    """Process that does tasks one after the other.

    Args:
        process: that was started, the first of its group.
    """

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    @classmethod
    async def start(cls, url: str, log: Path, key: str | None = None) -> Self:
        """Start a process.

        Args:
            url: address of the service.
            log: file for its stderr.
            key: by which it calls the service; None: the key of this process, if it has one.

        Raises:
            TaskFailed: no process can be started.
        """
        passed_on = _PASSED_ON if key is not None else (*_PASSED_ON, *_KEYS)
        environment = {name: value for name, value in os.environ.items() if name.startswith(passed_on)}
        if key is not None:
            environment["VOA_KEY"] = key
        threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        try:
            with log.open("ab") as errors:
                process = await asyncio.create_subprocess_exec(
                    *(sys.executable, "-m", "voa_console.new_object.worker", url),
                    stdin=asyncio.subprocess.PIPE,
                    stdout=asyncio.subprocess.PIPE,
                    stderr=errors,
                    env=environment | threads,
                    limit=_LINE_BYTES,
                    start_new_session=True,
                )
        except OSError as error:
            raise TaskFailed(f"No process could be started: {error.strerror}. Try again.") from error
        return cls(process)

    @property
    def is_running(self) -> bool:
        """True until the process has ended."""
        return self._process.returncode is None

    async def do(self, task: Task, seconds: float | None, report: Callable[[Reply], None]) -> str:
        """Do a task, and return its result as JSON; the process is killed if it takes too long or is interrupted.

        Args:
            task: the task.
            seconds: most time for it; None: any.
            report: receives the steps and their progress.

        Raises:
            TaskFailed: the task cannot be done, took too long, or the process has ended.
        """
        try:
            async with asyncio.timeout(seconds):
                return await self._result(task, report)
        except TimeoutError:
            self.kill()
            raise TaskFailed(f"This took more than {seconds:g} s, and was stopped: simplify the mesh.") from None
        except asyncio.CancelledError:
            self.kill()
            raise

    async def _result(self, task: Task, report: Callable[[Reply], None]) -> str:
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None  # noqa: S101 - PIPE
        assert stdout is not None  # noqa: S101 - PIPE
        with suppress(ConnectionError):  # the end of stdout shows that the process has ended
            stdin.write(f"{task.model_dump_json()}\n".encode())
            await stdin.drain()
        while line := await stdout.readline():
            reply = Reply.model_validate_json(line)
            if reply.error is not None:
                raise TaskFailed(reply.error)
            if reply.result is not None:
                return reply.result
            report(reply)
        await self._process.wait()
        raise TaskFailed("The process that does the work has ended: too little memory, or a mesh that it cannot read.")

    def kill(self) -> None:
        """Kill the process with all that it started."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
