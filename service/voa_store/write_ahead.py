"""Detection of commits that SQLite drops silently, because its write-ahead log is damaged.

At the first opening after a crash SQLite reads the log up to the first frame whose checksum is wrong. That is right
where a transaction was being written when the machine stopped. Where a bit of the log was changed on the disk, the
commits after it are dropped too, although they were synced and answered. The two differ: every commit is synced before
the next one begins, so that after an unfinished transaction there is no other.

Format: sqlite.org, "Database File Format", section 4.
"""

import shutil
import struct
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import structlog

_HEADER = struct.Struct(">8I")
_FRAME = struct.Struct(">6I")
_SUFFIX = "-wal-damaged"
_WORD = 2**32 - 1
_BUSY_SECONDS = 10.0


@dataclass(frozen=True)
class _Frame:
    """Frame of a log: its position from 1, whether it ends a transaction, and whether it follows the frame before."""

    number: int
    commits: bool
    follows: bool


def keep_damaged_log(file: Path, driver: Any) -> None:
    """Log an error and keep a copy of the write-ahead log, if its damage makes SQLite drop commits.

    Args:
        file: of the database, before any other connection of this process opens it.
        driver: of SQLite.
    """
    log = file.with_name(file.name + "-wal")
    header = _header(log)
    if not header:
        return
    with closing(driver.connect(str(file), timeout=_BUSY_SECONDS)) as connection:
        read = _frames_read(connection)
        (page_size,) = connection.execute("PRAGMA page_size").fetchone()
        lost = dropped_commits(log, read, page_size) if read >= 0 else 0
        # Otherwise another process has begun the log again, or made commits, meanwhile.
        if lost and header == _header(log) and read == _frames_read(connection):
            _report(log, file.with_name(file.name + _SUFFIX), lost)


def _frames_read(connection: Any) -> int:
    """Return how many frames of the log SQLite has read; recovers the log where no process has done so."""
    _, read, _ = connection.execute("PRAGMA wal_checkpoint(NOOP)").fetchone()
    return int(read)


def _report(log: Path, copy: Path, lost: int) -> None:
    """Log the loss of commits, and copy the log before the connection is closed, which may remove it."""
    structlog.get_logger().error("the database has lost answered writes", writes=lost, why=_why(copy))
    try:
        shutil.copyfile(log, copy)
    except OSError as error:
        copy.unlink(missing_ok=True)
        structlog.get_logger().error("the damaged log could not be copied", file=str(copy), why=str(error))


def damaged_log(file: Path) -> str | None:
    """Describe the loss that `keep_damaged_log` has reported; None: there was none."""
    copy = file.with_name(file.name + _SUFFIX)
    return _why(copy) if copy.is_file() else None


def _why(copy: Path) -> str:
    return (
        f"a bit of the write-ahead log was changed on the disk, and the commits after it are lost: {copy} is a copy of "
        "that log; check the disk, restore a backup where these writes matter, and delete the copy"
    )


def dropped_commits(log: Path, read: int, page_size: int) -> int:
    """Count the synced commits of a log that are missing from the frames that SQLite has read.

    0 where the log is gone.

    Args:
        log: file of the log.
        read: number of frames that SQLite has read.
        page_size: of the database, bytes.

    Returns:
        The least number of commits that were answered. 0: none, or what remains is one transaction that was not
        finished when the machine stopped, or left over from a commit that failed.
    """
    run, most = 0, 0
    try:
        for frame in _frames(log, read, page_size):
            run = run * frame.follows + frame.commits
            most = max(most, run)
    except FileNotFoundError:
        return 0
    return max(0, most - 1)


def _header(log: Path) -> bytes:
    """Read the header of a log; empty where there is no log, or an empty one."""
    try:
        with log.open("rb") as file:
            return file.read(_HEADER.size)
    except FileNotFoundError:
        return b""


def _frames(log: Path, read: int, page_size: int) -> Iterator[_Frame]:
    """Read the frames after the first `read`; the next one is unfinished or wrong, and follows nothing."""
    size = _FRAME.size + page_size
    with log.open("rb") as file:
        header, first = file.read(_HEADER.size), file.read(_FRAME.size)
        if len(first) < _FRAME.size:
            return
        salts = _salts(_HEADER.unpack(header)[4:6], _FRAME.unpack(first)[2:4])
        before, number = (0, 0), read
        file.seek(_HEADER.size + read * size)
        while len(content := file.read(size)) == size:
            number += 1
            _, ends, *own, one, two = _FRAME.unpack(content[: _FRAME.size])
            current = tuple(own) == salts
            follows = current and number > read + 1 and _checksum(before, content) == (one, two)
            yield _Frame(number, current and ends != 0, follows)
            before = one, two


def _salts(header: tuple[int, ...], first: tuple[int, ...]) -> tuple[int, ...]:
    """Return the numbers that mark the frames of the log's present use; a header with a wrong bit has others."""
    bits = sum((one ^ two).bit_count() for one, two in zip(header, first, strict=True))
    return first if bits == 1 else header


def _checksum(before: tuple[int, int], frame: bytes) -> tuple[int, int]:
    """Continue the checksum of a log by a frame: by the first 8 bytes of its header, and its page."""
    content = frame[:8] + frame[_FRAME.size :]
    first, second = before
    # SQLite sums up in the byte order of the machine that wrote the log.
    words = struct.unpack(f"={len(content) // 4}I", content)
    for even, odd in zip(words[::2], words[1::2], strict=True):
        first = (first + even + second) & _WORD
        second = (second + odd + first) & _WORD
    return first, second
