"""Changes of sessions: announced to listeners, and to watchers that wait for the next change of one session.

A commit of this process wakes the watchers of its session at once. So does a commit of another process if the database
announces it (PostgreSQL does); otherwise it is noticed when the store is polled.
"""

import asyncio
import threading
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from voa_store.records import SessionState

Listener = Callable[[str, SessionState | None], None]
"""Called after each commit of this process with the session's id and its new state, None where it was deleted.

The call comes from any thread and must return quickly.
"""


class Watch:
    """Waits for the next change of a session; belongs to the event loop that made it."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._changed = asyncio.Event()
        self.closed = False

    def wake(self, *, closing: bool = False) -> None:
        """Wake the waiter, from any thread: the session has changed, or the service stops (`closing`)."""
        self.closed = self.closed or closing
        self._loop.call_soon_threadsafe(self._changed.set)

    async def wait(self, seconds: float) -> None:
        """Wait until woken, at most so many seconds; returns at once where a change came since the last wait."""
        try:
            async with asyncio.timeout(seconds):
                await self._changed.wait()
        except TimeoutError:
            return
        self._changed.clear()


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
        """Have `act` called when the service begins to stop, perhaps in a signal handler: it must take no lock."""
        self._at_close.append(act)

    @contextmanager
    def listening(self, listener: Listener) -> Iterator[None]:
        """Have `listener` called with every commit of this process, within a `with` block."""
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    def committed(self, session: str, state: SessionState | None) -> None:
        """Announce a commit of this process: the session's new state, or None where it was deleted."""
        self.changed(session)
        for listener in list(self._listeners):
            listener(session, state)

    @contextmanager
    def watching(self, session: str) -> Iterator[Watch]:
        """Watch a session within a `with` block."""
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

    def changed(self, session: str) -> None:
        """Wake the watchers of a session that has a new version or was deleted, by whichever process."""
        with self._lock:
            watches = list(self._watches.get(session, ()))
        for watch in watches:
            watch.wake()

    def close(self) -> None:
        """Wake every watcher for the last time, as the service stops."""
        for act in self._at_close:
            act()
        with self._lock:
            self._closed = True
            watches = [watch for held in self._watches.values() for watch in held]
        for watch in watches:
            watch.wake(closing=True)
