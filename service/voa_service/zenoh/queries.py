"""Queries on `rpc/<method>`: each is answered by a worker thread, or refused at once: without a valid key, or where too
many are waiting."""

import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial

import structlog
import zenoh
from zenoh import Encoding
from zenoh.handlers import Callback

from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Keys
from voa_service.failures import Failure, NotReady, Overloaded, TooLarge, document
from voa_service.rpc.entry import Admitted, Rpc
from voa_service.runtime.metrics import Metrics

_END_SECONDS = 0.4
_LATE_SECONDS = 0.1
"""Time in which queries may still arrive that the router sent before it learnt that this replica ends."""
_SHARE = 4
"""Payloads under way may have this many times the bytes of the largest payload allowed."""


class Queries:
    """The queryable of all remote calls.

    It is declared complete: of several replicas Zenoh then queries one, and another where that is gone.

    Args:
        rpc: answers the calls.
        keys: key expressions of the service.
        metrics: counts calls and lost responses.
        most_bytes: size of the largest payload allowed.
    """

    def __init__(self, rpc: Rpc, keys: Keys, metrics: Metrics, most_bytes: int) -> None:
        self._rpc = rpc
        self._keys = keys
        self._metrics = metrics
        self._most_bytes = most_bytes
        self._open: dict[int, zenoh.Query] = {}
        self._bytes = 0
        self._closed = threading.Condition()

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Answer queries within a `with` block; queries received before its end are answered or refused at its end."""
        receive = Callback(self._receive, indirect=False)
        with ExitStack() as late:
            with session.declare_queryable(self._keys.rpc("*"), receive, complete=True):
                yield
                late.enter_context(self._receiving_late(session))
            threading.Event().wait(_LATE_SECONDS)
        with self._closed:
            self._closed.wait_for(lambda: not self._open, _END_SECONDS)
            left = list(self._open.values())
        for query in left:
            self._refuse(query, NotReady("the service is stopping: try again, writes under the same id"))

    def _receiving_late(self, session: zenoh.Session) -> AbstractContextManager[object]:
        """Receive the queries that the router sends before it learns that this replica ends.

        They would be lost without a response. This queryable is incomplete: the router sends it new queries only where
        there is no other replica.
        """
        late = Callback(self._receive_late, indirect=False)
        return session.declare_queryable(self._keys.rpc("*"), late, complete=False)

    def _receive_late(self, query: zenoh.Query) -> None:
        """Queue a query that may have been received by the other queryable too; called in a Zenoh thread."""
        attachment = None if query.attachment is None else query.attachment.to_bytes()
        if self._rpc.may_repeat(self._keys.last(str(query.key_expr)), attachment):
            self._receive(query)
        else:
            query.drop()  # type: ignore[no-untyped-call] # zenoh has no types here

    def _receive(self, query: zenoh.Query) -> None:
        """Queue a query for a worker thread, or refuse it; called in a Zenoh thread.

        The key is checked first: calls of strangers take no place in a queue.
        """
        method = self._keys.last(str(query.key_expr))
        size = 0 if query.payload is None else len(query.payload)
        with self._closed:
            self._open[id(query)] = query
            self._bytes += size
        attachment = None if query.attachment is None else query.attachment.to_bytes()
        try:
            admitted = self._rpc.admit(method, attachment)
        except Failure as failure:
            self._refuse(query, failure)
            self._answered(query, size)
            return
        try:
            self._check_size(size)
            self._rpc.queue(method).submit(partial(self._answer, admitted, query, size))
        except Failure as failure:
            self._metrics.rpc("none", failure.status, 0.0)
            self._refuse(query, failure)
            self._answered(query, size)

    def _check_size(self, size: int) -> None:
        """Check the size of a payload before it is read.

        Raises:
            Failure: it is too large, by itself or with the other payloads under way.
        """
        if size > self._most_bytes:
            raise TooLarge(f"expected a payload of at most {self._most_bytes} bytes, got {size}")
        if self._bytes > _SHARE * self._most_bytes:
            raise Overloaded(
                "the payloads of all callers are too large together at the moment: try again", {"Retry-After": "1"}
            )

    def _refuse(self, query: zenoh.Query, failure: Failure) -> None:
        try:
            with query:
                query.reply_err(document(failure), encoding=Encoding.APPLICATION_JSON)
        except zenoh.ZError:
            self._metrics.zenoh("response not delivered")

    def _answer(self, admitted: Admitted, query: zenoh.Query, size: int) -> None:
        """Answer a query, in a worker thread; `with` drops the query, without which its caller would wait on."""
        try:
            with query:
                payload = b"" if query.payload is None else query.payload.to_bytes()
                answer = self._rpc.perform(admitted, payload)
                if answer.is_problem:
                    query.reply_err(answer.body, encoding=Encoding.APPLICATION_JSON)
                else:
                    query.reply(
                        query.key_expr,
                        answer.body,
                        encoding=Encoding.APPLICATION_JSON,
                        attachment=_attachment(answer.version),
                    )
        except zenoh.ZError as error:  # the caller or the router has gone; a write stays done
            self._metrics.zenoh("response not delivered")
            structlog.get_logger().warning("a response was not sent", method=admitted.method, error=str(error))
        finally:
            self._answered(query, size)

    def _answered(self, query: zenoh.Query, size: int) -> None:
        with self._closed:
            del self._open[id(query)]
            self._bytes -= size
            if not self._open:
                self._closed.notify_all()


def _attachment(version: int | None) -> bytes:
    """Return the attachment of a response: the version of the messages, and of the session if there is one."""
    known = "" if version is None else f', "version": {version}'
    return f'{{"wire": {WIRE_VERSION}{known}}}'.encode()
