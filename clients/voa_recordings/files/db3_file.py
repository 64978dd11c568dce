"""SQLite files of rosbag2, read by SQLite itself: whole, or up to where they are damaged.

A file is never opened for writing, and no file is created beside it. A file with a write-ahead log (`bag_0.db3-wal`) or
a journal (`-journal`) is read from a copy in a temporary folder, because SQLite has to write there to use them; so is a
file that ends within a page, without that page. The temporary folder needs room for the copy (TMPDIR names another
folder).

Reading takes 8 bytes of memory per message: its row number, in the order of the log times.
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
_GAP = 10_000  # row numbers after the last readable one that are tried one by one

_Topic = tuple[str, str, str]
"""Name, type and encoding."""


class Db3File:
    """Reader of an SQLite file of rosbag2.

    Attributes:
        topics: name to type, of all topics.
    """

    def __init__(self, path: Path, stack: ExitStack) -> None:
        """Prepare to read `path`; the connection and copies are closed and removed with `stack`."""
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
        """Damage of the file that was noticed so far, as predicates ("ends in the middle")."""
        damage = [f"was left with {log}: its recorder did not end in order" for log in self._logs]
        if self._is_cut:
            damage.append("ends in the middle")
        elif self._why is not None:
            damage.append(f"is damaged ({self._why})")
        return damage + ([f"has {self._lost} messages that cannot be read"] if self._lost else [])

    def scan(self) -> int | None:
        """Find all messages, and return the smallest log time in nanoseconds; None: there is no message.

        Raises:
            UnreadableRecording: the file is no recording of rosbag2, or its topics cannot be read.
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
            salvaged = sorted(_salvaged(self._database))
            self._rows = array("q", (row for _, row in salvaged))
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
        path = self._path.resolve()  # a link's target has its log beside it
        beside = [path.with_name(path.name + ending) for ending in SIDECARS]
        logs = [log for log in beside if log.is_file() and log.stat().st_size]
        self._logs = [log.name for log in logs]
        try:
            shape = _Shape.of(path)
            self._is_cut = shape.missing_bytes > 0 and not logs
            if not logs and not shape.torn_bytes:
                address = f"file:{quote(str(path))}?immutable=1"  # without it, SQLite creates a file beside it
            else:
                copy = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="voa-"))) / path.name
                for file in (path, *logs):
                    shutil.copyfile(file, copy.with_name(file.name))
                os.truncate(copy, shape.bytes - shape.torn_bytes)  # or SQLite fills the last page with zeros
                address = f"file:{quote(str(copy))}"
            database = sqlite3.connect(address, uri=True)
        except (OSError, sqlite3.Error) as error:
            where = f" from a copy in {tempfile.gettempdir()}" if logs or self._is_cut else ""
            raise UnreadableRecording(f"{self._path} cannot be opened{where}: {error}") from error
        database.text_factory = _text
        # Without this, SQLite refuses a file that is shorter than its header says, though the rest can be read.
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
            except sqlite3.Error as error:  # messages can be read without definitions, as in files of older releases
                self._why = str(error)

    def _define(self) -> None:
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        self._definitions = {row[0]: (row[1], row[2]) for row in self._database.execute(query)}

    def _message(self, row: int) -> RecordedMessage | None:
        """Read one message; None: it cannot be read."""
        query = "SELECT topic_id, timestamp, data FROM messages WHERE rowid = ?"
        try:
            fields = self._database.execute(query, (row,)).fetchone()
        except sqlite3.Error as error:
            self._why = self._why or str(error)
            return None
        topic, log_ns, data = (None, None, None) if fields is None else fields
        if topic not in self._topics or not isinstance(log_ns, int) or not isinstance(data, bytes):
            return None
        name, type_name, encoding = self._topics[topic]
        schema = self._definitions.get(type_name, ("", ""))
        return RecordedMessage(name, type_name, encoding, log_ns, data, schema)


class _Shape(NamedTuple):
    """The length of a database by its file and by its header.

    Attributes:
        bytes: length of the file.
        torn_bytes: bytes after the last whole page.
        missing_bytes: bytes of pages that the header counts and the file lacks; 0 if the header has no count.
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
    """Find log time and row number of the messages of a damaged file, before and after its unreadable part."""
    message: tuple[int, int] | None = (0, 0)
    while message is not None:
        after = message[1]
        try:
            rows = "SELECT timestamp, rowid FROM messages NOT INDEXED WHERE rowid > ? ORDER BY rowid"
            for stamp, row in database.execute(rows, (after,)):
                if row <= after or not isinstance(stamp, int):  # the page's end is missing
                    raise sqlite3.DatabaseError("expected rows in order")
                after = row
                yield stamp, row
        except sqlite3.Error:
            message = _next_readable(database, after)
            if message is not None:
                yield message
        else:
            return


def _next_readable(database: sqlite3.Connection, after: int) -> tuple[int, int] | None:
    """Find log time and row number of the next readable message; None: none within 10 000 rows."""
    for row in range(after + 1, after + _GAP):
        try:
            fields = database.execute("SELECT timestamp FROM messages WHERE rowid = ?", (row,)).fetchone()
        except sqlite3.Error:
            continue
        if fields is not None and isinstance(fields[0], int):
            return fields[0], row
    return None


def _text(data: bytes) -> str:
    return data.decode(errors="replace")
