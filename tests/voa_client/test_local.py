"""Services that are started on this machine, and the end of their processes."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from voa_client.local import end

IGNORES = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('ready', flush=True); signal.pause()"
OBEYS = "import signal; print('ready', flush=True); signal.pause()"
HAS_ENDED = "print('ready', flush=True); raise SystemExit(3)"


@contextmanager
def child(code: str) -> Iterator["subprocess.Popen[bytes]"]:
    """Run Python code in a child process, from the moment at which it has printed a line."""
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"ready\n"
            yield process
        finally:
            process.kill()


def test_a_process_that_ignores_the_request_to_end_is_killed() -> None:
    with child(IGNORES) as process:
        end(process, 0.05)
        assert process.returncode == -signal.SIGKILL


def test_a_process_that_obeys_the_signal_is_not_killed() -> None:
    with child(OBEYS) as process:
        end(process, 60.0)
        assert process.returncode == -signal.SIGTERM


def test_a_process_that_has_ended_keeps_its_exit_status() -> None:
    with child(HAS_ENDED) as process:
        process.wait(60.0)
        end(process, 0.0)
        assert process.returncode == 3
