"""Feeds of followed sessions: each is read once for all its followers, who take its versions at their own pace.

A feed keeps the newest versions of its session in memory, and no buffer for each follower. A follower that lags behind
them reads the versions between from the store, a bounded number at a time; the entrypoint drops a follower that takes
nothing for long.
"""

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass

from voa_service.failures import Failure, Overloaded
from voa_service.runtime.changes import Changes

_POLL_SECONDS = 0.25
"""Polling interval for versions that another process made, where the database does not announce its commits."""
_KEPT_BYTES = 2**18


@dataclass(frozen=True)
class Version:
    """A version of a session, as followers receive it.

    Attributes:
        number: of the version.
        body: the session as JSON.
    """

    number: int
    body: str


Fetch = Callable[[str, int | None], Awaitable[Sequence[Version] | None]]
"""Reads versions of a session above a number, the oldest first and not all where there are many; with None for the
number, the newest alone. Returns None where the session does not exist; raises `Failure` where the store does not work.
"""


class Feed:
    """The newest versions of one followed session."""

    def __init__(self, session: str, fetch: Fetch) -> None:
        self.session = session
        self.gone = False
        self.closed = False
        self.followers = 0
        self.turn = asyncio.Event()
        """Set at the next change of this feed, which replaces it by a new event."""
        self._fetch = fetch
        self._kept: deque[Version] = deque()
        self._bytes = 0

    def after(self, seen: int) -> Sequence[Version] | None:
        """Return the versions above `seen`; None where the oldest of them are no longer kept: `missed` reads them."""
        if not self._kept or self._kept[-1].number <= seen:
            return ()
        if self._kept[0].number > seen + 1:
            return None
        return [version for version in self._kept if version.number > seen]

    async def missed(self, seen: int | None) -> Sequence[Version]:
        """Read versions above `seen` from the store, for one follower; none where that fails for now."""
        try:
            versions = await self._fetch(self.session, seen)
        except Failure:
            return ()
        if versions is None:
            self._end(gone=True)
        return versions or ()

    async def run(self, changes: Changes) -> None:
        """Read each new version of the session until it is deleted or the service stops."""
        try:
            with changes.watching(self.session) as watch:
                while not (watch.closed or self.gone):
                    newest = self._kept[-1].number if self._kept else None
                    versions = await self.missed(newest)
                    if versions:
                        self._add(versions)
                    else:
                        await watch.wait(_POLL_SECONDS)
        finally:
            self._end(gone=self.gone)

    def _add(self, versions: Sequence[Version]) -> None:
        for version in versions:
            self._kept.append(version)
            self._bytes += len(version.body)
        while self._bytes > _KEPT_BYTES and len(self._kept) > 1:
            self._bytes -= len(self._kept.popleft().body)
        self._wake()

    def _end(self, *, gone: bool) -> None:
        self.gone = gone
        self.closed = True
        self._wake()

    def _wake(self) -> None:
        """Wake the followers that wait for the next change."""
        turn, self.turn = self.turn, asyncio.Event()
        turn.set()


class Feeds:
    """The feeds of all followed sessions, for use on one event loop.

    Args:
        changes: wakes a feed when its session changes.
        fetch: reads versions from the store.
        most: followers at a time.
    """

    def __init__(self, changes: Changes, fetch: Fetch, most: int) -> None:
        self._changes = changes
        self._fetch = fetch
        self._most = most
        self._feeds: dict[str, Feed] = {}
        self._tasks: dict[Feed, asyncio.Task[None]] = {}

    @property
    def watched(self) -> int:
        """Number of sessions that have a follower."""
        return len(self._feeds)

    @property
    def followers(self) -> int:
        """Number of followers of all sessions."""
        return sum(feed.followers for feed in self._feeds.values())

    async def first(self, session: str, seen: int | None) -> Sequence[Version] | None:
        """Read the first versions for a new follower: those above `seen`, or the newest where `seen` is None.

        Returns:
            The versions; None where the session does not exist.

        Raises:
            Failure: there are too many followers, or the store does not work.
        """
        if self.followers >= self._most:
            detail = f"{self._most} event streams are open already: try again later, or read the session instead"
            raise Overloaded(detail, {"Retry-After": "5"})
        return await self._fetch(session, seen)

    @asynccontextmanager
    async def following(self, session: str) -> AsyncIterator[Feed]:
        """Follow a session within a `with` block."""
        feed = self._feeds.get(session)
        if feed is None or feed.closed:
            feed = self._feeds[session] = Feed(session, self._fetch)
        feed.followers += 1
        if feed.followers == 1:
            self._tasks[feed] = asyncio.create_task(feed.run(self._changes))
        try:
            yield feed
        finally:
            feed.followers -= 1
            if feed.followers == 0:
                self._tasks.pop(feed).cancel()
                if self._feeds.get(session) is feed:
                    del self._feeds[session]
