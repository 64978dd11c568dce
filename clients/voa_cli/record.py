"""`voa record`: what robots and the service say on Zenoh, into an MCAP file.

voa record -o look.mcap                                        every session on this machine's router
voa record -o look.mcap --url zenoh://lab:7447/voa/v1/lab7     of another one, under another root
voa record -o look.mcap --session ID --topic /tb3_1/scan --topic /tb3_1/odom
voa record -o look.mcap --topic '/tb3_1/**'                    all topics of a robot

Recorded are raw scans, beliefs and refused scans, of each session that is seen its scenario and history, and the ROS 2
topics that are named (by zenoh-bridge-ros2dds and by rmw_zenoh), with the newest message of latched
ones, such as amcl_pose, from before the recording began. Foxglove opens the file, and `voa replay` makes the sessions
anew from it. Ends with Ctrl-C; what was recorded until a second before a power cut is there.
"""

import argparse
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import zenoh
from rich.console import Console
from rich.status import Status
from rich.text import Text

from voa_cli import recording_status as status
from voa_client import Client, VoaClientError
from voa_client.zenoh_session import address_of, joined
from voa_msgs.keys import Keys
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.files.writer import RecordingWriter
from voa_recordings.limits import most_beams
from voa_recordings.recorder.bridges import announced
from voa_recordings.recorder.filing import Filing
from voa_recordings.recorder.histories import Histories
from voa_recordings.recorder.inbox import Inbox
from voa_recordings.recorder.listening import Wanted, listening

DEFAULT_URL = "zenoh://127.0.0.1:7447"
_FLUSH_S = 0.5
_OPEN_MS = 3_000
_CALL_S = 10.0


class CannotRecord(VoaClientError):
    """There is nowhere to write to, or nothing to listen to."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Record until told to stop, and return 0; 1 if something is wrong."""
    options = _parser().parse_args(arguments)
    console = Console(stderr=True)
    try:
        address = address_of(options.url)
        most = most_beams()
        wanted = _wanted(Keys(address.root), options.session, options.topic)
        with (
            joined(address, _OPEN_MS) as session,
            Client(options.url, timeout_s=_CALL_S) as client,
            _opened(options.out, force=options.force) as file,
            _stopping() as stop,
        ):
            recorder = Recorder(session, client, file, Keys(address.root))
            recorder.record(wanted, options.session, stop, options.seconds, console)
    except VoaClientError as error:
        print(f"voa record: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"voa record: {options.out}: {error.strerror or error}", file=sys.stderr)
        return 1
    recorder.report(Console(), options.out, most)
    return 0


class Recorder:
    """One recording."""

    def __init__(self, session: zenoh.Session, client: Client, file: IO[bytes], keys: Keys) -> None:
        self._session = session
        self._file = file
        self._inbox = Inbox()
        self._writer = RecordingWriter(file, RosTypes())
        self._keys = keys
        self._filing = Filing(self._writer, keys)
        self._histories = Histories(client, self._inbox, time.time_ns)
        self._last: float | None = None

    def record(
        self,
        wanted: Wanted,
        sessions: Sequence[str],
        stop: threading.Event,
        seconds: float | None,
        console: Console,
    ) -> None:
        """Listen and write until `stop`, or for `seconds`."""
        until = None if seconds is None else time.monotonic() + seconds
        self._histories.start()
        for session in sessions:
            self._histories.want(session)
        with (
            announced(self._session) as bridges,  # first: the type of a topic is known before its messages come
            listening(self._session, wanted, self._inbox, time.time_ns),
            _live(console) as live,
        ):
            self._filing = Filing(self._writer, self._keys, bridges.type_of)
            expressions = ", ".join((*wanted.keys, *wanted.topics, *wanted.of_rmw))
            print(f"voa record: listening to {expressions}", file=sys.stderr, flush=True)
            flushed = time.monotonic()
            while not stop.is_set() and (until is None or time.monotonic() < until):
                self._take(0.1)
                if time.monotonic() - flushed >= _FLUSH_S:
                    self._keep()
                    flushed = time.monotonic()
                    self._show(live)
        self._histories.end()
        while self._take(0.0):
            pass
        self._writer.finish()
        os.fsync(self._file.fileno())

    def report(self, console: Console, path: Path, most_beams: int) -> None:
        """Print the topics of the file, and what others will not be able to read of it."""
        console.print(status.summary(self._writer.counts))
        console.print(f"{path}: {status.size(path.stat().st_size)}", highlight=False)
        if self._inbox.dropped:
            console.print(f"! {self._inbox.dropped} messages came faster than they could be written, and are missing")
        for told in status.shortcomings(self._filing.unknown, self._filing.beams, most_beams):
            console.print(f"! {told}", markup=False, highlight=False, soft_wrap=True)
        for session, why in sorted(self._histories.failed.items()):
            console.print(f"! session {session} cannot be made anew, its history is missing: {why}", markup=False)

    def _take(self, seconds: float) -> bool:
        item = self._inbox.get(seconds)
        if item is None:
            return False
        moved = self._filing.file(item)
        if moved is not None:
            self._histories.want(moved)
        self._last = time.monotonic()
        return True

    def _keep(self) -> None:
        """Bring what was written onto the disk: from now on it survives a power cut."""
        self._writer.flush()
        os.fsync(self._file.fileno())

    def _show(self, live: Status | None) -> None:
        if live is not None:
            quiet = None if self._last is None else time.monotonic() - self._last
            linked = bool(self._session.info.routers_zid())
            counts, written = self._writer.counts, self._writer.size
            told = status.line(counts, written, quiet, self._inbox.dropped, linked=linked)
            live.update(Text(told, no_wrap=True, overflow="ellipsis"))


def _wanted(keys: Keys, sessions: Sequence[str], topics: Sequence[str]) -> Wanted:
    """Key expressions to subscribe to: a topic as a bridge writes it, and as rmw_zenoh does, wildcards included."""
    own, plain, of_rmw = [], [], []
    for session in sessions or ["*"]:
        own += [keys.scan(session, "*"), keys.belief(session), keys.refused(session, "*")]
    for topic in topics:
        plain.append(topic.strip("/"))
        if "::" not in topic:
            of_rmw.append(f"*/{topic.strip('/')}/*/*")
    try:
        return Wanted(*([str(zenoh.KeyExpr.autocanonize(each)) for each in found] for found in (own, plain, of_rmw)))
    except zenoh.ZError as error:
        raise CannotRecord(f"expected a topic like /tb3_1/scan, or a Zenoh key expression: {error}") from error


@contextmanager
def _opened(path: Path, *, force: bool) -> Iterator[IO[bytes]]:
    try:
        with path.open("wb" if force else "xb") as file:
            yield file
    except FileExistsError as error:
        raise CannotRecord(f"{path} exists; --force overwrites it") from error
    except OSError as error:
        raise CannotRecord(f"{path}: {error.strerror}") from error


@contextmanager
def _stopping() -> Iterator[threading.Event]:
    """An event that SIGINT and SIGTERM set, for the length of a `with`."""
    stop = threading.Event()
    before = {number: signal.signal(number, lambda *_: stop.set()) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _live(console: Console) -> Iterator[Status | None]:
    """A line that changes, on a terminal; None in a pipe."""
    if not console.is_terminal:
        yield None
        return
    with console.status("recording") as live:
        yield live


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa record", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--out", type=Path, required=True, help="the file to write, FILE.mcap")
    parser.add_argument("--force", action="store_true", help="overwrite the file if it exists")
    parser.add_argument("--url", default=DEFAULT_URL, help=f"of the router (default {DEFAULT_URL})")
    parser.add_argument("--session", action="append", default=[], help="only this session; may be given several times")
    parser.add_argument(
        "--topic", action="append", default=[], metavar="KEYEXPR", help="a ROS 2 topic; may be given several times"
    )
    parser.add_argument("--seconds", type=float, help="end after so many seconds")
    return parser
