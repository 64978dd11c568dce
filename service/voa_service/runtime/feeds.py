"""Who follows sessions: each watched session is read once for all its followers, who take from it at their own pace.

Nothing is buffered for a follower. One that lags behind what is at hand reads the versions between from the store, a
bounded piece at a time; the entrypoint drops one that takes nothing for long.
"""

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass

from voa_service.failures import Failure, Overloaded
from voa_service.runtime.changes import Changes

_POLL_SECONDS = 0.25
"""How late a version may be that another process made, where the database tells nobody."""
_AT_HAND_BYTES = 2**18


@dataclass(frozen=True)
class Version:
    """One version of a session.

    Attributes:
        number: of the version.
        body: the session as JSON.
    """

    number: int
    body: str


Fetch = Callable[[str, int | None], Awaitable[Sequence[Version] | None]]
"""Versions of a session above a number, the oldest first, not all where there are many; None for the number: the
newest alone. None: the session is gone. Raises `Failure` where that cannot be found out at the moment."""


class Feed:
    """The newest versions of one session."""

    def __init__(self, session: str, fetch: Fetch) -> None:
        self.session = session
        self.gone = False
        self.closed = False
        self.followers = 0
        self.turn = asyncio.Event()
        """Set once something has changed; there is another one by then."""
        self._fetch = fetch
        self._at_hand: deque[Version] = deque()
        self._bytes = 0

    def after(self, seen: int) -> Sequence[Version] | None:
        """The versions above `seen`; None: the oldest of them are not at hand, `missed` reads them."""
        if not self._at_hand or self._at_hand[-1].number <= seen:
            return ()
        if self._at_hand[0].number > seen + 1:
            return None
        return [version for version in self._at_hand if version.number > seen]

    async def missed(self, seen: int | None) -> Sequence[Version]:
        """Read versions above `seen` from the store, for one follower; none where that fails for now."""
        try:
            found = await self._fetch(self.session, seen)
        except Failure:
            return ()
        if found is None:
            self._end(gone=True)
        return found or ()

    async def run(self, changes: Changes) -> None:
        """Keep up with the session until it or the service ends."""
        try:
            with changes.watching(self.session) as watch:
                while not (watch.closed or self.gone):
                    newest = self._at_hand[-1].number if self._at_hand else None
                    found = await self.missed(newest)
                    if found:
                        self._add(found)
                    else:
                        await watch.wait(_POLL_SECONDS)
        finally:
            self._end(gone=self.gone)

    def _add(self, found: Sequence[Version]) -> None:
        for version in found:
            self._at_hand.append(version)
            self._bytes += len(version.body)
        while self._bytes > _AT_HAND_BYTES and len(self._at_hand) > 1:
            self._bytes -= len(self._at_hand.popleft().body)
        self._wake()

    def _end(self, *, gone: bool) -> None:
        self.gone = gone
        self.closed = True
        self._wake()

    def _wake(self) -> None:
        """Let whoever waits look again."""
        turn, self.turn = self.turn, asyncio.Event()
        turn.set()


class Feeds:
    """The feeds of all watched sessions; of the event loop that they are used on."""

    def __init__(self, changes: Changes, fetch: Fetch, most: int) -> None:
        self._changes = changes
        self._fetch = fetch
        self._most = most
        self._feeds: dict[str, Feed] = {}
        self._tasks: dict[Feed, asyncio.Task[None]] = {}

    @property
    def watched(self) -> int:
        """Sessions that somebody follows."""
        return len(self._feeds)

    @property
    def followers(self) -> int:
        """Those who follow, all together."""
        return sum(feed.followers for feed in self._feeds.values())

    async def first(self, session: str, seen: int | None) -> Sequence[Version] | None:
        """Read what a new follower gets first: versions above `seen`, or the newest; None: there is no such session.

        Raises:
            Failure: there are too many followers, or the store does not answer.
        """
        if self.followers >= self._most:
            detail = f"{self._most} event streams are open already: try again later, or read the session instead"
            raise Overloaded(detail, {"Retry-After": "5"})
        return await self._fetch(session, seen)

    @asynccontextmanager
    async def following(self, session: str) -> AsyncIterator[Feed]:
        """Count as a follower of a session for the length of a `with`."""
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
