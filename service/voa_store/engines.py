"""Opens databases of each kind, and turns their errors into errors of the store."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import structlog
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import DataError, DBAPIError, IntegrityError, NotSupportedError, ProgrammingError
from sqlalchemy.exc import TimeoutError as NoConnection
from sqlalchemy.sql.compiler import SQLCompiler

from voa_store import patience
from voa_store.drivers import alone, database_file, loses_commits, sqlite_driver, version_of
from voa_store.errors import Busy, DamagedData, Unavailable
from voa_store.write_ahead import keep_damaged_log

_READERS = 8
_CONNECTIONS = 16
_BUSY_MS = 10_000
_SWITCH_AGAIN_SECONDS = 0.01
WAIT_SECONDS = 10
"""Longest wait for a connection, or for a group of writes to begin."""
STATEMENT_ERRORS = (IntegrityError, ProgrammingError, DataError, NotSupportedError)
"""Errors caused by a statement of this package; every other error is a fault of the database."""
_MALFORMED = ("malformed", "not a database")
"""Words in the errors of SQLite for a damaged file."""


@dataclass(eq=False)
class Calls:
    """Record of the calls to a database.

    Attributes:
        failed: number of calls that the database has failed.
        observe: called with each transaction's or statement's wall time in seconds.
    """

    failed: int = 0
    observe: Callable[[float], None] | None = None


@dataclass(frozen=True, eq=False)
class Engines:
    """Engines of one database for each kind of access.

    Attributes:
        writer: for transactions that write.
        readers: for transactions that read several rows in one state of the database.
        single: for a single statement that reads, without a transaction: beginning and ending one would take longer
            than the statement.
        parameters: of a PostgreSQL connection, as libpq takes them; empty for SQLite.
        held: resources that are released when the engines are disposed.
        calls: record of the calls to the database.
    """

    writer: Engine
    readers: Engine
    single: Engine
    parameters: dict[str, Any] = field(default_factory=dict)
    held: ExitStack = field(default_factory=ExitStack)
    calls: Calls = field(default_factory=Calls)

    @property
    def software(self) -> str:
        """Name of the database's software with its version, which PostgreSQL states at the first connection."""
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
    """Open a transaction that is committed when the `with` block ends, and rolled back if that raises.

    Raises:
        Unavailable, Busy, DamagedData: the database failed. If the connection broke during the commit, the transaction
            may or may not have been committed; idempotency keys make it safe to try again.
    """
    with _database_errors(engine), engine.begin() as connection:
        yield connection


@contextmanager
def statement(engine: Engine) -> Iterator[Connection]:
    """Open a connection for a single statement that reads.

    Raises:
        Unavailable, Busy, DamagedData: the database failed.
    """
    with _database_errors(engine), engine.connect() as connection:
        yield connection


def first(engine: Engine, query: SQLCompiler, name: str, value: str) -> tuple[Any, ...] | None:
    """Read the first row of a query with one parameter; None: there is no row.

    The query goes to the driver directly: for the smallest query, which is also the most frequent one, SQLAlchemy would
    take three quarters of the time.

    Args:
        engine: to connect with.
        query: compiled for the engine.
        name: of the query's parameter.
        value: of the query's parameter.

    Raises:
        Unavailable, Busy, DamagedData: the database failed.
    """
    with _database_errors(engine):
        connection = engine.raw_connection()
        try:
            cursor = connection.cursor()
            cursor.execute(str(query), (value,) if query.positional else {name: value})
            row: tuple[Any, ...] | None = cursor.fetchone()
        finally:
            connection.close()
    return row


@contextmanager
def _database_errors(engine: Engine) -> Iterator[None]:
    """Turn faults of a database into errors of the store.

    Raises:
        Unavailable: the database is gone, silent, full, locked or broken, which may pass.
        DamagedData: its file is damaged. SQLite reports a page that the disk cannot read as damaged too.
        Busy: all connections are in use.
    """
    options = engine.get_execution_options()
    outage: patience.Outage | None = options.get("outage")
    calls: Calls = options["calls"]
    if outage is not None and outage.present:
        raise Unavailable("the database does not answer: try again")
    began = time.perf_counter()
    try:
        yield
    except STATEMENT_ERRORS:
        raise
    except (DBAPIError, engine.dialect.loaded_dbapi.Error) as error:
        cause = error.orig if isinstance(error, DBAPIError) else error
        calls.failed += 1
        structlog.get_logger().error("the database failed", error=f"{type(cause).__name__}: {cause}")
        if engine.dialect.name == "sqlite" and any(sign in str(cause) for sign in _MALFORMED):
            raise DamagedData(
                f"the database's file is damaged, or the disk cannot read it ({cause}): check the disk, then the "
                "database with `voa doctor --database-url URL`, and restore a backup if that names damage"
            ) from error
        message = diagnosis(cause)
        raise Unavailable(
            f"the database does not work at the moment{message}: try again, and repeat writes with the same "
            "Idempotency-Key"
        ) from error
    except NoConnection as error:
        structlog.get_logger().error("the database is too slow", waited_seconds=WAIT_SECONDS)
        raise Busy("too many requests wait for the database: try again") from error
    finally:
        if calls.observe is not None:
            calls.observe(time.perf_counter() - began)


def diagnosis(cause: BaseException | None) -> str:
    """Quote the database's own message, in brackets; a driver's message is left out, as it may name hosts and users."""
    message = getattr(getattr(cause, "diag", None), "message_primary", None)
    if message is None and type(cause).__module__.split(".")[0] in ("sqlite3", "pysqlite3"):
        message = str(cause)
    return "" if message is None else f" ({message})"


def connect(url: str, patience_s: float = 4.0) -> Engines:
    """Open `sqlite:///file` or `postgresql://user@host/database`.

    Args:
        url: of the database.
        patience_s: seconds for which PostgreSQL may be silent before a call fails.

    Raises:
        FileInUse: another process has the SQLite file open, and this SQLite could lose committed transactions.
    """
    parsed = make_url(url)
    return _sqlite(parsed) if parsed.get_backend_name() == "sqlite" else _postgres(parsed, patience_s)


def _postgres(url: URL, patience_s: float) -> Engines:
    limits = patience.parameters(url, patience_s)
    engine = create_engine(
        url,
        pool_size=_CONNECTIONS,
        max_overflow=0,
        pool_timeout=WAIT_SECONDS,
        pool_pre_ping=True,  # a database that was restarted costs a query instead of an error
        connect_args=limits,
    )
    parameters = dict(engine.dialect.create_connect_args(url)[1]) | limits
    outage = patience.Outage(partial(patience.try_to_connect, parameters))
    impatient = patience.connection_type(patience_s, outage)
    event.listen(engine, "do_connect", lambda _dialect, _record, _args, own: patience.connected(impatient, own, outage))
    calls = Calls()
    engine = engine.execution_options(outage=outage, calls=calls)
    held = ExitStack()
    held.callback(outage.close)
    single = engine.execution_options(isolation_level="AUTOCOMMIT")
    return Engines(engine, engine.execution_options(isolation_level="REPEATABLE READ"), single, parameters, held, calls)


def _sqlite(url: URL) -> Engines:
    driver, held = sqlite_driver(), ExitStack()
    version, file, calls = version_of(driver), database_file(url), Calls()
    if file is not None and loses_commits(version):
        held.enter_context(alone(file, version))

    def engine(begin: str | None, connections: int) -> Engine:
        return _sqlite_engine(url, driver, begin, connections).execution_options(calls=calls)

    single = engine(None, _READERS)
    if file is not None:
        with _database_errors(single):
            keep_damaged_log(file, driver)
    return Engines(engine("BEGIN IMMEDIATE", 1), engine("BEGIN", _READERS), single, {}, held, calls)


def _sqlite_engine(url: URL, driver: Any, begin: str | None, connections: int) -> Engine:
    """Create an engine in WAL mode with synchronous=FULL: every commit is on the disk before its call returns."""
    engine = create_engine(url, module=driver, pool_size=connections, max_overflow=0, pool_timeout=WAIT_SECONDS)

    def prepare(connection: Any, _record: Any) -> None:
        connection.isolation_level = None  # transactions are begun by the event below, not by the driver
        connection.text_factory = _text
        for pragma in (f"busy_timeout={_BUSY_MS}", "synchronous=FULL", "foreign_keys=ON"):
            connection.execute(f"PRAGMA {pragma}")
        if connection.execute("PRAGMA page_count").fetchone() == (0,):
            # Pages of a new file can be given back (`space`); in any other file this would be a write without effect.
            connection.execute("PRAGMA auto_vacuum=INCREMENTAL")
        _write_ahead(connection)

    event.listen(engine, "connect", prepare)
    if begin is not None:
        event.listen(engine, "begin", lambda connection: connection.exec_driver_sql(begin))
    return engine


def _write_ahead(connection: Any) -> None:
    """Switch a file to WAL mode, again and again: SQLite refuses at once where several connections try together."""
    end = time.monotonic() + _BUSY_MS / 1000.0
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL")
        except Exception as error:  # each driver has an error class of its own
            if "locked" not in str(error) or time.monotonic() >= end:
                raise
            time.sleep(_SWITCH_AGAIN_SECONDS)
        else:
            return


def _text(stored: bytes) -> str:
    """Decode a text; damaged bytes become surrogates, so that the checksum reports them, not the decoder."""
    return stored.decode("utf-8", "surrogateescape")
