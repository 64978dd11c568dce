"""A session that is followed once, however many pages show it."""

import asyncio
from collections.abc import Awaitable, Callable

from voa_client import (
    AsyncClient,
    DeniedError,
    HistoryEntry,
    NotFoundError,
    Ranking,
    Scenario,
    Session,
    VoaClientError,
)
from voa_console.watching.news import Callback, News

_AGAIN_S = 1.0
"""Pause before a session is followed again that could not be, seconds."""
_DENIED_AGAIN_S = 10.0
"""Pause before a session is followed again that the key may not see, seconds."""


class WatchedSession:
    """Session that is followed while somebody subscribes to it.

    Args:
        session_id: of the session.
        client: of the service.
        scenario_of: returns the scenario with an identifier.
    """

    def __init__(self, session_id: str, client: AsyncClient, scenario_of: Callable[[str], Awaitable[Scenario]]) -> None:
        self.id = session_id
        self.session: Session | None = None
        """Newest version; None: not received yet."""
        self.scenario: Scenario | None = None
        """Scenario of the session; None: not received yet."""
        self.newest: HistoryEntry | None = None
        """Newest entry of the history that was no look, as far as it is known."""
        self.ended = False
        """True if the session was deleted, or never existed."""
        self.error: VoaClientError | None = None
        """Reason why the session cannot be followed at the moment; None: it is followed."""
        self._client = client
        self._scenario_of = scenario_of
        self._news = News()
        self._first = asyncio.Event()
        self._follower: asyncio.Task[None] | None = None
        self._reader: asyncio.Task[None] | None = None
        self._others = 0
        self._ranking: tuple[int, asyncio.Task[Ranking]] | None = None

    @property
    def is_followed(self) -> bool:
        """True if somebody subscribes."""
        return len(self._news) > 0

    def subscribe(self, callback: Callback) -> Callback:
        """Call `callback` at each new version, and at the end; return the function that ends the subscription."""
        leave = self._news.subscribe(callback)
        if self._follower is None and not self.ended:
            self._follower = asyncio.create_task(self._follow(), name=f"voa-console-{self.id}")

        def unsubscribe() -> None:
            leave()
            if not self.is_followed:
                self.close()

        return unsubscribe

    def close(self) -> None:
        """Stop following; a new subscription starts it again."""
        for task in (self._follower, self._reader):
            if task is not None:
                task.cancel()
        self._follower = self._reader = None

    async def ready(self) -> bool:
        """Wait for the first version while somebody subscribes; return False if there is no such session."""
        await self._first.wait()
        return not self.ended

    async def ranking(self) -> Ranking:
        """Rank the places of the scenario at the present version, once for all pages.

        Raises:
            VoaClientError: the service did not rank them.
        """
        await self.ready()
        version = -1 if self.session is None else self.session.version or 0
        if self._ranking is None or self._ranking[0] != version or _failed(self._ranking[1]):
            self._ranking = (version, asyncio.create_task(self._client.rank_looks(self.id)))
        return await asyncio.shield(self._ranking[1])

    async def _follow(self) -> None:
        """Follow the session until it is deleted, however often the service goes away."""
        while not self.ended:
            try:
                async for session in self._client.follow(self.id):
                    if self.scenario is None:
                        self.scenario = await self._scenario_of(session.scenario)
                    self.error = None
                    self._change(session)
                self.end()
            except NotFoundError:
                self.end()
            except VoaClientError as error:
                self.error = error
                self._news.publish()
                await asyncio.sleep(pause_after(error))

    def _change(self, session: Session) -> None:
        self.session = session
        self._read_others(session)
        self._first.set()
        self._news.publish()

    def _read_others(self, session: Session) -> None:
        """Read the newest entry of the history, unless the looks of the session explain all its new versions."""
        version = session.version or 0
        others = version - sum(place.looks for place in session.places)
        if others == self._others:
            return
        self._others = others
        if self._reader is not None:
            self._reader.cancel()
        self._reader = asyncio.create_task(self._read(version), name=f"voa-console-history-{self.id}")

    async def _read(self, version: int) -> None:
        try:
            async for entry in self._client.history(self.id, after=version - 1):
                self.newest = entry
        except VoaClientError:
            self._others = -1  # to be read with the next version; until then the pages say less
            return
        self._news.publish()

    def end(self) -> None:
        """Note that the session was deleted."""
        self.ended = True
        self._first.set()
        self._news.publish()


def pause_after(error: VoaClientError) -> float:
    """Return the pause before a session is followed again, seconds; longer where the key may not see it."""
    return _DENIED_AGAIN_S if isinstance(error, DeniedError) else _AGAIN_S


def _failed(ranking: asyncio.Task[Ranking]) -> bool:
    return ranking.done() and (ranking.cancelled() or ranking.exception() is not None)
