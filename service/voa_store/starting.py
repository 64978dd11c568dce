"""Opens the store when the service starts; an error is one line that says what to do."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import structlog
from sqlalchemy import URL, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, SQLAlchemyError

from voa_store.drivers import database_file
from voa_store.engines import diagnosis
from voa_store.errors import CannotOpen, FileInUse, NewerTables, StoreError
from voa_store.keys import KeyStore
from voa_store.sql import PATIENCE_SECONDS, SqlStore

_EXPECTED = "expected sqlite:///FILE or postgresql://USER@HOST/DATABASE"
_RETRY_SECONDS = 0.5
_REFUSED = ("28", "3D", "42")
"""Classes of SQLSTATE that waiting does not cure: authentication, the name of the database, and privileges."""


def open_store(
    url: str,
    patience_s: float = PATIENCE_SECONDS,
    wait_s: float = 0.0,
    pause: Callable[[float], None] = time.sleep,
    clock: Callable[[], float] = time.monotonic,
) -> SqlStore:
    """Open the store, migrate its tables, and wait for a server that has not started yet.

    Args:
        url: of the database.
        patience_s: seconds for which PostgreSQL may be silent before a call fails.
        wait_s: seconds to wait for a server that does not answer yet.
        pause: sleeps for so many seconds between two attempts.
        clock: returns the time in seconds.

    Raises:
        CannotOpen: the database cannot be used.
    """
    end = clock() + wait_s
    while True:
        try:
            return _opened(url, patience_s)
        except CannotOpen as error:
            left = end - clock()
            if not error.may_pass or left <= 0.0:
                raise
            structlog.get_logger("voa").warning("waiting for the database", seconds_left=round(left, 1), why=str(error))
            pause(min(_RETRY_SECONDS, left))


def open_keys(url: str, patience_s: float = PATIENCE_SECONDS) -> KeyStore:
    """Open the storage of API keys alone; creates or migrates the tables of the database.

    Args:
        url: of the database.
        patience_s: seconds for which PostgreSQL may be silent before a call fails.

    Raises:
        CannotOpen: the database cannot be used.
    """
    with _explained(url):
        return KeyStore(url, patience_s)


def _opened(url: str, patience_s: float) -> SqlStore:
    with _explained(url):
        return SqlStore(url, patience_s)


@contextmanager
def _explained(url: str) -> Iterator[None]:
    """Explain the errors of opening a database; raises CannotOpen."""
    try:
        yield
    except (SQLAlchemyError, OSError, ImportError, StoreError, ValueError) as error:
        raise CannotOpen(explain(error, url), may_pass=_may_pass(error)) from error


def explain(error: Exception, url: str) -> str:
    """Explain in one line why a database cannot be opened, and what to do.

    Args:
        error: raised by opening it.
        url: of the database; its password is not shown.
    """
    try:
        parsed = make_url(url)
    except ArgumentError:
        return f"--database-url: {_EXPECTED}, got something else"
    where = parsed.render_as_string(hide_password=True)
    match error:
        case FileInUse():
            line = str(error)
        case NewerTables():
            line = (
                f"{where} was written by a newer version of voa ({error}): start that version, or restore the backup "
                "that was made before it"
            )
        case _ if parsed.get_backend_name() not in ("sqlite", "postgresql") or isinstance(error, ArgumentError):
            line = f"--database-url: {_EXPECTED}, got {where}"
        case ImportError():
            line = (
                f"{where} needs a driver that is not installed ({error}): install psycopg, the extra `postgres` of voa"
            )
        case _ if parsed.get_backend_name() == "sqlite":
            line = _explain_file(error, parsed)
        case _:
            line = _explain_server(error, parsed, where)
    return " ".join(line.split())


def url_without_password(url: str) -> str:
    """Return a database URL for logs: its password is replaced by asterisks.

    Args:
        url: that `open_store` has accepted.
    """
    return make_url(url).render_as_string(hide_password=True)


def _explain_file(error: Exception, url: URL) -> str:
    path, text = database_file(url), str(_cause(error))
    if path is None:
        return f"the database in memory does not work: {text}"
    folder = path.parent.absolute()
    if not folder.is_dir():
        return f"there is no folder {folder}: create it, or name another file with --database-url"
    if path.is_dir():
        return f"{path} is a folder: name a file in it, as in --database-url sqlite:///{path}/voa.db"
    if isinstance(error, OSError):
        text = "readonly"
    signs = {
        ("not a database",): f"{path} is not an SQLite database: name another file, or move that one away",
        ("malformed",): f"{path} is damaged ({text}): restore a backup",
        ("readonly", "unable to open"): (
            f"{path} cannot be written by this user: SQLite needs to write the file and its folder {folder} (or the "
            "file system is read-only)"
        ),
        ("full", "disk I/O"): f"{path} cannot be written ({text}): check whether the disk is full",
        ("locked",): f"{path} is locked by another program that has been writing for long: end it, and start again",
    }
    return _by_sign(text, signs) or f"{path} cannot be used: {text}"


def _explain_server(error: Exception, url: URL, where: str) -> str:
    cause = _cause(error)
    user, text = url.username, str(cause)
    signs = {
        ('role "',): f"{where}: there is no role {user!r}: create it with `createuser {user}`, or name another one",
        ('database "',): f"{where}: there is no such database: create it with `createdb -O {user} {url.database}`",
        ("authentication failed", "no password supplied", "pg_hba.conf"): (
            f"{where}: PostgreSQL refuses user {user!r}: check the password, or pg_hba.conf"
        ),
        ("permission denied",): (
            f"{where}: {user!r} may not create tables there: GRANT CREATE, USAGE ON SCHEMA public TO {user}"
        ),
        ("read-only",): f"{where} is read-only, a standby perhaps: name the primary server",
        ("lock timeout", "deadlock"): (
            f"{where}: other programs keep its tables locked, a backup perhaps: wait until that ends, and start again"
        ),
        ("timeout", "silent", "does not answer"): (
            f"{where} does not answer: check that the server runs and that no firewall is in between"
        ),
        ("refused", "resolve", "translate host", "No such file"): (
            f"{where}: no server answers there: start PostgreSQL, or check host and port"
        ),
    }
    return _by_sign(text, signs) or f"{where} cannot be used: {diagnosis(cause).strip(' ()') or text}"


def _by_sign(text: str, signs: Mapping[tuple[str, ...], str]) -> str | None:
    """Return the first message one of whose signs occurs in a text; None: no sign occurs."""
    return next((line for words, line in signs.items() if any(word in text for word in words)), None)


def _may_pass(error: Exception) -> bool:
    """Return True if waiting may help, as it may for a server that has not started yet."""
    cause = _cause(error)
    state = getattr(cause, "sqlstate", None)
    if isinstance(error, StoreError):
        return not isinstance(error, CannotOpen)
    if not isinstance(error, DBAPIError) or type(cause).__module__.split(".")[0] != "psycopg":
        return False
    wrong = any(sign in str(cause) for sign in ("does not exist", "authentication", "pg_hba", "permission", "password"))
    return not wrong and not (state or "").startswith(_REFUSED)


def _cause(error: Exception) -> BaseException:
    if isinstance(error, DBAPIError) and error.orig is not None:
        return error.orig
    if isinstance(error, StoreError) and error.__cause__ is not None:
        under = error.__cause__
        return under.orig if isinstance(under, DBAPIError) and under.orig is not None else under
    return error
