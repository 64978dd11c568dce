"""`rpc/<method>`: every query is answered, by a worker thread, or at once where there is too much to do."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import structlog
import zenoh
from zenoh import Encoding
from zenoh.handlers import Callback

from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Keys
from voa_service.failures import Failure, document
from voa_service.metrics import Metrics
from voa_service.rpc import Rpc

_END_SECONDS = 1.0


class Queries:
    """The queryable.

    It is complete: of several replicas Zenoh then asks one, and another one when that is gone.
    """

    def __init__(self, rpc: Rpc, keys: Keys, metrics: Metrics) -> None:
        self._rpc = rpc
        self._keys = keys
        self._metrics = metrics
        self._open = 0
        self._closed = threading.Condition()

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Answer queries for the length of a `with`; those that were taken are answered before it ends."""
        with session.declare_queryable(self._keys.rpc("*"), Callback(self._heard, indirect=False), complete=True):
            yield
        with self._closed:
            self._closed.wait_for(lambda: self._open == 0, _END_SECONDS)

    def _heard(self, query: zenoh.Query) -> None:
        """In a Zenoh thread: hand over, or refuse."""
        method = self._keys.last(str(query.key_expr))
        with self._closed:
            self._open += 1
        try:
            self._rpc.queue(method).submit(partial(self._answer, method, query))
        except Failure as failure:
            self._metrics.rpc("none", failure.status, 0.0)
            with query:
                query.reply_err(document(failure), encoding=Encoding.APPLICATION_JSON)
            self._answered()

    def _answer(self, method: str, query: zenoh.Query) -> None:
        """In a worker thread. A query that is not dropped leaves its caller waiting: `with` drops it."""
        try:
            with query:
                payload = b"" if query.payload is None else query.payload.to_bytes()
                attachment = None if query.attachment is None else query.attachment.to_bytes()
                answer = self._rpc.answer(method, payload, attachment)
                if answer.is_problem:
                    query.reply_err(answer.body, encoding=Encoding.APPLICATION_JSON)
                else:
                    query.reply(
                        query.key_expr,
                        answer.body,
                        encoding=Encoding.APPLICATION_JSON,
                        attachment=_beside(answer.version),
                    )
        except zenoh.ZError as error:  # the caller or the router has gone; what was done is done
            self._metrics.zenoh("answer not heard")
            structlog.get_logger().warning("answer not sent", method=method, error=str(error))
        finally:
            self._answered()

    def _answered(self) -> None:
        with self._closed:
            self._open -= 1
            self._closed.notify_all()


def _beside(version: int | None) -> bytes:
    """The attachment of an answer."""
    known = "" if version is None else f', "version": {version}'
    return f'{{"wire": {WIRE_VERSION}{known}}}'.encode()
