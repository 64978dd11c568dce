"""Chooses the SQLite library, and protects files from a fault of SQLite that loses committed transactions.

From 3.7.0 to 3.51.2 (but for 3.50.7 and 3.44.6) two connections that write or checkpoint at the same moment in WAL mode
can lose committed transactions: sqlite.org, "Write-Ahead Logging", the WAL-reset bug. `pysqlite3` contains an SQLite
without this bug. Where it is not installed, Python's own SQLite is used; if that has the bug, a second process may not
open the same file.
"""

import importlib
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from sqlalchemy import URL

from voa_store.errors import FileInUse

_FIRST_AFFECTED, _FIRST_FIXED = (3, 7, 0), (3, 51, 3)
_BACKPORTS = ((3, 50, 7), (3, 44, 6))
_SUFFIX = "-in-use"


def sqlite_driver() -> Any:
    """Import the driver of SQLite: `pysqlite3` where it is installed, otherwise Python's own `sqlite3`."""
    bundled = importlib.util.find_spec("pysqlite3") is not None
    return importlib.import_module("pysqlite3" if bundled else "sqlite3")


def loses_commits(version: tuple[int, ...]) -> bool:
    """Return True if an SQLite of this version has the WAL-reset bug.

    Args:
        version: major, minor, patch.
    """
    fixed_branch = any(version[:2] == fixed[:2] and version >= fixed for fixed in _BACKPORTS)
    return _FIRST_AFFECTED <= version < _FIRST_FIXED and not fixed_branch


def version_of(driver: Any) -> tuple[int, ...]:
    """Return the version of the SQLite that a driver is linked with: major, minor, patch."""
    return tuple(int(part) for part in str(driver.sqlite_version).split("."))


def database_file(url: URL) -> Path | None:
    """Return the file of an SQLite URL; None: the database is in memory."""
    name = url.database
    if name is None or name in ("", ":memory:") or ":memory:" in name or url.query.get("mode") == "memory":
        return None
    return Path(name.removeprefix("file:") if url.query.get("uri") else name)


@contextmanager
def alone(file: Path, version: tuple[int, ...]) -> Iterator[None]:
    """Keep a database file from being opened a second time, until the `with` block or this process ends.

    The kernel locks a file beside the database's: a killed process leaves no lock behind.

    Raises:
        FileInUse: the file is open already.
        OSError: the file beside it cannot be created.
    """
    beside = file.with_name(file.name + _SUFFIX)
    with beside.open("ab") as held:
        if not _lock(held):
            raise FileInUse(
                f"{file} is open in another process, and SQLite {'.'.join(map(str, version))} can lose committed "
                "transactions when two processes write at once: end the other process, or install an SQLite without "
                "this fault (pip install pysqlite3), or use PostgreSQL"
            )
        yield


def _lock(file: IO[bytes]) -> bool:
    """Lock a whole file without waiting; False: it is locked already."""
    try:
        if sys.platform == "win32":
            import msvcrt  # noqa: PLC0415 - exists on Windows only

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl  # noqa: PLC0415 - does not exist on Windows

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def main() -> int:
    """Print the version of the SQLite that the store would use; returns 1 if it can lose committed transactions."""
    version = version_of(sqlite_driver())
    affected = loses_commits(version)
    print(f"SQLite {'.'.join(map(str, version))}" + (" can lose commits: pip install pysqlite3" if affected else ""))
    return int(affected)


if __name__ == "__main__":
    sys.exit(main())
