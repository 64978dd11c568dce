"""Connections: how each kind of database is opened."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import structlog
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import DataError, DBAPIError, IntegrityError, NotSupportedError, ProgrammingError
from sqlalchemy.exc import TimeoutError as NoConnection
from sqlalchemy.sql.compiler import SQLCompiler

from voa_service.failures import Damaged, NotReady, Overloaded
from voa_store import patience
from voa_store.drivers import alone, database_file, loses_commits, sqlite_driver, version_of

_READERS = 8
_CONNECTIONS = 16
_BUSY_MS = 10_000
_SWITCH_AGAIN_SECONDS = 0.01
_WAIT_SECONDS = 10
_TRY_AGAIN = {"Retry-After": "1"}
_OURS = (IntegrityError, ProgrammingError, DataError, NotSupportedError)
"""What a statement of ours did; every other error of a database is that of the database."""
_MALFORMED = ("malformed", "not a database")
"""Words of SQLite for a file whose pages are not as they should be."""


@dataclass(eq=False)
class Troubles:
    """How often a database has failed so far."""

    count: int = 0


@dataclass(frozen=True, eq=False)
class Engines:
    """An engine to write with, one to read with in one state of the database, and one for reads of one statement.

    The last needs no transaction: of what a read costs, beginning and ending one is the larger part.

    Attributes:
        parameters: of a PostgreSQL connection, as libpq takes them; empty for SQLite.
    """

    writer: Engine
    readers: Engine
    single: Engine
    parameters: dict[str, Any] = field(default_factory=dict)
    held: ExitStack = field(default_factory=ExitStack)
    troubles: Troubles = field(default_factory=Troubles)

    @property
    def software(self) -> str:
        """Name the database's software and version; PostgreSQL's is known once a connection was opened."""
        if self.writer.dialect.name == "sqlite":
            return f"SQLite {sqlite_driver().sqlite_version}"
        version = self.writer.dialect.server_version_info or ()
        return f"PostgreSQL {'.'.join(str(part) for part in version)}".strip()

    def dispose(self) -> None:
        """Close every connection."""
        self.single.dispose()
        self.readers.dispose()
        self.writer.dispose()
        self.held.close()


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
        Failure: the database is gone, silent, full, locked or broken: not the caller's fault, and it may pass. Or its
            file is damaged, which does not.
    """
    outage: patience.Outage | None = engine.get_execution_options().get("outage")
    if outage is not None and outage.present:
        raise NotReady("the database does not answer: try again", _TRY_AGAIN)
    try:
        yield
    except _OURS:
        raise
    except (DBAPIError, engine.dialect.loaded_dbapi.Error) as error:
        cause = error.orig if isinstance(error, DBAPIError) else error
        engine.get_execution_options()["troubles"].count += 1
        structlog.get_logger().error("the database failed", error=f"{type(cause).__name__}: {cause}")
        if engine.dialect.name == "sqlite" and any(sign in str(cause) for sign in _MALFORMED):
            raise Damaged(f"the database's file is damaged ({cause}): restore a backup") from error
        why = said(cause)
        detail = f"the database does not work at the moment{why}: try again, writes with the same Idempotency-Key"
        raise NotReady(detail, _TRY_AGAIN) from error
    except NoConnection as error:
        structlog.get_logger().error("the database is too slow", waited_seconds=_WAIT_SECONDS)
        raise Overloaded("too many requests wait for the database: try again", _TRY_AGAIN) from error


def said(cause: BaseException | None) -> str:
    """Quote what the database itself said, in brackets; nothing of a driver's, which may name hosts and users."""
    diagnosis = getattr(getattr(cause, "diag", None), "message_primary", None)
    if diagnosis is None and type(cause).__module__.split(".")[0] in ("sqlite3", "pysqlite3"):
        diagnosis = str(cause)
    return "" if diagnosis is None else f" ({diagnosis})"


def connect(url: str, patience_s: float = 4.0) -> Engines:
    """Open `sqlite:///file` or `postgresql://user@host/database`.

    Args:
        url: of the database.
        patience_s: how long PostgreSQL may be silent before a call fails.

    Raises:
        InUse: SQLite's file is open elsewhere, and this SQLite could lose what is committed.
    """
    parsed = make_url(url)
    return _sqlite(parsed) if parsed.get_backend_name() == "sqlite" else _postgres(parsed, patience_s)


def _postgres(url: URL, patience_s: float) -> Engines:
    wanted = patience.parameters(url, patience_s)
    engine = create_engine(
        url,
        pool_size=_CONNECTIONS,
        max_overflow=0,
        pool_timeout=_WAIT_SECONDS,
        pool_pre_ping=True,  # a database that went and came back costs one query, not an error
        connect_args=wanted,
    )
    given = dict(engine.dialect.create_connect_args(url)[1]) | wanted
    outage = patience.Outage(partial(patience.ask, given))
    impatient = patience.connection_type(patience_s, outage)
    event.listen(
        engine, "do_connect", lambda _dialect, _record, _args, given: patience.connected(impatient, given, outage)
    )
    troubles = Troubles()
    engine = engine.execution_options(outage=outage, troubles=troubles)
    held = ExitStack()
    held.callback(outage.close)
    single = engine.execution_options(isolation_level="AUTOCOMMIT")
    return Engines(engine, engine.execution_options(isolation_level="REPEATABLE READ"), single, given, held, troubles)


def _sqlite(url: URL) -> Engines:
    driver, held = sqlite_driver(), ExitStack()
    version, file, troubles = version_of(driver), database_file(url), Troubles()
    if file is not None and loses_commits(version):
        held.enter_context(alone(file, version))

    def opened(begin: str | None, connections: int) -> Engine:
        return _sqlite_engine(url, driver, begin, connections).execution_options(troubles=troubles)

    return Engines(opened("BEGIN IMMEDIATE", 1), opened("BEGIN", _READERS), opened(None, _READERS), {}, held, troubles)


def _sqlite_engine(url: URL, driver: Any, begin: str | None, connections: int) -> Engine:
    """WAL and synchronous=FULL: every commit is on the disk before it is answered."""
    engine = create_engine(url, module=driver, pool_size=connections, max_overflow=0, pool_timeout=_WAIT_SECONDS)

    def prepare(connection: Any, _record: Any) -> None:
        connection.isolation_level = None  # transactions begin where SQLAlchemy says so, below
        connection.text_factory = _text
        for pragma in (f"busy_timeout={_BUSY_MS}", "synchronous=FULL", "foreign_keys=ON"):
            connection.execute(f"PRAGMA {pragma}")
        _write_ahead(connection)

    event.listen(engine, "connect", prepare)
    if begin is not None:
        event.listen(engine, "begin", lambda connection: connection.exec_driver_sql(begin))
    return engine


def _write_ahead(connection: Any) -> None:
    """Switch a file to its write-ahead log; of several connections that do so at once, SQLite lets only one wait."""
    end = time.monotonic() + _BUSY_MS / 1000.0
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL")
        except Exception as error:  # of whichever driver it is
            if "locked" not in str(error) or time.monotonic() >= end:
                raise
            time.sleep(_SWITCH_AGAIN_SECONDS)
        else:
            return


def _text(stored: bytes) -> str:
    """Read a text; a byte that belongs to none stays, so that the checksum can tell whose it was."""
    return stored.decode("utf-8", "surrogateescape")
