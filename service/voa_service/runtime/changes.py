"""Who waits for a session to move, and how they hear of it.

A write in this process wakes its watchers at once; so does one by another process where the database tells of it
(PostgreSQL), else it is seen at the next look at the store.
"""

import asyncio
import threading
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from voa_store.records import SessionState

Listener = Callable[[str, SessionState | None], None]
"""Called after a commit of this process: the session as it is then, None: it is gone. From any thread; quick."""


class Watch:
    """One waiter on one session."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._moved = asyncio.Event()
        self.closed = False

    def wake(self, *, closing: bool = False) -> None:
        """From any thread: something moved, or the service is closing."""
        self.closed = self.closed or closing
        self._loop.call_soon_threadsafe(self._moved.set)

    async def wait(self, seconds: float) -> None:
        """Until woken, at most so long; what happened since the last wait counts."""
        try:
            async with asyncio.timeout(seconds):
                await self._moved.wait()
        except TimeoutError:
            return
        self._moved.clear()


class Changes:
    """The watchers of all sessions."""

    def __init__(self) -> None:
        self._watches: defaultdict[str, set[Watch]] = defaultdict(set)
        # A signal handler calls `close`, in a thread that may be anywhere in here.
        self._lock = threading.RLock()
        self._closed = False
        self._listeners: list[Listener] = []
        self._at_close: list[Callable[[], None]] = []

    def at_close(self, act: Callable[[], None]) -> None:
        """Have `act` called when the service begins to end, maybe in a signal handler: it must take no lock."""
        self._at_close.append(act)

    @contextmanager
    def listening(self, listener: Listener) -> Iterator[None]:
        """Have `listener` called with every commit of this process, for the length of a `with`."""
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    def committed(self, session: str, state: SessionState | None) -> None:
        """This process wrote to a session: `state` is how it stands then, None: it is gone."""
        self.moved(session)
        for listener in list(self._listeners):
            listener(session, state)

    @contextmanager
    def watching(self, session: str) -> Iterator[Watch]:
        """A watch on a session for the length of a `with`."""
        watch = Watch()
        with self._lock:
            self._watches[session].add(watch)
            watch.closed = watch.closed or self._closed
        try:
            yield watch
        finally:
            with self._lock:
                self._watches[session].discard(watch)
                if not self._watches[session]:
                    del self._watches[session]

    def moved(self, session: str) -> None:
        """A session has a new version, or is gone, whoever wrote."""
        with self._lock:
            watches = list(self._watches.get(session, ()))
        for watch in watches:
            watch.wake()

    def close(self) -> None:
        """Send every watcher home: the service is ending."""
        for act in self._at_close:
            act()
        with self._lock:
            self._closed = True
            watches = [watch for held in self._watches.values() for watch in held]
        for watch in watches:
            watch.wake(closing=True)
