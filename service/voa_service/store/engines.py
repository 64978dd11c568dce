"""Connections: how each kind of database is opened."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import structlog
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import DataError, DBAPIError, IntegrityError, NotSupportedError, ProgrammingError
from sqlalchemy.exc import TimeoutError as NoConnection
from sqlalchemy.sql.compiler import SQLCompiler

from voa_service.failures import NOT_READY, OVERLOADED, Failure

_READERS = 8
_CONNECTIONS = 16
_BUSY_MS = 10_000
_WAIT_SECONDS = 30
_CONNECT_SECONDS = 5
_TRY_AGAIN = {"Retry-After": "1"}
_OURS = (IntegrityError, ProgrammingError, DataError, NotSupportedError)
"""What a statement of ours did; every other error of a database is that of the database."""


class Engines(NamedTuple):
    """An engine to write with, one to read with, and one for reads of a single statement.

    The first two are the same where the database serialises writers by rows. The last needs no transaction: of what a
    read costs, beginning and ending one is the larger part.
    """

    writer: Engine
    readers: Engine
    single: Engine

    def dispose(self) -> None:
        """Close every connection."""
        self.single.dispose()
        self.readers.dispose()
        self.writer.dispose()


@contextmanager
def transaction(engine: Engine) -> Iterator[Connection]:
    """One transaction, committed on leaving.

    Raises:
        Failure: see `_told`. Where the connection broke during the commit nobody knows if it happened: hence the
            idempotency keys.
    """
    with _told(engine), engine.begin() as connection:
        yield connection


@contextmanager
def statement(engine: Engine) -> Iterator[Connection]:
    """For one statement that reads; raises as `transaction`."""
    with _told(engine), engine.connect() as connection:
        yield connection


def first(engine: Engine, query: SQLCompiler, name: str, value: str) -> tuple[Any, ...] | None:
    """The first row of a query with one parameter, None if there is none; raises as `transaction`.

    By the driver itself: for the smallest question, which is asked most often, SQLAlchemy takes three quarters of the
    time. `query` is compiled for the engine; `name` is that of its parameter.
    """
    with _told(engine):
        connection = engine.raw_connection()
        try:
            cursor = connection.cursor()
            cursor.execute(str(query), (value,) if query.positional else {name: value})
            row: tuple[Any, ...] | None = cursor.fetchone()
        finally:
            connection.close()
    return row


@contextmanager
def _told(engine: Engine) -> Iterator[None]:
    """What a database does wrong, as a failure.

    Raises:
        Failure: the database is gone, full, locked or broken: not the caller's fault, and it may pass.
    """
    try:
        yield
    except _OURS:
        raise
    except (DBAPIError, engine.dialect.loaded_dbapi.Error) as error:
        cause = error.orig if isinstance(error, DBAPIError) else error
        structlog.get_logger().error("the database failed", error=f"{type(cause).__name__}: {cause}")
        detail = "the database does not work at the moment: try again, writes with the same Idempotency-Key"
        raise Failure(NOT_READY, detail, _TRY_AGAIN) from error
    except NoConnection as error:
        structlog.get_logger().error("the database is too slow", waited_seconds=_WAIT_SECONDS)
        raise Failure(OVERLOADED, "too many requests wait for the database: try again", _TRY_AGAIN) from error


def connect(url: str) -> Engines:
    """Engines for `sqlite:///file` or `postgresql://user@host/database`."""
    if make_url(url).get_backend_name() == "sqlite":
        return Engines(
            _sqlite(url, "BEGIN IMMEDIATE", connections=1),
            _sqlite(url, "BEGIN", connections=_READERS),
            _sqlite(url, None, connections=_READERS),
        )
    engine = create_engine(
        url,
        pool_size=_CONNECTIONS,
        max_overflow=0,
        pool_timeout=_WAIT_SECONDS,
        pool_pre_ping=True,  # a database that went and came back costs one query, not an error
        connect_args=_patience(make_url(url)),
    )
    return Engines(engine, engine, engine.execution_options(isolation_level="AUTOCOMMIT"))


def _patience(url: URL) -> dict[str, Any]:
    """How long PostgreSQL is waited for; what the URL says itself holds."""
    usual: dict[str, Any] = {
        "connect_timeout": _CONNECT_SECONDS,
        "keepalives_idle": 10,
        "keepalives_interval": 5,
        "keepalives_count": 3,
    }
    # A row that somebody holds, who may be frozen, must not hold up every worker for good.
    options = f"-c lock_timeout={_BUSY_MS} -c idle_in_transaction_session_timeout={_BUSY_MS}"
    own = url.query.get("options", "")
    return usual | dict(url.query) | {"options": f"{options} {own if isinstance(own, str) else ' '.join(own)}".strip()}


def _sqlite(url: str, begin: str | None, connections: int) -> Engine:
    """WAL and synchronous=FULL: every commit is on the disk before it is answered."""
    engine = create_engine(url, pool_size=connections, max_overflow=0, pool_timeout=_WAIT_SECONDS)

    def prepare(connection: Any, _record: Any) -> None:
        connection.isolation_level = None  # transactions begin where SQLAlchemy says so, below
        for pragma in ("journal_mode=WAL", "synchronous=FULL", f"busy_timeout={_BUSY_MS}", "foreign_keys=ON"):
            connection.execute(f"PRAGMA {pragma}")

    event.listen(engine, "connect", prepare)
    if begin is not None:
        event.listen(engine, "begin", lambda connection: connection.exec_driver_sql(begin))
    return engine
