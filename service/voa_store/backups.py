"""Backs up an SQLite database while the service runs, and restores a backup; both verify every session.

PostgreSQL has its own tools: `pg_dump` and `pg_restore` (deploy/docs/operations.md).
"""

import os
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from sqlalchemy import make_url

from voa_store.carrying import CarriedKeys, carry_keys
from voa_store.drivers import database_file, sqlite_driver
from voa_store.engines import connect, statement
from voa_store.migrate import migrate
from voa_store.revisions import is_current
from voa_store.verify import Verified, verify_all

_PART = ".part"
_MIGRATED = ".migrated"
_BEFORE = ".before-restore"


class CannotBackUp(Exception):
    """A backup cannot be made or restored; the text is one line that says why, and what to do."""


@dataclass(frozen=True)
class BackedUp:
    """Backup that was written.

    Attributes:
        file: of the backup.
        size: bytes.
        verified: result of reading every session of the backup.
    """

    file: Path
    size: int
    verified: Verified


@dataclass(frozen=True)
class Restored:
    """Database that was restored.

    Attributes:
        file: of the database.
        kept: file to which the database from before was moved; None: there was none.
        verified: result of reading every session of the restored database.
        keys: API keys of the restored database: those of the backup and of the database from before.
    """

    file: Path
    kept: Path | None
    verified: Verified
    keys: CarriedKeys


def back_up(url: str, file: Path, *, replace: bool = False) -> BackedUp:
    """Copy an SQLite database to a file by SQLite's online backup, and verify the copy.

    The service may write meanwhile: the copy is the state at the moment when the backup began. The file appears under
    its name only when it is complete and on the disk. Its tables are those of the database: the version that wrote a
    database can restore a backup that a newer one made before it migrated that.

    Args:
        url: of the database.
        file: of the backup.
        replace: True: a file of that name is replaced.

    Raises:
        CannotBackUp: the database is not one SQLite file, or a file cannot be read or written.
        StoreError: the copy cannot be read.
        ValueError: the tables are those of another version of the service.
    """
    database = _file_of(url)
    if file.resolve() in (database.resolve(), *_beside(database.resolve())):
        raise CannotBackUp(f"{file} is the database itself, or a file of it: name another file")
    if file.exists() and not replace:
        raise CannotBackUp(f"{file} exists: name another file, or add --replace")
    part = file.with_name(file.name + _PART)
    try:
        _copy(database, part)
        verified = _verified_as_it_is(part)
        _sync(part)
        part.replace(file)
        _sync(file.parent)
    except OSError as error:
        raise CannotBackUp(f"{file} cannot be written: {error.strerror or error}") from error
    finally:
        _remove(part)
    return BackedUp(file, file.stat().st_size, verified)


def restore(file: Path, url: str, *, even_if_damaged: bool = False) -> Restored:
    """Put a backup in the place of an SQLite database, which no process may have open.

    A backup of an earlier version of the service is migrated. The database from before is kept beside it, and its API
    keys and their revocations are carried over: no key that was revoked becomes valid again.

    Args:
        file: of the backup.
        url: of the database.
        even_if_damaged: True: a backup with damaged sessions is restored; the others can then be used.

    Raises:
        CannotBackUp: the backup is damaged or is no database, the database is in use, or a file cannot be written.
        StoreError: the backup cannot be read.
    """
    database = _file_of(url, must_exist=False).resolve()
    if file.resolve() == database:
        raise CannotBackUp(f"{file} is the database itself: name a backup")
    if not file.is_file():
        raise CannotBackUp(f"there is no file {file}")
    part = database.with_name(database.name + _PART)
    try:
        _copy(file, part)
        verified = _verified(part)
        if not verified.well and not even_if_damaged:
            raise CannotBackUp(
                f"{file} has {len(verified.damaged)} damaged sessions and {len(verified.pages)} damaged pages: restore "
                "another backup, or add --even-if-damaged to keep what can still be read"
            )
        kept = _kept(database)
        keys = carry_keys(kept, part)
        _sync(part)
        _clear_beside(database, kept)
        part.replace(database)
        _sync(database.parent)
    except OSError as error:
        raise CannotBackUp(f"{database} cannot be written: {error.strerror or error}") from error
    finally:
        _remove(part)
    return Restored(database, kept, verified, keys)


def _file_of(url: str, *, must_exist: bool = True) -> Path:
    parsed = make_url(url)
    if parsed.get_backend_name() != "sqlite":
        raise CannotBackUp(
            "a PostgreSQL database is backed up by its own tools: pg_dump --format=custom --file=FILE URL, and "
            "restored by pg_restore without the table of keys, as deploy/docs/operations.md says"
        )
    file = database_file(parsed)
    if file is None:
        raise CannotBackUp("expected a database in a file, got one in memory")
    if must_exist and not file.is_file():
        raise CannotBackUp(f"there is no database {file.absolute()}: name it with --database-url")
    return file


def _copy(source: Path, target: Path) -> None:
    """Copy a database by SQLite's online backup, without the space of removed rows.

    The source is opened read-only: that connection neither writes nor checkpoints it.
    """
    _remove(target)
    driver = sqlite_driver()
    address = f"file:{quote(str(source.absolute()))}?mode=ro"
    try:
        with closing(driver.connect(address, uri=True)) as reading, closing(driver.connect(str(target))) as writing:
            reading.backup(writing)
            writing.execute("PRAGMA journal_mode=DELETE")
            writing.execute("PRAGMA auto_vacuum=INCREMENTAL")
            writing.execute("VACUUM")
    except driver.Error as error:
        raise CannotBackUp(f"{source} cannot be copied to {target.parent}: {error}") from error


def _verified_as_it_is(file: Path) -> Verified:
    """Read every session of a copy without migrating it; one of an earlier version is read in a copy of its own."""
    engines = connect(f"sqlite:///{file}")
    try:
        with statement(engines.single) as connection:
            current = is_current(connection)
    finally:
        engines.dispose()
    if current:
        return _verified(file)
    other = file.with_name(file.name + _MIGRATED)
    try:
        _copy(file, other)
        return _verified(other)
    finally:
        _remove(other)


def _verified(file: Path) -> Verified:
    """Migrate a copy where its tables are of an earlier version, and read every session."""
    engines = connect(f"sqlite:///{file}")
    try:
        migrate(engines)
        return verify_all(engines)
    finally:
        engines.dispose()


def _kept(database: Path) -> Path | None:
    """Give a database a second name, under which it stays when it is replaced; None: there is no database.

    Raises:
        CannotBackUp: a process has it open.
    """
    if not database.exists():
        return None
    driver: Any = sqlite_driver()
    try:
        with closing(driver.connect(str(database), timeout=1.0)) as connection:
            # SQLite leaves WAL mode only for the last connection, and moves what is in the -wal file into the database.
            mode = connection.execute("PRAGMA journal_mode=DELETE").fetchone()[0]
    except driver.OperationalError as error:
        raise CannotBackUp(f"{database} is in use ({error}): stop the service, and restore again") from error
    except driver.DatabaseError:  # it is too damaged to be opened, so no service has it open
        mode = "delete"
    if mode != "delete":
        raise CannotBackUp(f"{database} is in use: stop the service, and restore again")
    kept = _unused(database)
    os.link(database, kept)
    return kept


def _unused(database: Path) -> Path:
    number = 1
    while (kept := database.with_name(f"{database.name}{_BEFORE}-{number}")).exists():
        number += 1
    return kept


def _beside(database: Path) -> list[Path]:
    """Files that SQLite and the store keep beside a database."""
    return [database.with_name(database.name + suffix) for suffix in ("-wal", "-shm", "-journal", "-in-use", _PART)]


def _clear_beside(database: Path, kept: Path | None) -> None:
    """Take away the files that were left beside a database, or SQLite would apply them to the one that replaces it.

    They stay with the database that is kept.
    """
    for suffix in ("-wal", "-shm", "-journal"):
        file = database.with_name(database.name + suffix)
        if kept is not None and file.exists():
            file.rename(kept.with_name(kept.name + suffix))
        else:
            file.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    """Wait until a file or a folder is on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _remove(file: Path) -> None:
    """Remove a database, with the files that SQLite and the store keep beside it."""
    for suffix in ("", "-wal", "-shm", "-journal", "-in-use"):
        file.with_name(file.name + suffix).unlink(missing_ok=True)
