"""What the service puts on Zenoh: `belief/<session>` after every commit, `refused/...` for scans that came to nothing.

Commits by several threads may be told in another order than they were made: what is waiting is sorted by version.
A subscriber keeps the newest version, and reads the session where one is missing.
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
    """One put, or a delete where there is nothing to make."""

    kind: Literal["belief", "refusal"]
    key: str
    make: Callable[[], bytes] | None
    order: float = 0
    attachment: bytes | None = None


class Outbox:
    """A thread of its own, since putting may wait while a router is slow.

    Args:
        message: a session's state as it is told.
        keys: where things are.
        link: whether anybody can hear.
        metrics: counts what was put, and what was not.
    """

    def __init__(self, message: Callable[[SessionState], Session], keys: Keys, link: Link, metrics: Metrics) -> None:
        self._message = message
        self._keys = keys
        self._link = link
        self._metrics = metrics
        self._waiting: queue.SimpleQueue[_Item | None] = queue.SimpleQueue()
        self._ended: OrderedDict[str, None] = OrderedDict()
        """Sessions that are gone: what comes late of them is not told any more."""

    def committed(self, session: str, state: SessionState | None) -> None:
        """A session moved, None: ended. From any thread; returns at once."""
        key = self._keys.belief(session)
        if state is None:
            self._add(_Item("belief", key, None, float("inf")))
            return
        version = str(state.version).encode()
        self._add(_Item("belief", key, lambda: self._message(state).model_dump_json().encode(), state.version, version))

    def refused(self, session: str, robot: str, failure: Failure) -> None:
        """A robot's scan could not be used. From any thread; returns at once."""
        self._add(_Item("refusal", self._keys.refused(session, robot), lambda: document(failure)))

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Publish for the length of a `with`."""
        # A put may wait for seconds where a router is frozen: nobody waits for the thread longer than a moment.
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
            self._metrics.zenoh(f"{item.kind} that nobody could hear")
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
            # Whatever it was, the next one must still be put.
            structlog.get_logger().warning("not published", key=item.key, error=f"{type(error).__name__}: {error}")
            self._metrics.zenoh(f"{item.kind} dropped")
        else:
            self._metrics.zenoh(f"{item.kind} published")
