"""Which SQLite is linked, and whether two connections can make it lose what was committed.

From 3.7.0 to 3.51.2 (but for 3.50.7 and 3.44.6) two connections that write or checkpoint at the same moment in WAL mode
can lose committed transactions: sqlite.org, "Write-Ahead Logging", the WAL-reset bug. `pysqlite3` brings an SQLite of
its own without that; where it cannot be had, Python's own is taken, and a second process is refused if that has it.
"""

import importlib
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from sqlalchemy import URL

_FIRST_AFFECTED, _FIRST_MENDED = (3, 7, 0), (3, 51, 3)
_BACKPORTS = ((3, 50, 7), (3, 44, 6))
_SUFFIX = "-in-use"


class InUse(Exception):
    """Another process has the file open, and this SQLite must not share it."""


def sqlite_driver() -> Any:
    """Load the module that speaks to SQLite: `pysqlite3` where it is installed, else Python's own."""
    bundled = importlib.util.find_spec("pysqlite3") is not None
    return importlib.import_module("pysqlite3" if bundled else "sqlite3")


def loses_commits(version: tuple[int, ...]) -> bool:
    """Whether an SQLite of that version has the WAL-reset bug.

    Args:
        version: major, minor, patch.
    """
    mended_branch = any(version[:2] == mended[:2] and version >= mended for mended in _BACKPORTS)
    return _FIRST_AFFECTED <= version < _FIRST_MENDED and not mended_branch


def version_of(driver: Any) -> tuple[int, ...]:
    """Read the version of the SQLite that a driver is linked with."""
    return tuple(int(part) for part in str(driver.sqlite_version).split("."))


def database_file(url: URL) -> Path | None:
    """Name the file of an SQLite URL; None: it is in memory."""
    name = url.database
    if name is None or name in ("", ":memory:") or ":memory:" in name or url.query.get("mode") == "memory":
        return None
    return Path(name.removeprefix("file:") if url.query.get("uri") else name)


@contextmanager
def alone(file: Path, version: tuple[int, ...]) -> Iterator[None]:
    """Hold a database file for this opening alone, as long as the `with` or this process lasts.

    The lock is on a file beside it, and the kernel's: a process that is killed leaves none behind.

    Raises:
        InUse: somebody else has it.
        OSError: the file beside it cannot be made.
    """
    beside = file.with_name(file.name + _SUFFIX)
    with beside.open("ab") as held:
        if not _lock(held):
            raise InUse(
                f"{file} is open in another process, and SQLite {'.'.join(map(str, version))} can lose what was "
                "committed when two write at once: end the other process, or install an SQLite without that fault "
                "(pip install pysqlite3), or use PostgreSQL"
            )
        yield


def _lock(file: IO[bytes]) -> bool:
    """Lock a whole file, without waiting; returns False where it is locked."""
    try:
        if sys.platform == "win32":
            import msvcrt  # noqa: PLC0415 - there alone

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl  # noqa: PLC0415 - not on Windows

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def main() -> int:
    """Print the SQLite that the store would take, and return 1 if it can lose what was committed."""
    version = version_of(sqlite_driver())
    affected = loses_commits(version)
    print(f"SQLite {'.'.join(map(str, version))}" + (" can lose commits: pip install pysqlite3" if affected else ""))
    return int(affected)


if __name__ == "__main__":
    sys.exit(main())
