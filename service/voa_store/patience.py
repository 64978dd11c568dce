"""How long PostgreSQL is waited for: a server that is silent is a failure within seconds, whatever it is asked.

A server's own time-outs are of no use where the server has been stopped, and those of TCP see nothing wrong: the kernel
goes on acknowledging. So every wait of the driver ends here. A call that waited in vain makes an outage of it: nobody
else waits then, until a thread that tries once a second has been answered.
"""

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import structlog
from sqlalchemy import URL

if TYPE_CHECKING:
    import psycopg

CONNECT_SECONDS = 4
_LEAST_SECONDS = 2  # libpq takes less for more
_SHARE = 0.8  # of the patience: how long a lock is waited for
_IDLE_MS = 10_000
_AGAIN_SECONDS = 1.0
_WAKE_SECONDS = 0.1
_HOPELESS_SECONDS = 0.5

T = TypeVar("T")


class Outage:
    """Whether the server is known not to answer; ends by itself when it does.

    Args:
        attempt: connects, asks something and leaves; raises whatever is wrong.
    """

    def __init__(self, attempt: Callable[[], None]) -> None:
        self._attempt = attempt
        self._lock = threading.Lock()
        self._present = False
        self._closed = threading.Event()

    @property
    def present(self) -> bool:
        """Whether the last call that waited, waited in vain."""
        return self._present

    def begin(self) -> None:
        """Note that a call waited in vain; from any thread."""
        with self._lock:
            if self._present or self._closed.is_set():
                return
            self._present = True
        structlog.get_logger().error("the database does not answer", trying_again_every_seconds=_AGAIN_SECONDS)
        threading.Thread(target=self._run, name="voa-outage", daemon=True).start()

    def close(self) -> None:
        """End the attempts."""
        self._closed.set()

    def _run(self) -> None:
        while not self._closed.wait(_AGAIN_SECONDS):
            try:
                self._attempt()
            except Exception as error:
                structlog.get_logger().debug("the database still does not answer", error=str(error))
                continue
            self._present = False
            structlog.get_logger().info("the database answers again")
            return


def connection_type(seconds: float, outage: Outage | None = None) -> "type[psycopg.Connection[Any]]":
    """Make the type of connections that wait `seconds` for anything, and begin an outage where that was in vain.

    A connection that waited in vain is closed: what comes later would be the answer to another question. During an
    outage nothing that is begun waits for longer than a moment.
    """
    import psycopg  # noqa: PLC0415 - the extra `postgres`; without it there is no such database

    class Impatient(psycopg.Connection[Any]):
        """A connection that does not wait for ever."""

        patience_s: float | None = seconds

        def wait(self, gen: Any, interval: float = _WAKE_SECONDS, timeout: float | None = None) -> Any:
            if timeout is not None:
                return super().wait(gen, interval=interval, timeout=timeout)
            hopeless = outage is not None and outage.present
            patience = _HOPELESS_SECONDS if hopeless else self.patience_s
            try:
                return super().wait(gen, interval=interval, timeout=patience)
            except psycopg.errors._WaitTimeout as error:  # it has no other name
                self.pgconn.finish()
                if outage is not None:
                    outage.begin()
                raise psycopg.OperationalError(f"the database was silent for {patience:g} s") from error

    return Impatient


def connected(kind: "type[psycopg.Connection[Any]]", given: dict[str, Any], outage: Outage) -> Any:
    """Open a connection of a type, unless the server is known not to answer.

    Raises:
        psycopg.OperationalError: the server does not answer, or refuses.
    """
    import psycopg  # noqa: PLC0415 - as above

    if outage.present:
        raise psycopg.OperationalError("the database does not answer")
    try:
        return kind.connect(**given)
    except psycopg.errors.ConnectionTimeout:
        outage.begin()
        raise


def ask(given: dict[str, Any]) -> None:
    """Connect, ask for nothing, and leave.

    Raises:
        psycopg.Error: the server does not answer, or refuses.
    """
    with connection_type(CONNECT_SECONDS).connect(**given) as connection:
        connection.execute("SELECT 1")


def parameters(url: URL, patience_s: float) -> dict[str, Any]:
    """Build libpq's parameters for a URL: a server that is gone is noticed; what the URL says itself holds."""
    usual: dict[str, Any] = {
        "connect_timeout": max(_LEAST_SECONDS, min(CONNECT_SECONDS, int(patience_s))),
        "keepalives_idle": 10,
        "keepalives_interval": 5,
        "keepalives_count": 3,
        "tcp_user_timeout": 10_000,
    }
    # A row that somebody holds, who may be frozen, must not hold up every worker for good.
    # All of it ends before this side's patience does: an error that says why is better than silence.
    patience_ms = int(1e3 * patience_s)
    limits = {
        "lock_timeout": int(_SHARE * patience_ms),
        "statement_timeout": patience_ms,
        "idle_in_transaction_session_timeout": _IDLE_MS,
    }
    options = " ".join(f"-c {name}={value}" for name, value in limits.items())
    own = url.query.get("options", "")
    return usual | dict(url.query) | {"options": f"{options} {own if isinstance(own, str) else ' '.join(own)}".strip()}
