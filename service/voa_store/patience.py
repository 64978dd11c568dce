"""Bounds the time that calls wait for PostgreSQL: a silent server is an error within seconds.

The server's own time-outs do not help where its process was stopped, nor do those of TCP, because the kernel still
acknowledges packets. So this module bounds every wait of the driver. The first call that waits in vain begins an
outage: all other calls fail at once, until a thread that tries once a second reaches the server again.
"""

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import structlog
from sqlalchemy import URL

if TYPE_CHECKING:
    import psycopg

CONNECT_SECONDS = 4
_LEAST_SECONDS = 2  # libpq turns a time-out of 1 s into 2 s
_SHARE = 0.8  # of the patience: longest wait for a lock
_IDLE_MS = 10_000
_RETRY_SECONDS = 1.0
_WAKE_SECONDS = 0.1
_OUTAGE_SECONDS = 0.5

T = TypeVar("T")


class Outage:
    """State of a server that may not answer; an outage ends by itself when the server answers again.

    Args:
        attempt: connects, runs a query and disconnects; raises an error if the server does not answer.
    """

    def __init__(self, attempt: Callable[[], None]) -> None:
        self._attempt = attempt
        self._lock = threading.Lock()
        self._present = False
        self._closed = threading.Event()

    @property
    def present(self) -> bool:
        """True while the server is known not to answer."""
        return self._present

    def begin(self) -> None:
        """Begin an outage, from any thread, after a call has waited in vain."""
        with self._lock:
            if self._present or self._closed.is_set():
                return
            self._present = True
        structlog.get_logger().error("the database does not answer", trying_again_every_seconds=_RETRY_SECONDS)
        threading.Thread(target=self._run, name="voa-outage", daemon=True).start()

    def close(self) -> None:
        """Stop trying to reach the server."""
        self._closed.set()

    def _run(self) -> None:
        while not self._closed.wait(_RETRY_SECONDS):
            try:
                self._attempt()
            except Exception as error:
                structlog.get_logger().debug("the database still does not answer", error=str(error))
                continue
            self._present = False
            structlog.get_logger().info("the database answers again")
            return


def connection_type(seconds: float, outage: Outage | None = None) -> "type[psycopg.Connection[Any]]":
    """Create the class of connections that wait at most `seconds` for a result, and begin an outage after that.

    A connection that waited in vain is closed, because a late result would be taken for that of the next query. During
    an outage every wait is cut to half a second.

    Args:
        seconds: longest wait.
        outage: of the server; None: connections do not take part in one.
    """
    import psycopg  # noqa: PLC0415 - the extra `postgres`; without it there is no such database

    class Impatient(psycopg.Connection[Any]):
        """Connection with bounded waits."""

        patience_s: float | None = seconds

        def wait(self, gen: Any, interval: float = _WAKE_SECONDS, timeout: float | None = None) -> Any:
            if timeout is not None:
                return super().wait(gen, interval=interval, timeout=timeout)
            is_out = outage is not None and outage.present
            patience = _OUTAGE_SECONDS if is_out else self.patience_s
            try:
                return super().wait(gen, interval=interval, timeout=patience)
            except psycopg.errors._WaitTimeout as error:  # psycopg has no public name for it
                self.pgconn.finish()
                if outage is not None:
                    outage.begin()
                raise psycopg.OperationalError(f"the database was silent for {patience:g} s") from error

    return Impatient


def connected(kind: "type[psycopg.Connection[Any]]", parameters: dict[str, Any], outage: Outage) -> Any:
    """Open a connection of a class, unless the server is known not to answer.

    Raises:
        psycopg.OperationalError: the server does not answer, or refuses.
    """
    import psycopg  # noqa: PLC0415 - the extra `postgres`

    if outage.present:
        raise psycopg.OperationalError("the database does not answer")
    try:
        return kind.connect(**parameters)
    except psycopg.errors.ConnectionTimeout:
        outage.begin()
        raise


def try_to_connect(parameters: dict[str, Any]) -> None:
    """Connect, run an empty query, and disconnect.

    Raises:
        psycopg.Error: the server does not answer, or refuses.
    """
    with connection_type(CONNECT_SECONDS).connect(**parameters) as connection:
        connection.execute("SELECT 1")


def parameters(url: URL, patience_s: float) -> dict[str, Any]:
    """Build the parameters of libpq for a URL, with time-outs that notice a lost server; the URL's own ones win."""
    defaults: dict[str, Any] = {
        "connect_timeout": max(_LEAST_SECONDS, min(CONNECT_SECONDS, int(patience_s))),
        "keepalives_idle": 10,
        "keepalives_interval": 5,
        "keepalives_count": 3,
        "tcp_user_timeout": 10_000,
    }
    # A client that holds a row's lock and hangs must not block every worker for good. The server's time-outs end before
    # this side's patience does, because the server's error names the cause.
    patience_ms = int(1e3 * patience_s)
    limits = {
        "lock_timeout": int(_SHARE * patience_ms),
        "statement_timeout": patience_ms,
        "idle_in_transaction_session_timeout": _IDLE_MS,
    }
    options = " ".join(f"-c {name}={value}" for name, value in limits.items())
    own = url.query.get("options", "")
    return (
        defaults | dict(url.query) | {"options": f"{options} {own if isinstance(own, str) else ' '.join(own)}".strip()}
    )
