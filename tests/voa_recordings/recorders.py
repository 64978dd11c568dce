"""`voa record` in a process of its own, and what it wrote."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

from tests.support.waiting import wait_for


class Recorder:
    """`voa record` in a process of its own."""

    def __init__(self, path: Path, *options: str) -> None:
        self.path = path
        self._said = path.with_suffix(".err")
        self._printed = path.with_suffix(".out")
        command = [sys.executable, "-m", "voa_cli.main", "record", "-o", str(path), *options]
        with self._said.open("wb") as stderr, self._printed.open("wb") as stdout:
            self.process = subprocess.Popen(command, stdout=stdout, stderr=stderr)

    def wait_until_it_listens(self) -> None:
        """Fails with what it said."""

        def listens() -> bool:
            said = self._said.read_text()
            assert self.process.poll() is None, said
            return "listening to" in said

        wait_for(listens, "the recorder listens")

    def stop(self, number: signal.Signals) -> str:
        """Stop it, and return its report."""
        self.process.send_signal(number)
        assert self.process.wait(30) == 0, self._said.read_text()
        assert self._said.read_text().count("\n") == 1
        return self._printed.read_text()


@contextmanager
def recording(path: Path, *options: str) -> Iterator[Recorder]:
    own = Recorder(path, *options)
    try:
        own.wait_until_it_listens()
        yield own
    finally:
        own.process.kill()
        own.process.wait()


def messages(path: Path) -> list[tuple[str, str, Any]]:
    """Topic, encoding and data."""
    with path.open("rb") as file:
        return [(c.topic, c.message_encoding, m) for _, c, m in make_reader(file).iter_messages()]
