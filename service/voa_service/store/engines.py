"""Connections: how each kind of database is opened."""

from typing import Any, NamedTuple

from sqlalchemy import Connection, Engine, create_engine, event, make_url

_READERS = 8
_CONNECTIONS = 16
_BUSY_MS = 10_000
_WAIT_SECONDS = 30


class Engines(NamedTuple):
    """One engine to write with and one to read with; the same where the database serialises writers by rows."""

    writer: Engine
    readers: Engine

    def dispose(self) -> None:
        """Close every connection."""
        self.readers.dispose()
        self.writer.dispose()


def connect(url: str) -> Engines:
    """Engines for `sqlite:///file` or `postgresql://user@host/database`."""
    if make_url(url).get_backend_name() == "sqlite":
        return Engines(_sqlite(url, "BEGIN IMMEDIATE", connections=1), _sqlite(url, "BEGIN", connections=_READERS))
    # pre_ping: a database that went and came back costs one query, not an error.
    engine = create_engine(url, pool_size=_CONNECTIONS, max_overflow=0, pool_timeout=_WAIT_SECONDS, pool_pre_ping=True)
    return Engines(engine, engine)


def _sqlite(url: str, begin: str, connections: int) -> Engine:
    """WAL and synchronous=FULL: every commit is on the disk before it is answered."""
    engine = create_engine(url, pool_size=connections, max_overflow=0, pool_timeout=_WAIT_SECONDS)

    def prepare(connection: Any, _record: Any) -> None:
        connection.isolation_level = None  # transactions begin where SQLAlchemy says so, below
        for pragma in ("journal_mode=WAL", "synchronous=FULL", f"busy_timeout={_BUSY_MS}", "foreign_keys=ON"):
            connection.execute(f"PRAGMA {pragma}")

    def start(connection: Connection) -> None:
        connection.exec_driver_sql(begin)

    event.listen(engine, "connect", prepare)
    event.listen(engine, "begin", start)
    return engine
