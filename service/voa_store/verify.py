"""Verifies every session and object of a database: `python -m voa_store.verify URL` prints the result as JSON.

With "-" the URL is read from stdin. The program only reads, one session at a time, and may run beside the service. Exit
code 0: nothing is damaged; 1: sessions, objects or pages are damaged; 2: the database cannot be read, and `error` says
why.
"""

import json
import logging
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field

import structlog
from sqlalchemy import Connection, func, make_url, select

from voa_store import checksums
from voa_store.drivers import database_file
from voa_store.engines import Engines, connect, statement, transaction
from voa_store.errors import DamagedData
from voa_store.histories import read_history
from voa_store.revisions import is_current
from voa_store.rows import object_of
from voa_store.starting import explain
from voa_store.tables import GONE, history, objects, sessions
from voa_store.write_ahead import damaged_log

_PAGE_BYTES = 8_000_000
_PAGE_VERSIONS = 1_000
_NOT_CURRENT = "the database has tables of another version of voa: start `voa serve` of this version on it once"


@dataclass(frozen=True)
class Damage:
    """Damage of a session.

    Attributes:
        session: its id.
        version: the first version that is damaged or missing; -1: it is not known.
        detail: explanation, and what to do.
    """

    session: str
    version: int
    detail: str


@dataclass
class Verified:
    """Result of verifying a database.

    Attributes:
        database: name and version of the database's software.
        sessions: number of sessions that were read.
        versions: number of undamaged versions of these sessions.
        damaged: sessions that differ from what was written.
        pages: faults that SQLite reports in the structure of its file, and answered writes that it has lost.
        objects: ids of meshes whose vertices and faces do not have the digest that names them.
    """

    database: str = ""
    sessions: int = 0
    versions: int = 0
    damaged: list[Damage] = field(default_factory=list)
    pages: list[str] = field(default_factory=list)
    objects: list[str] = field(default_factory=list)

    @property
    def well(self) -> bool:
        """True if nothing is damaged."""
        return not (self.damaged or self.pages or self.objects)


def verify_all(engines: Engines) -> Verified:
    """Read every version of every session, and every object, and compare all checksums and digests.

    Raises:
        StoreError: the database cannot be read.
        ValueError: its tables are those of another version of the service.
    """
    with statement(engines.single) as connection:
        if not is_current(connection):
            raise ValueError(_NOT_CURRENT)
        verified = Verified(engines.software, pages=list(_wrong_pages(connection)))
        ids = connection.execute(select(sessions.c.id).where(sessions.c.version > GONE).order_by(sessions.c.seq)).all()
    for (id_,) in ids:
        try:
            with transaction(engines.readers) as connection:
                verified.versions += _verified_versions(connection, id_)
        except DamagedData as error:
            verified.damaged.append(Damage(id_, GONE if error.version is None else error.version, str(error)))
        verified.sessions += 1
    verified.objects += _damaged_objects(engines)
    return verified


def _damaged_objects(engines: Engines) -> Iterator[str]:
    with statement(engines.single) as connection:
        ids = connection.execute(select(objects.c.id).order_by(objects.c.seq)).scalars().all()
    for id_ in ids:
        with statement(engines.single) as connection:
            row = connection.execute(select(objects).where(objects.c.id == id_)).one_or_none()
        try:
            if row is not None:  # otherwise it was deleted meanwhile
                object_of(row)
        except DamagedData:
            yield id_


def _verified_versions(connection: Connection, id_: str) -> int:
    row = connection.execute(select(sessions).where(sessions.c.id == id_, sessions.c.version > GONE)).one_or_none()
    if row is None:  # the session was deleted meanwhile
        return 0
    checksums.check_session(row)
    seen = -1
    while seen < row.version:
        seen = read_history(connection, row, seen, _PAGE_VERSIONS, _PAGE_BYTES)[-1].state.version
    newest = select(func.max(history.c.version)).where(history.c.session == id_)
    if connection.execute(newest).scalar_one() > row.version:  # the disk has kept an older row of the session
        raise checksums.damaged(id_, row.version + 1)
    return seen + 1


def _wrong_pages(connection: Connection) -> Iterator[str]:
    if connection.dialect.name == "sqlite":
        for (line,) in connection.exec_driver_sql("PRAGMA integrity_check(20)").all():
            if line != "ok":
                yield line
        file = database_file(connection.engine.url)
        lost = None if file is None else damaged_log(file)
        if lost is not None:
            yield lost


def main(arguments: Sequence[str]) -> int:
    """Verify the database at a URL, print JSON, and return the exit code."""
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))
    (argument,) = arguments
    # Standard input keeps a password out of the list of processes.
    url = sys.stdin.read().strip() if argument == "-" else argument
    try:
        verified = _verify(url)
    except Exception as error:  # a person reads one line, whatever went wrong
        line = str(error) if isinstance(error, ValueError) else explain(error, url)
        print(json.dumps({"error": line}))
        return 2
    print(json.dumps(asdict(verified)))
    return int(not verified.well)


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
