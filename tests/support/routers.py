"""Zenoh router as a process that tests may kill and start again: a session of the library in router mode.

    python -m tests.support.routers tcp/127.0.0.1:7447 [CONFIG as JSON: more entries by path]

runs until it receives SIGTERM.
"""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import zenoh

from tests.support.waiting import wait_for

REPOSITORY = Path(__file__).resolve().parents[2]
FAST = {"open/return_conditions": {"connect_scouted": False, "declares": False}, "scouting/delay": 0}
STOP_SECONDS = 10.0


class Router:
    """Router on an endpoint of its own, which it keeps over restarts."""

    def __init__(self, more: dict[str, Any] | None = None, protocol: str = "tcp") -> None:
        self._more = more or {}
        with socket.create_server(("127.0.0.1", 0)) as listening:
            self.port: int = listening.getsockname()[1]
        self.endpoint = f"{protocol}/127.0.0.1:{self.port}"
        self._process: subprocess.Popen[str] | None = None

    @property
    def pid(self) -> int:
        """Process id of the running router."""
        assert self._process is not None
        return self._process.pid

    def start(self) -> None:
        """Start the router and wait until it listens."""
        command = [sys.executable, "-m", "tests.support.routers", self.endpoint, json.dumps(self._more)]
        self._process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=REPOSITORY
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "listening\n", "the router did not start"

    def kill(self) -> None:
        """Kill the router by SIGKILL, if it runs."""
        if self._process is not None:
            self._process.kill()
            self._process.wait(STOP_SECONDS)
            assert self._process.stdout is not None
            self._process.stdout.close()
            self._process = None

    def signal(self, which: signal.Signals) -> None:
        """Send a signal, such as SIGSTOP for a router that runs but does not respond; returns once it has stopped."""
        assert self._process is not None
        self._process.send_signal(which)
        if which == signal.SIGSTOP:
            threads = Path(f"/proc/{self._process.pid}/task")
            wait_for(lambda: all(map(_is_stopped, threads.iterdir())), "the router to stop")


def _is_stopped(thread: Path) -> bool:
    return (thread / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "T"


@contextmanager
def router(more: dict[str, Any] | None = None, protocol: str = "tcp") -> Iterator[Router]:
    """Run a router for the duration of a `with`; `more` are entries of its configuration, by path."""
    own = Router(more, protocol)
    own.start()
    try:
        yield own
    finally:
        own.kill()


def serve(endpoint: str, more: dict[str, Any]) -> None:
    """Run a router until SIGTERM, or until the parent process ends."""
    config = zenoh.Config()
    entries: dict[str, Any] = {
        "mode": "router",
        "listen/endpoints": [endpoint],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        **FAST,
        **more,
    }
    for path, value in entries.items():
        config.insert_json5(path, json.dumps(value))
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with zenoh.open(config):
        print("listening", flush=True)
        while os.getppid() != 1:  # the parent process has ended
            signal.sigtimedwait([signal.SIGINT], 1.0)


if __name__ == "__main__":
    serve(sys.argv[1], json.loads(sys.argv[2]) if len(sys.argv) > 2 else {})
