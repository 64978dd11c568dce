"""Bounded queues of news between a transport's threads and a follower."""

import asyncio
import threading
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from voa_client._transport import Deleted, Hint, Lost, News, State

MOST_NEWS = 1_000
"""Most news of the service that are kept; beyond it the oldest are dropped, so that the newest is never missed."""
MOST_VERSIONS = 256
"""Most versions whose hints are kept."""
MOST_BODIES = 16
"""Most different bodies kept per version; the newest ones, because the true one cannot arrive before its version."""
MOST_BYTES = 32_000_000
"""Most bytes in all bodies of hints together."""


@dataclass(frozen=True)
class Batch:
    """News of a session that arrived since the last batch.

    A hint is a sample on Zenoh, which anyone could have sent: it is not believed until the service confirms it.

    Attributes:
        news: from the service's own connection, in order, with the end of the watch.
        hinted: True if a hint arrived, so that the service should be requested for the current version.
        bodies: by version, the different bodies that claim to be it, in order of arrival.
    """

    news: Sequence[State | Deleted | Lost] = ()
    hinted: bool = False
    bodies: Mapping[int, Sequence[bytes]] = field(default_factory=dict)

    @property
    def is_empty(self) -> bool:
        """True if nothing arrived."""
        return not self.news and not self.hinted


class Pile:
    """News that no follower has taken yet.

    Hints of versions that are known are dropped. Of the others the lowest versions are kept, because the newest version
    is requested from the service; a hint whose body is dropped still causes that request.
    """

    def __init__(self, seen: int | None) -> None:
        self._news: deque[State | Deleted | Lost] = deque(maxlen=MOST_NEWS)
        self._empty(seen)

    def _empty(self, seen: int | None) -> None:
        self._seen = -1 if seen is None else seen
        self._news.clear()
        self._hinted = False
        self._bodies: dict[int, list[bytes]] = {}
        self._bytes = 0

    def __bool__(self) -> bool:
        return self._hinted or bool(self._news)

    def add(self, news: News) -> None:
        """Add a piece of news."""
        if not isinstance(news, Hint):
            self._news.append(news)
        elif news.version is None or news.version > self._seen:
            self._hinted = True
            if news.version is not None and news.body:
                self._keep(news.version, news.body)

    def take(self, seen: int | None) -> Batch:
        """Remove and return all news; from now on hints of versions up to `seen` are dropped."""
        batch = Batch(tuple(self._news), self._hinted, self._bodies)
        self._empty(seen)
        return batch

    def _keep(self, version: int, body: bytes) -> None:
        bodies = self._bodies.get(version, [])
        if body in bodies:
            return
        if len(bodies) >= MOST_BODIES:
            self._bytes -= len(bodies.pop(0))
        while self._bytes + len(body) > MOST_BYTES or (not bodies and len(self._bodies) >= MOST_VERSIONS):
            highest = max(self._bodies, default=version)
            if highest <= version:
                return
            self._bytes -= sum(map(len, self._bodies.pop(highest)))
        self._bodies.setdefault(version, bodies).append(body)
        self._bytes += len(body)


class Mailbox:
    """Queue of news for a follower in a thread."""

    def __init__(self, seen: int | None = None) -> None:
        self._pile = Pile(seen)
        self._arrived = threading.Condition()

    def put(self, news: News) -> None:
        """Add a piece of news; from any thread, without waiting."""
        with self._arrived:
            self._pile.add(news)
            self._arrived.notify()

    def take(self, seconds: float | None, seen: int | None) -> Batch:
        """Wait for news, and return all of it; an empty batch after `seconds` (None: wait without limit).

        Hints of versions up to `seen` are dropped from now on.
        """
        with self._arrived:
            self._arrived.wait_for(lambda: self._pile, seconds)
            return self._pile.take(seen)


class AsyncMailbox:
    """Queue of news for a follower in an event loop, in which it has to be constructed."""

    def __init__(self, seen: int | None = None) -> None:
        self._pile = Pile(seen)
        self._lock = threading.Lock()
        self._loop = asyncio.get_running_loop()
        self._arrived = asyncio.Event()
        self._waking = False

    def put(self, news: News) -> None:
        """Add a piece of news; from any thread, without waiting."""
        with self._lock:
            self._pile.add(news)
            if not self._pile or self._waking:
                return
            self._waking = True
        try:
            self._loop.call_soon_threadsafe(self._arrived.set)
        except RuntimeError:  # the loop is closed, and no follower waits in it
            return

    async def take(self, seconds: float | None, seen: int | None) -> Batch:
        """Wait for news, and return all of it; an empty batch after `seconds` (None: wait without limit).

        Hints of versions up to `seen` are dropped from now on.
        """
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while not self._has_news():
                    await self._arrived.wait()
        with self._lock:
            return self._pile.take(seen)

    def _has_news(self) -> bool:
        with self._lock:
            if not self._pile:
                self._arrived.clear()
                self._waking = False
            return bool(self._pile)
