"""The hub of a console: sessions, robots and the service itself, watched once for all open pages."""

import asyncio
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime, timedelta

from voa_client import AsyncClient, Caller, RobotReport, Scenario, SessionSummary, UsageError, VoaClientError
from voa_console.sentences import needs_key
from voa_console.watching.news import Callback, News
from voa_console.watching.refusals import refusal_of
from voa_console.watching.watched import WatchedSession

POLL_S = 1.0
"""Seconds between two requests for robots and sessions, while a page is open."""
_PAUSE_S_PER_SESSION = 0.001
"""Least pause between two requests for the list, for each session in it, seconds. A session in a list costs the service
32 microseconds of a core, so that the list takes at most 3.2 per cent of one."""
MOST_FOLLOWED = 32
"""Most sessions that are followed because they moved lately; further ones are shown as the list has them."""


MOVING = timedelta(seconds=60.0)
"""Age of the newest version up to which a session counts as one that moves."""


MOST_SCENARIOS = 64
"""Most scenarios that are kept."""


def _has_failed(task: asyncio.Task[Scenario]) -> bool:
    """True if a request has ended without a scenario."""
    return task.done() and (task.cancelled() or task.exception() is not None)


class Hub:
    """Sessions and robots of a service, requested and followed once for all pages.

    Nothing is requested while no page is open.

    Args:
        client: of the service.
        recent_s: seconds for which a session is shown after its newest version.
        poll_s: seconds between two requests for the reports of robots, and for the sessions if these are few.
        clock: returns seconds that never go back.
        utc: returns the time of this machine.
    """

    def __init__(
        self,
        client: AsyncClient,
        recent_s: float = 3600.0,
        *,
        poll_s: float = POLL_S,
        clock: Callable[[], float] = time.monotonic,
        utc: Callable[[], datetime] = lambda: datetime.now(UTC),
    ) -> None:
        self.error: VoaClientError | None = None
        """Reason why the service does not respond at the moment; None: it does."""
        self.has_responded = False
        """True if the service has responded since the console started."""
        self.caller: Caller | None = None
        """Caller that the service takes this console for; None: not known, or the service does not accept the key."""
        self.identified_s = float("-inf")
        """Time at which the caller was identified last, by `clock`."""
        self.mapping_error: str | None = None
        """Reason why the service cannot use its mapping file of robots; None: it can."""
        self._client = client
        self._recent = timedelta(seconds=recent_s)
        self._poll_s = poll_s
        self._clock = clock
        self._utc = utc
        self._ahead = timedelta()
        self._list_due_s = float("-inf")
        self._news = News()
        self._pages = 0
        self._has_pages = asyncio.Event()
        self._has_no_pages = asyncio.Event()
        self._has_no_pages.set()
        self._summaries: list[SessionSummary] = []
        self._reports: list[RobotReport] = []
        self._watched: dict[str, WatchedSession] = {}
        self._recents: dict[str, Callback] = {}
        self._scenarios: dict[str, asyncio.Task[Scenario]] = {}

    async def identify(self) -> Caller:
        """Request from the service who the caller is, and what it may do.

        Raises:
            VoaClientError: the service does not accept the key, or does not respond.
        """
        try:
            self.caller = await self._client.caller()
        except VoaClientError as error:
            self._note(error)
            raise
        self.identified_s = self._clock()
        if needs_key(self.error):
            self.error = None
        return self.caller

    def _note(self, error: VoaClientError) -> None:
        """Note why a call failed; forget what was received if the key is no longer accepted."""
        self.error = error
        if needs_key(error):
            self.caller = None
            self._summaries, self._reports = [], []
            self._follow([])

    def sessions(self) -> list[SessionSummary]:
        """List the sessions that moved in the last hour, the one that moved last first.

        Those that moved in the last minute stand in the order in which they were opened, the newest first: they would
        change places all the time.
        """
        now = self.now()
        ended = {each for each, watched in self._watched.items() if watched.ended}
        recent = [
            each for each in reversed(self._summaries) if each.updated_at >= now - self._recent and each.id not in ended
        ]
        return sorted(recent, key=lambda each: min(each.updated_at, now - MOVING), reverse=True)

    def robots(self) -> list[RobotReport]:
        """List the newest reports of all robots."""
        return self._reports

    def robots_of(self, session_id: str) -> list[RobotReport]:
        """List the newest reports of the robots whose scans are applied to a session."""
        return [report for report in self._reports if report.session == session_id]

    def refusal_of(self, report: RobotReport) -> str | None:
        """Return why the scans of a robot are refused at the moment; None: they are not."""
        return refusal_of(report, self.now())

    def now(self) -> datetime:
        """Return the time by the clock of the service, UTC."""
        return self._utc() + self._ahead

    def subscribe(self, callback: Callback) -> Callback:
        """Call `callback` when a list, a followed session or the state of the service changed, and every second.

        Returns:
            The function that ends the subscription.
        """
        return self._news.subscribe(callback)

    def watch(self, session_id: str) -> WatchedSession:
        """Return a session as all pages share it; it is followed while somebody subscribes to it."""
        if session_id not in self._watched:
            self._watched[session_id] = WatchedSession(session_id, self._client, self.scenario)
        return self._watched[session_id]

    def followed(self, session_id: str) -> WatchedSession | None:
        """Return a session if it is followed already; None: it is not."""
        return self._watched.get(session_id)

    async def scenario(self, scenario_id: str) -> Scenario:
        """Return a scenario, which is requested once; raises VoaClientError if that fails."""
        task = self._scenarios.get(scenario_id)
        if task is None or _has_failed(task):
            task = self._request_scenario(scenario_id)
        return await asyncio.shield(task)

    def known_scenario(self, scenario_id: str) -> Scenario | None:
        """Return a scenario if it is known; None: it is not, and is requested if it was not yet."""
        task = self._scenarios.get(scenario_id)
        if task is None or (_has_failed(task) and self.error is None):
            task = self._request_scenario(scenario_id)
            task.add_done_callback(lambda _: self._news.publish_soon())
        return None if not task.done() or _has_failed(task) else task.result()

    def _request_scenario(self, scenario_id: str) -> asyncio.Task[Scenario]:
        """Request a scenario, and forget the one that was requested first if there are many."""
        task = asyncio.create_task(self._client.get_scenario(scenario_id))
        self._scenarios.pop(scenario_id, None)
        self._scenarios[scenario_id] = task
        while len(self._scenarios) > MOST_SCENARIOS:
            del self._scenarios[next(iter(self._scenarios))]
        return task

    def open_page(self) -> Callback:
        """Count a page as open; return the function that counts it as closed."""
        self._pages += 1
        self._has_pages.set()
        self._has_no_pages.clear()
        is_open = True

        def close() -> None:
            nonlocal is_open
            if is_open:
                is_open = False
                self._pages -= 1
                if self._pages == 0:
                    self._has_pages.clear()
                    self._has_no_pages.set()

        return close

    async def has_no_pages(self) -> None:
        """Wait until no page is open."""
        await self._has_no_pages.wait()

    async def run(self) -> None:
        """Request the lists, while a page is open, until this is cancelled."""
        try:
            while True:
                if not self._has_pages.is_set():
                    self._follow([])
                    await self._has_pages.wait()
                    self._list_due_s = self._clock()
                await self._poll()
                with suppress(TimeoutError):
                    async with asyncio.timeout(self._poll_s):
                        await self._has_no_pages.wait()
        finally:
            self._follow([])
            for watched in self._watched.values():
                watched.close()

    async def _poll(self) -> None:
        """Request the reports of robots, and the list of sessions when it is due."""
        try:
            if self.error is not None or not self.has_responded:
                await self._compare_clocks()
                await self.identify()
            robots = await self._client.robots()
            if self._clock() >= self._list_due_s:
                await self._list()
        except VoaClientError as error:
            self._note(error)
        else:
            self.error, self.has_responded = None, True
            self.mapping_error = robots.mapping_error
            self._reports = robots.items
        self._news.publish()

    async def _list(self) -> None:
        """Request the list of sessions; the longer it is, the longer until it is requested again."""
        self._summaries = [summary async for summary in self._client.list_sessions()]
        self._list_due_s = self._clock() + max(self._poll_s / 2.0, _PAUSE_S_PER_SESSION * len(self._summaries))
        for deleted in self._recents.keys() - {summary.id for summary in self._summaries}:
            self._watched[deleted].end()  # the list may know it before the follower, which is stopped below
        newest = sorted(self.sessions(), key=lambda summary: summary.updated_at, reverse=True)
        self._follow([summary.id for summary in newest[:MOST_FOLLOWED]])

    async def _compare_clocks(self) -> None:
        """Note how far the clock of the service is ahead of this machine's; unknown over Zenoh, which has no call."""
        try:
            health = await self._client.health()
        except UsageError:
            return
        if health.now is not None:
            self._ahead = health.now - self._utc()

    def _follow(self, session_ids: list[str]) -> None:
        """Follow these sessions besides those that pages subscribe to, and no others."""
        for gone in self._recents.keys() - set(session_ids):
            self._recents.pop(gone)()
        for session_id in session_ids:
            if session_id not in self._recents:
                self._recents[session_id] = self.watch(session_id).subscribe(self._news.publish_soon)
        for unused in [each for each, watched in self._watched.items() if not watched.is_followed]:
            if unused not in session_ids:
                del self._watched[unused]
