"""Verify every session of a database: `python -m voa_store.verify URL` prints what it found as JSON.

The URL "-" is read from stdin. It reads only, one session at a time, and beside a service that runs. Exit code 0:
nothing is damaged; 1: something is; 2: the database could not be read, and `error` says why.
"""

import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field

from sqlalchemy import Connection, make_url, select

from voa_service.failures import Failure
from voa_service.runtime import logs
from voa_store import checksums
from voa_store.drivers import database_file
from voa_store.engines import Engines, connect, statement, transaction
from voa_store.histories import read_history
from voa_store.migrate import is_current
from voa_store.starting import explain
from voa_store.tables import GONE, sessions

_PAGE_BYTES = 8_000_000
_PAGE_VERSIONS = 1_000
_NOT_CURRENT = "its tables are those of another version of voa: start `voa serve` of this version on it once"


@dataclass(frozen=True)
class Damage:
    """One session that is not as it was written.

    Attributes:
        session: its id.
        version: the first version that is wrong or missing.
        detail: what to do.
    """

    session: str
    version: int
    detail: str


@dataclass
class Verified:
    """Result of verifying a database.

    Attributes:
        database: its software and version.
        sessions: how many were read.
        versions: how many versions of them were right.
        damaged: sessions that are not as they were written.
        pages: what SQLite finds wrong with the structure of its file; empty: nothing.
    """

    database: str = ""
    sessions: int = 0
    versions: int = 0
    damaged: list[Damage] = field(default_factory=list)
    pages: list[str] = field(default_factory=list)

    @property
    def well(self) -> bool:
        """Whether everything is as it was written."""
        return not self.damaged and not self.pages


def verify_all(engines: Engines) -> Verified:
    """Read every version of every session, and compare all checksums.

    Raises:
        Failure: the database cannot be read.
        ValueError: its tables are those of another version.
    """
    with statement(engines.single) as connection:
        if not is_current(connection):
            raise ValueError(_NOT_CURRENT)
        found = Verified(engines.software, pages=list(_wrong_pages(connection)))
        ids = connection.execute(select(sessions.c.id).where(sessions.c.version > GONE).order_by(sessions.c.seq)).all()
    for (id_,) in ids:
        try:
            with transaction(engines.readers) as connection:
                found.versions += _verified_versions(connection, id_)
        except Failure as failure:
            if failure.kind != "damaged":
                raise
            found.damaged.append(Damage(id_, failure.more.get("version", GONE), failure.detail))
        found.sessions += 1
    return found


def _verified_versions(connection: Connection, id_: str) -> int:
    row = connection.execute(select(sessions).where(sessions.c.id == id_, sessions.c.version > GONE)).one_or_none()
    if row is None:  # deleted meanwhile
        return 0
    checksums.check_session(row)
    seen = -1
    while seen < row.version:
        seen = read_history(connection, row, seen, _PAGE_VERSIONS, _PAGE_BYTES)[-1].state.version
    return seen + 1


def _wrong_pages(connection: Connection) -> Iterator[str]:
    if connection.dialect.name == "sqlite":
        for (line,) in connection.exec_driver_sql("PRAGMA quick_check(20)").all():
            if line != "ok":
                yield line


def main(arguments: Sequence[str]) -> int:
    """Verify the database at a URL, print JSON, and return the exit code."""
    logs.configure("CRITICAL")
    (given,) = arguments
    url = sys.stdin.read().strip() if given == "-" else given  # a password is not for the list of processes
    try:
        found = _verify(url)
    except Exception as error:  # whatever it is, it is one line for a person
        line = str(error) if isinstance(error, ValueError) else explain(error, url)
        print(json.dumps({"error": line}))
        return 2
    print(json.dumps(asdict(found)))
    return int(not found.well)


def _verify(url: str) -> Verified:
    file = database_file(make_url(url)) if url.startswith("sqlite") else None
    if file is not None and not file.exists():
        raise ValueError(f"there is no file {file.absolute()}")
    engines = connect(url)
    try:
        return verify_all(engines)
    finally:
        engines.dispose()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
