"""Publication on Zenoh: `belief/<session>` after every commit, `refused/<session>/<robot>` for scans without effect.

Several threads may announce their commits in another order than they made them: waiting items are sorted by version.
A subscriber keeps the newest version, and reads the session where a version is missing.
"""

import queue
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

import structlog
import zenoh
from zenoh import CongestionControl, Encoding

from voa_msgs.keys import Keys
from voa_msgs.sessions import Session
from voa_service.failures import Failure, document
from voa_service.runtime.metrics import Metrics
from voa_service.usecases.health import Link
from voa_store.records import SessionState

_MOST_WAITING = 4096
_MOST_ENDED = 4096
_END_SECONDS = 0.4


@dataclass(frozen=True)
class _Item:
    """A put, or a delete where `make` is None."""

    kind: Literal["belief", "refusal"]
    key: str
    make: Callable[[], bytes] | None
    order: float = 0
    attachment: bytes | None = None


class Outbox:
    """Publishes in a thread of its own, for a put may wait while a router is slow.

    Args:
        message: makes the message of a session's state.
        keys: key expressions of the service.
        link: state of the connection to a router.
        metrics: counts the items that were published or dropped.
    """

    def __init__(self, message: Callable[[SessionState], Session], keys: Keys, link: Link, metrics: Metrics) -> None:
        self._message = message
        self._keys = keys
        self._link = link
        self._metrics = metrics
        self._waiting: queue.SimpleQueue[_Item | None] = queue.SimpleQueue()
        self._ended: OrderedDict[str, None] = OrderedDict()
        """Keys of deleted sessions, whose late beliefs are not published any more."""

    def committed(self, session: str, state: SessionState | None) -> None:
        """Publish the state of a session after a commit, or its end where `state` is None.

        May be called from any thread; returns at once.
        """
        key = self._keys.belief(session)
        if state is None:
            self._add(_Item("belief", key, None, float("inf")))
            return
        version = str(state.version).encode()
        self._add(_Item("belief", key, lambda: self._message(state).model_dump_json().encode(), state.version, version))

    def refused(self, session: str, robot: str, failure: Failure) -> None:
        """Publish that a robot's scan had no effect, and why; may be called from any thread, and returns at once."""
        self._add(_Item("refusal", self._keys.refused(session, robot), lambda: document(failure)))

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Publish on a session within a `with` block."""
        # A put may wait for seconds where a router is frozen: the thread is waited for only briefly.
        thread = threading.Thread(target=self._run, args=(session,), name="voa-outbox", daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._waiting.put(None)
            thread.join(_END_SECONDS)
            while not self._waiting.empty():
                item = self._waiting.get()
                if item is not None:
                    self._metrics.zenoh(f"{item.kind} dropped")

    def _add(self, item: _Item) -> None:
        if self._link.state != "connected":
            self._metrics.zenoh(f"{item.kind} dropped without a router")
            return
        if self._waiting.qsize() >= _MOST_WAITING:
            self._metrics.zenoh(f"{item.kind} dropped")
        else:
            self._waiting.put(item)

    def _run(self, session: zenoh.Session) -> None:
        while True:
            batch = [self._waiting.get()]
            while not self._waiting.empty():
                batch.append(self._waiting.get())
            for item in sorted((each for each in batch if each is not None), key=lambda each: each.order):
                self._put(session, item)
            if None in batch:
                return

    def _put(self, session: zenoh.Session, item: _Item) -> None:
        if item.make is None:
            self._ended[item.key] = None
            while len(self._ended) > _MOST_ENDED:
                self._ended.popitem(last=False)
        elif item.key in self._ended:
            return
        try:
            if item.make is None:
                session.delete(item.key, congestion_control=CongestionControl.BLOCK)
            else:
                session.put(
                    item.key,
                    item.make(),
                    encoding=Encoding.APPLICATION_JSON,
                    attachment=item.attachment,
                    congestion_control=CongestionControl.BLOCK,
                )
        except Exception as error:
            # Any error: the items after this one must still be published.
            structlog.get_logger().warning(
                "a message was not published", key=item.key, error=f"{type(error).__name__}: {error}"
            )
            self._metrics.zenoh(f"{item.kind} dropped")
        else:
            self._metrics.zenoh(f"{item.kind} published")
