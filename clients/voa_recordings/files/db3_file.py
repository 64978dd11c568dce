"""SQLite files of rosbag2, read by SQLite itself: whole, or as far as they go.

A file is never opened for writing, and nothing is made beside it. What its recorder had not yet carried over from the
write-ahead log (`bag_0.db3-wal`) or had begun to change (`-journal`) is read from a copy in a temporary folder, since
SQLite has to write there to do so; likewise a file that ends within a page, without that page. The folder needs room
for it (TMPDIR names another).

In memory are 8 bytes per message: its number, in the order of the log times.
"""

import os
import shutil
import sqlite3
import tempfile
from array import array
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from voa_recordings.files.message import RecordedMessage, UnreadableRecording

SIDECARS = ("-wal", "-journal")
_GAP = 10_000  # so many row numbers after one that can be read are tried one by one

_Topic = tuple[str, str, str]
"""Name, type and encoding."""


class Db3File:
    """Reads one file.

    Attributes:
        topics: name to type, of all topics.
    """

    def __init__(self, path: Path, stack: ExitStack) -> None:
        """Prepare to read `path`; what is opened and copied lasts as long as `stack`."""
        self.topics: dict[str, str] = {}
        self._path = path
        self._stack = stack
        self._topics: dict[int, _Topic] = {}
        self._definitions: dict[str, tuple[str, str]] = {}
        self._rows = array("q")
        self._why: str | None = None
        self._lost = 0
        self._logs: list[str] = []
        self._is_cut = False

    @property
    def damage(self) -> list[str]:
        """Predicates of the file, so far as it has been read."""
        found = [f"was left with {log}: its recorder did not end in order" for log in self._logs]
        if self._is_cut:
            found.append("ends in the middle")
        elif self._why is not None:
            found.append(f"is damaged ({self._why})")
        return found + ([f"has {self._lost} messages that cannot be read"] if self._lost else [])

    def scan(self) -> int | None:
        """Find all messages; the smallest log time, None: no message.

        Raises:
            UnreadableRecording: it is no recording of rosbag2, or its topics cannot be read.
        """
        self._database = self._stack.enter_context(closing(self._opened()))
        try:
            self._describe()
        except sqlite3.Error as error:
            raise UnreadableRecording(f"{self._path} cannot be read as a recording of rosbag2: {error}") from error
        try:
            in_order = "SELECT rowid FROM messages NOT INDEXED ORDER BY timestamp, rowid"
            self._rows.extend(row for (row,) in self._database.execute(in_order))
        except sqlite3.Error as error:
            self._why = str(error)
            found = sorted(_salvaged(self._database))
            self._rows = array("q", (row for _, row in found))
        for row in self._rows:
            message = self._message(row)
            if message is not None:
                return message.log_ns
        return None

    def messages(self) -> Iterator[RecordedMessage]:
        """Give every message that can be read, by log time; equal times in the order of the file."""
        self._lost = 0
        for row in self._rows:
            message = self._message(row)
            if message is None:
                self._lost += 1
            else:
                yield message

    def _opened(self) -> sqlite3.Connection:
        path = self._path.resolve()  # the log of a link's target is beside the target
        beside = [path.with_name(path.name + ending) for ending in SIDECARS]
        logs = [log for log in beside if log.is_file() and log.stat().st_size]
        self._logs = [log.name for log in logs]
        try:
            shape = _Shape.of(path)
            self._is_cut = shape.missing_bytes > 0 and not logs
            if not logs and not shape.torn_bytes:
                address = f"file:{quote(str(path))}?immutable=1"  # else SQLite would make a file beside it
            else:
                copy = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="voa-"))) / path.name
                for file in (path, *logs):
                    shutil.copyfile(file, copy.with_name(file.name))
                os.truncate(copy, shape.bytes - shape.torn_bytes)  # else SQLite fills the last page up with zeros
                address = f"file:{quote(str(copy))}"
            database = sqlite3.connect(address, uri=True)
        except (OSError, sqlite3.Error) as error:
            where = f" from a copy in {tempfile.gettempdir()}" if logs or self._is_cut else ""
            raise UnreadableRecording(f"{self._path} cannot be opened{where}: {error}") from error
        database.text_factory = _text
        # A file that is shorter than it says is refused otherwise, although the rest of it can be read.
        database.execute("PRAGMA writable_schema=ON")
        return database

    def _describe(self) -> None:
        tables = {name for (name,) in self._database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        if not {"topics", "messages"} <= tables:
            raise sqlite3.DatabaseError(f"expected tables named topics and messages, found {sorted(tables) or 'none'}")
        topics = self._database.execute("SELECT id, name, type, serialization_format FROM topics")
        self._topics = {row[0]: (row[1], row[2], row[3]) for row in topics}
        self.topics = {name: type_name for name, type_name, _ in self._topics.values()}
        if "message_definitions" in tables:
            try:
                self._define()
            except sqlite3.Error as error:  # messages are read without, as those of older releases
                self._why = str(error)

    def _define(self) -> None:
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        self._definitions = {row[0]: (row[1], row[2]) for row in self._database.execute(query)}

    def _message(self, row: int) -> RecordedMessage | None:
        """Read one message; None: it cannot be read."""
        query = "SELECT topic_id, timestamp, data FROM messages WHERE rowid = ?"
        try:
            found = self._database.execute(query, (row,)).fetchone()
        except sqlite3.Error as error:
            self._why = self._why or str(error)
            return None
        if found is None or found[0] not in self._topics or not isinstance(found[1], int):
            return None
        if not isinstance(found[2], bytes):
            return None
        name, type_name, encoding = self._topics[found[0]]
        schema = self._definitions.get(type_name, ("", ""))
        return RecordedMessage(name, type_name, encoding, found[1], found[2], schema)


class _Shape(NamedTuple):
    """How long a database is, by its file and by its header.

    Attributes:
        bytes: of the file.
        torn_bytes: after the last whole page.
        missing_bytes: of the pages that the header counts; 0 where it does not say.
    """

    bytes: int
    torn_bytes: int
    missing_bytes: int

    @classmethod
    def of(cls, path: Path) -> "_Shape":
        """Read the header; raises OSError."""
        size = path.stat().st_size
        with path.open("rb") as file:
            header = file.read(100)
        if len(header) < 100:
            return cls(size, 0, 0)
        page = 65_536 if header[16:18] == b"\0\1" else max(int.from_bytes(header[16:18], "big"), 512)
        is_counted = header[24:28] == header[92:96]
        pages = int.from_bytes(header[28:32], "big") if is_counted else 0
        return cls(size, size % page, max(pages * page - size, size % page))


def _salvaged(database: sqlite3.Connection) -> Iterator[tuple[int, int]]:
    """Find log time and number of the messages of a damaged file, on both sides of what cannot be read."""
    found: tuple[int, int] | None = (0, 0)
    while found is not None:
        after = found[1]
        try:
            rows = "SELECT timestamp, rowid FROM messages NOT INDEXED WHERE rowid > ? ORDER BY rowid"
            for stamp, row in database.execute(rows, (after,)):
                if row <= after or not isinstance(stamp, int):  # of a page of which the end is missing
                    raise sqlite3.DatabaseError("expected rows in order")
                after = row
                yield stamp, row
        except sqlite3.Error:
            found = _next_readable(database, after)
            if found is not None:
                yield found
        else:
            return


def _next_readable(database: sqlite3.Connection, after: int) -> tuple[int, int] | None:
    """Find the next message after a damage that can be read; None: there is none nearby."""
    for row in range(after + 1, after + _GAP):
        try:
            found = database.execute("SELECT timestamp FROM messages WHERE rowid = ?", (row,)).fetchone()
        except sqlite3.Error:
            continue
        if found is not None and isinstance(found[0], int):
            return found[0], row
    return None


def _text(data: bytes) -> str:
    return data.decode(errors="replace")
