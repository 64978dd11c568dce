"""Gathering of the facts that a page shows: at once what is known, then what the service is requested for."""

from collections.abc import Callable, Sequence
from functools import partial

from voa_client import VoaClientError
from voa_console.session.coalescing import Coalesced, Work
from voa_console.session.facts import Facts, newest_scan, scan_request, taken_scan
from voa_console.session.grasp_scores import expected_scores
from voa_console.session.moments import moment_at
from voa_console.session.records import SessionRecord
from voa_console.watching.watched import WatchedSession
from voa_msgs.rankings import RankedSensor, Ranking
from voa_msgs.robots import RobotReport
from voa_msgs.sessions import HistoryEntry
from voa_scene.views import TakenScan

Show = Callable[[Facts], None]
"""Function that shows facts."""
Fail = Callable[[VoaClientError], None]
"""Function that shows why the places are not ranked."""


class Gathering:
    """Facts of one page, gathered again when the session changes or the person chooses another version.

    Args:
        watched: the session, which all pages share.
        record: of the session, which all pages share.
        robots: returns the newest reports of the robots of the session.
        show: shows facts; it is called several times for a version, as facts arrive.
        fail: shows why the places are not ranked.
    """

    def __init__(
        self,
        watched: WatchedSession,
        record: SessionRecord,
        robots: Callable[[], Sequence[RobotReport]],
        show: Show,
        fail: Fail,
    ) -> None:
        self.facts: Facts | None = None
        """Facts that the page shows; None: nothing was received yet."""
        self._watched = watched
        self._record = record
        self._robots = robots
        self._show = show
        self._fail = fail
        self._chosen: int | None = None
        self._history: Sequence[HistoryEntry] = ()
        self._ranking: Ranking | None = None
        self._outcomes: RankedSensor | None = None
        self._grasps: tuple[int, Sequence[tuple[str, float]]] = (-1, ())
        self._taken: dict[int, TakenScan | None] = {}
        self._parts = (
            Coalesced(partial(self._get, self._get_grasps), "voa-console-grasps"),
            Coalesced(self._get_past, "voa-console-history"),
            Coalesced(self._get_advice, "voa-console-advice"),
        )

    def choose(self, version: int | None) -> None:
        """Show a past version; None: the newest one, and each that follows it."""
        self._chosen = version
        self.show()
        self.gather()

    def show(self) -> None:
        """Show what is known."""
        session, scenario = self._watched.session, self._watched.scenario
        if session is None or scenario is None:
            return
        moment = moment_at(self._chosen, session, self._history)
        if moment.is_past:
            grasps: Sequence[tuple[str, float]] = expected_scores(scenario, moment.belief)
        else:
            grasps = self._grasps[1]
        scan = newest_scan(self._history, moment.version)
        taken = None if scan is None else self._taken.get(moment.version)
        self.facts = Facts(
            scenario,
            session,
            moment,
            self._history,
            self._ranking,
            self._outcomes,
            grasps,
            taken,
            tuple(self._robots()),
        )
        self._show(self.facts)

    def gather(self) -> None:
        """Request what is missing, in the background; each part is shown as it arrives."""
        for part in self._parts:
            part.request()

    async def _get_advice(self) -> None:
        """Rank the places, and then the possible results of the look that is recommended."""
        try:
            ranking = await self._watched.ranking()
            if ranking is not self._ranking:
                self._ranking, self._outcomes = ranking, None
            self.show()
            self._outcomes = await self._record.outcomes(ranking)
            self.show()
        except VoaClientError as error:
            if not self._watched.ended:
                self._fail(error)

    async def _get_past(self) -> None:
        """Read the history, and put the newest scan at the moment together."""
        await self._get(self._get_history)
        await self._get(self._get_taken)

    async def _get(self, part: Work) -> None:
        """Request a part; without it, the page shows the others, and the banner says that the service is away."""
        try:
            await part()
        except VoaClientError:
            return
        self.show()

    async def _get_history(self) -> None:
        self._history = await self._record.history(self._newest)

    async def _get_grasps(self) -> None:
        version = self._newest
        self._grasps = (version, await self._record.grasps(version))

    async def _get_taken(self) -> None:
        """Put the newest scan at the moment, its place and the predicted outline together."""
        facts = self.facts
        scan = None if facts is None else newest_scan(self._history, facts.moment.version)
        if facts is None or scan is None:
            return
        request = scan_request(scan)
        self._taken = {facts.moment.version: taken_scan(request, facts.scenario, facts.moment.belief, None)}
        self.show()
        if facts.scenario.object is not None:
            predictions = await self._record.predictions(facts.scenario.id, scan.version, request)
            taken = taken_scan(request, facts.scenario, facts.moment.belief, predictions)
            self._taken = {facts.moment.version: taken}

    @property
    def _newest(self) -> int:
        return 0 if self._watched.session is None else self._watched.session.version or 0
