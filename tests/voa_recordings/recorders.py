"""`voa record` in a process of its own, and what it wrote."""

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

from tests.support.waiting import wait_for
from voa_recordings.files.json_text import json_of
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes


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
    """Topic, name of the type ("" without one), and the message."""
    with path.open("rb") as file:
        return [(c.topic, "" if s is None else s.name, m) for s, c, m in make_reader(file).iter_messages()]


def json_bodies(path: Path, topic: str) -> list[Any]:
    """The JSON on a topic, in order."""
    bodies = [json_of(message) for message in Recording(path, RosTypes()).messages() if message.topic == topic]
    return [json.loads(body) for body in bodies if body is not None]
