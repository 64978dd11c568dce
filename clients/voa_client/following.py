"""A session's versions in order, each once, out of news that may be late, double, lost or cut off."""

import asyncio
import threading
from collections import deque

from voa_client.answers import parse
from voa_client.attempts import Patience, worth_another
from voa_client.errors import NotFoundError, TimedOutError, VoaClientError
from voa_client.transport import Deleted, Lost, News, State
from voa_msgs.sessions import Session

_MOST_NEWS = 1_000  # beyond it the oldest go: who reads slowly misses versions, never the newest


class Following:
    """What a follower knows; it says what to do with each piece of news, and how long to wait for the next.

    Args:
        patience: how long to wait for what.
        for_s: when to end; None: with the session.
    """

    def __init__(self, patience: Patience, for_s: float | None) -> None:
        self.seen: int | None = None
        self.ended = False
        self._patience = patience
        self._began = patience.clock()
        self._for_s = for_s
        self._failures = 0
        self._error: VoaClientError = TimedOutError("nothing was heard of the session in time")

    @property
    def left_s(self) -> float | None:
        """Seconds until the end; None: there is none."""
        return None if self._for_s is None else max(0.0, self._began + self._for_s - self._patience.clock())

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to come."""
        return self.ended or self.left_s == 0.0

    def within(self, seconds: float | None) -> float | None:
        """So long, but not beyond the end; None: for ever."""
        left = self.left_s
        if seconds is None or left is None:
            return left if seconds is None else seconds
        return min(seconds, left)

    def take(self, news: State | Deleted) -> Session | None:
        """The session, if it is newer than what was seen."""
        if isinstance(news, Deleted):
            self.ended = True
            return None
        self._failures = 0
        session = parse(Session, news.body)
        if session.version is None or (self.seen is not None and session.version <= self.seen):
            return None
        self.seen = session.version
        return session

    def lost(self, news: Lost) -> float:
        """Seconds to wait before a new watch.

        A service that went away is waited for as long as it takes; one that was never there, as long as a call.

        Raises:
            VoaClientError: there is no use in waiting, or nothing was ever heard within the time of a call.
        """
        error = news.error
        if isinstance(error, NotFoundError) and self.seen is not None:
            self.ended = True
            return 0.0
        late = self._patience.clock() - self._began >= self._patience.timeout_s
        if (late and self.seen is None) or not worth_another(error):
            raise error
        self._error = error
        self._failures += 1
        wait = self._patience.retries.wait_s(self._failures, self._patience.chance())
        return self.within(wait) or 0.0

    def end(self) -> None:
        """The time is over; raises UnreachableError if nothing was ever heard."""
        if self.seen is None and not self.ended:
            raise self._error


class Mailbox:
    """News between threads."""

    def __init__(self) -> None:
        self._held: deque[News] = deque(maxlen=_MOST_NEWS)
        self._arrived = threading.Condition()

    def put(self, news: News) -> None:
        """Never waits."""
        with self._arrived:
            self._held.append(news)
            self._arrived.notify()

    def get(self, seconds: float | None) -> News | None:
        """The oldest; None: nothing came."""
        with self._arrived:
            self._arrived.wait_for(lambda: self._held, seconds)
            return self._held.popleft() if self._held else None


class AsyncMailbox:
    """The same within an event loop."""

    def __init__(self) -> None:
        self._held: deque[News] = deque(maxlen=_MOST_NEWS)
        self._arrived = asyncio.Event()

    def put(self, news: News) -> None:
        """Never waits."""
        self._held.append(news)
        self._arrived.set()

    async def get(self, seconds: float | None) -> News | None:
        """The oldest; None: nothing came."""
        try:
            async with asyncio.timeout(seconds):
                while not self._held:
                    self._arrived.clear()
                    await self._arrived.wait()
        except TimeoutError:
            return None
        return self._held.popleft()
