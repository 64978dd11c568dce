"""`voa record`: record what robots and the service publish on Zenoh to an MCAP file.

voa record -o look.mcap                                        every session on this machine's router
voa record -o look.mcap --url zenoh://lab:7447/voa/v1/lab7     of another router, with another root of the keys
voa record -o look.mcap --session ID --topic /tb3_1/scan --topic /tb3_1/odom
voa record -o look.mcap --topic '/tb3_1/**'                    all topics of a robot

The file gets raw scans, beliefs and refused scans, the scenario and history of each session that appears, and the ROS 2
topics that are named (from zenoh-bridge-ros2dds and from rmw_zenoh); of latched topics, such as amcl_pose, also the
newest message from before the start. For each version of a session it gets a scene (object at its poses, places, scan,
best grasp), frames and numbers over time, which Foxglove shows. `voa replay` rebuilds the sessions from the file, and
rosbags reads it. Ctrl-C ends the recording; after a power cut, everything up to a second before it is in the file.
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
from typing import IO, get_args

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
from voa_recordings.recorder.drawings import Drawings, Ranked
from voa_recordings.recorder.filing import Filing
from voa_recordings.recorder.histories import Histories
from voa_recordings.recorder.inbox import Inbox
from voa_recordings.recorder.listening import Wanted, listening

DEFAULT_URL = "zenoh://127.0.0.1:7447"
_FLUSH_S = 0.5
_OPEN_MS = 3_000
_CALL_S = 10.0
_RANKING_S = 60.0  # the first ranking of a scenario computes what later ones reuse


class CannotRecord(VoaClientError):
    """The file cannot be written, or a topic is not valid."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Record until Ctrl-C or for --seconds, print a summary, and return 0; 1 after an error."""
    options = _parser().parse_args(arguments)
    console = Console(stderr=True)
    try:
        address = address_of(options.url)
        most = most_beams()
        wanted = _wanted(Keys(address.root), options.session, options.topic)
        with (
            joined(address, _OPEN_MS) as session,
            Client(options.url, timeout_s=_CALL_S) as client,
            Client(options.url, timeout_s=_RANKING_S) as patient,
            _opened(options.out, force=options.force) as file,
            _stopping() as stop,
        ):
            recorder = Recorder(session, (client, patient), file, Keys(address.root), options.rank)
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
    """A running recording: it writes received messages and fetched histories to a file.

    Args:
        session: with the router.
        clients: of the service, for scenarios and histories, and for rankings, which may take longer.
        file: to write; the caller closes it.
        keys: of the service.
        ranked: versions whose places are ranked.
    """

    def __init__(
        self,
        session: zenoh.Session,
        clients: tuple[Client, Client],
        file: IO[bytes],
        keys: Keys,
        ranked: Ranked = "sparingly",
    ) -> None:
        self._session = session
        self._file = file
        self._inbox = Inbox()
        client, patient = clients
        types = RosTypes()
        self._writer = RecordingWriter(file, types)
        self._keys = keys
        self._filing = Filing(self._writer, keys)
        self._drawings = Drawings(patient, self._inbox, types.store, time.time_ns, ranked)
        self._histories = Histories(client, self._inbox, time.time_ns, self._drawings.want)
        self._last: float | None = None

    def record(
        self,
        wanted: Wanted,
        sessions: Sequence[str],
        stop: threading.Event,
        seconds: float | None,
        console: Console,
    ) -> None:
        """Subscribe and write until `stop` is set, or for `seconds`.

        Args:
            wanted: key expressions to subscribe to.
            sessions: ids of sessions whose histories are fetched at once.
            stop: ends the recording.
            seconds: duration; None: until `stop`.
            console: shows the status, if it is a terminal.
        """
        until = None if seconds is None else time.monotonic() + seconds
        self._histories.start()
        self._drawings.start()
        for session in sessions:
            self._histories.want(session)
        with (
            announced(self._session) as bridges,  # first, so that types are known before messages arrive
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
        self._drawings.end()
        while self._take(0.0):
            pass
        self._writer.finish()
        os.fsync(self._file.fileno())

    def report(self, console: Console, path: Path, most_beams: int) -> None:
        """Print the number of messages per topic, and which of them other programs will not be able to read."""
        console.print(status.summary(self._writer.counts))
        console.print(f"{path}: {status.size(path.stat().st_size)}", highlight=False)
        if self._inbox.dropped:
            console.print(
                f"! {self._inbox.dropped} messages arrived faster than they could be written, and are missing"
            )
        for sentence in status.shortcomings(self._filing.unknown, self._filing.beams, most_beams):
            console.print(f"! {sentence}", markup=False, highlight=False, soft_wrap=True)
        for session, why in sorted(self._histories.failed.items()):
            console.print(
                f"! session {session} cannot be rebuilt from the file, because its history is missing: {why}",
                markup=False,
            )
        for sentence in status.not_shown(self._drawings.failed, self._drawings.unranked):
            console.print(f"! {sentence}", markup=False, highlight=False, soft_wrap=True)

    def _take(self, seconds: float) -> bool:
        item = self._inbox.get(seconds)
        if item is None:
            return False
        session = self._filing.file(item)
        if session is not None:
            self._histories.want(session)
        self._last = time.monotonic()
        return True

    def _keep(self) -> None:
        """Write everything so far to the disk, where it survives a power cut."""
        self._writer.flush()
        os.fsync(self._file.fileno())

    def _show(self, live: Status | None) -> None:
        if live is not None:
            quiet = None if self._last is None else time.monotonic() - self._last
            linked = bool(self._session.info.routers_zid())
            counts, written = self._writer.counts, self._writer.size
            text = status.line(counts, written, quiet, self._inbox.dropped, linked=linked)
            live.update(Text(text, no_wrap=True, overflow="ellipsis"))


def _wanted(keys: Keys, sessions: Sequence[str], topics: Sequence[str]) -> Wanted:
    """Make the key expressions to subscribe to: topics as a bridge and as rmw_zenoh write them, wildcards included."""
    own, plain, of_rmw = [], [], []
    for session in sessions or ["*"]:
        own += [keys.scan(session, "*"), keys.belief(session), keys.refused(session, "*")]
    for topic in topics:
        plain.append(topic.strip("/"))
        if "::" not in topic:
            of_rmw.append(f"*/{topic.strip('/')}/*/*")
    try:
        return Wanted(*([str(zenoh.KeyExpr.autocanonize(each)) for each in group] for group in (own, plain, of_rmw)))
    except zenoh.ZError as error:
        raise CannotRecord(f"expected a topic like /tb3_1/scan, or a Zenoh key expression: {error}") from error


@contextmanager
def _opened(path: Path, *, force: bool) -> Iterator[IO[bytes]]:
    try:
        with path.open("wb" if force else "xb") as file:
            yield file
    except FileExistsError as error:
        raise CannotRecord(f"{path} exists already; --force overwrites it") from error
    except OSError as error:
        raise CannotRecord(f"{path}: {error.strerror}") from error


@contextmanager
def _stopping() -> Iterator[threading.Event]:
    """Give an event that SIGINT and SIGTERM set, for the length of a `with`."""
    stop = threading.Event()
    before = {number: signal.signal(number, lambda *_: stop.set()) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _live(console: Console) -> Iterator[Status | None]:
    """Show a status line on a terminal, for the length of a `with`; gives None in a pipe."""
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
    parser.add_argument("--url", default=DEFAULT_URL, help=f"address of the router (default {DEFAULT_URL})")
    parser.add_argument(
        "--session", action="append", default=[], help="record this session only; may be given several times"
    )
    parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="KEYEXPR",
        help="ROS 2 topic to record; may be given several times",
    )
    parser.add_argument(
        "--rank",
        choices=get_args(Ranked),
        default="sparingly",
        help="rank the places of each version, for towers by Value of Assistance in its scene: as far as that keeps "
        "the service busy for at most a tenth of the time (sparingly, the default), always, or never",
    )
    parser.add_argument("--seconds", type=float, help="end after this number of seconds (default: with Ctrl-C)")
    return parser
