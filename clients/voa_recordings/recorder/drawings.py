"""Drawing of each version of the recorded sessions, in a thread of its own, which may wait for the service."""

import queue
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Literal

from rosbags.typesys.store import Typestore

from voa_client import Client, VoaClientError
from voa_msgs.geometry import CandidateSensor, SensorConfiguration
from voa_msgs.rankings import Ranking, RankingRequest
from voa_msgs.scenarios import PredictionsRequest, Scenario
from voa_msgs.sessions import HistoryEntry
from voa_recordings.recorder.inbox import Inbox, VersionOfSession
from voa_recordings.scenes.model_file import IndexedMesh, indexed_mesh
from voa_recordings.scenes.versions import Version, messages_of, taken_scan
from voa_ros.messages import NANOSECONDS
from voa_scene.views import TakenScan

Ranked = Literal["sparingly", "always", "never"]
"""Versions whose places are ranked: as many as keep the service busy for a tenth of the time, all, or none."""

MOST_FACES = 1_000
"""Faces of the mesh in a scene, about: enough for a ghost on a screen, and 20 kB a scene."""
_REST = 9
"""Times that a ranking and a prediction took, for which the service rests after them."""
_MOST_PAUSE_S = 5.0
_MOST_BEHIND = 100
"""Versions to be drawn above which none is ranked."""
_BEFORE_NS = 3_600 * NANOSECONDS
_END_S = 10.0


@dataclass(frozen=True)
class _Wanted:
    session: str
    scenario: Scenario
    entry: HistoryEntry
    newest: bool


class Drawings:
    """Drawer of versions, which puts the messages that show them into the inbox.

    A ranking costs the service as much as a robot's, for large scenarios seconds, and a recorder must not slow the
    robots down that it records. So rankings and predicted outlines keep the service busy for at most a tenth of the
    time; a version for which that would mean to wait for more than five seconds is drawn without them.

    Attributes:
        failed: per session, why the newest version that is not shown, or not completely, is not.
        unranked: per session, the number of versions without a ranking, to spare the service or because the recording
            ended.
    """

    def __init__(
        self,
        client: Client,
        inbox: Inbox,
        store: Typestore,
        now_ns: Callable[[], int],
        ranked: Ranked = "sparingly",
    ) -> None:
        """Draw with the types of `store`; the clock `now_ns` gives nanoseconds since 1970."""
        self.failed: dict[str, str] = {}
        self.unranked: Counter[str] = Counter()
        self._client = client
        self._inbox = inbox
        self._store = store
        self._now_ns = now_ns
        self._ranked = ranked
        self._start_ns = now_ns()
        self._wanted: queue.SimpleQueue[_Wanted | None] = queue.SimpleQueue()
        self._meshes: dict[str, IndexedMesh] = {}
        self._scans: dict[str, TakenScan] = {}
        self._rests_until_ns = 0
        self._ending = threading.Event()
        self._drawing: _Wanted | None = None
        self._is_left = False
        self._thread = threading.Thread(target=self._run, name="voa-drawings", daemon=True)

    def start(self) -> None:
        """Start the thread that draws."""
        self._thread.start()

    def want(self, session: str, scenario: Scenario, entry: HistoryEntry, *, newest: bool) -> None:
        """Draw a version soon; from any thread, returns at once. Versions of a session are given in order.

        Args:
            session: its identifier.
            scenario: of the session.
            entry: of the history, with its belief.
            newest: True if the session has no later version yet.
        """
        self._wanted.put(_Wanted(session, scenario, entry, newest))

    def end(self) -> None:
        """Draw the versions that are still wanted, after ten seconds without rankings, and end the thread."""
        self._ending.set()
        self._wanted.put(None)
        self._thread.join(_END_S)
        if not self._thread.is_alive():
            return
        self._is_left = True  # the thread waits for a response, and is left to it
        if self._drawing is not None:
            self._attempt(self._drawing, with_details=False)
        with suppress(queue.Empty):
            while (wanted := self._wanted.get_nowait()) is not None:
                self._attempt(wanted, with_details=False)

    def _run(self) -> None:
        while not self._is_left and (wanted := self._wanted.get()) is not None:
            self._drawing = wanted
            self._attempt(wanted, with_details=self._ranked != "never")
            self._drawing = None

    def _attempt(self, wanted: _Wanted, *, with_details: bool) -> None:
        try:
            self._draw(wanted, with_details=with_details)
        except Exception as error:  # a recording goes on, whatever a service of another version responds
            self.failed[wanted.session] = (
                f"version {wanted.entry.version} cannot be drawn ({type(error).__name__}: {error})"
            )

    def _draw(self, wanted: _Wanted, *, with_details: bool) -> None:
        session, entry = wanted.session, wanted.entry
        if entry.belief is None:
            self.failed[session] = "the service is of a version whose history has no beliefs"
            return
        self.failed.pop(session, None)
        taken = taken_scan(wanted.scenario, entry)
        if taken is not None:
            self._scans[session] = taken
        version = Version(session, wanted.scenario, entry, self._scans.get(session))
        if with_details:
            version = self._with_details(wanted, version)
            if self._is_left:
                return
        elif self._ranked != "never":
            self.unranked[session] += 1
        self._fetch_mesh(session, wanted.scenario)
        at_ns = self._time(entry.at)
        for message in messages_of(self._store, version, self._meshes, at_ns):
            self._inbox.put(VersionOfSession(session, message.what, message.type_name, message.data, at_ns))

    def _with_details(self, wanted: _Wanted, version: Version) -> Version:
        """Add ranking and predicted outline, unless they would cost the service too much."""
        session = wanted.session
        if self._ranked == "sparingly" and not self._rested():
            self.unranked[session] += 1
            return version
        start_ns = self._now_ns()
        try:
            version = replace(version, ranking=self._ranking(wanted))
            version = replace(version, taken=self._predicted(wanted, version.taken))
        except VoaClientError as error:
            self.failed[session] = f"the service ranks no places for it: {error}"
        end_ns = self._now_ns()
        self._rests_until_ns = end_ns + _REST * (end_ns - start_ns)
        return version

    def _rested(self) -> bool:
        """Wait until the service has rested; False if that takes too long, or the recording ends."""
        pause_s = max(self._rests_until_ns - self._now_ns(), 0) / NANOSECONDS
        if pause_s > _MOST_PAUSE_S or self._wanted.qsize() > _MOST_BEHIND:
            return False
        return not self._ending.wait(pause_s)

    def _ranking(self, wanted: _Wanted) -> Ranking:
        """Rank for the session if its version is the newest, with looks taken and under way; else for the belief."""
        entry = wanted.entry
        if wanted.newest:
            ranking = self._client.rank_looks(wanted.session)
            if ranking.version == entry.version:
                return ranking
        request = RankingRequest(scenario=wanted.scenario.id, belief=entry.belief, absent=entry.absent)
        return self._client.rank_once(request)

    def _predicted(self, wanted: _Wanted, taken: TakenScan | None) -> TakenScan | None:
        """Add the scan that the likeliest pose predicts to the newest scan."""
        belief = wanted.entry.belief
        if taken is None or belief is None:
            return taken
        place = taken.place
        look: str | CandidateSensor = (
            place.name
            if isinstance(place, SensorConfiguration)
            else CandidateSensor(x=place.x, y=place.y, yaw_rad=place.yaw_rad, height_m=place.height_m)
        )
        predictions = self._client.predict(wanted.scenario.id, PredictionsRequest(sensors=[look]))
        return replace(taken, predicted=predictions.ranges[0][belief.index(max(belief))])

    def _fetch_mesh(self, session: str, scenario: Scenario) -> None:
        name = scenario.object
        if name is None or name in self._meshes:
            return
        try:
            self._meshes[name] = indexed_mesh(self._client.object_mesh(name, MOST_FACES))
        except (VoaClientError, ValueError) as error:
            self.failed[session] = f"the mesh of its object could not be fetched: {error}"

    def _time(self, at: datetime) -> int:
        """Return the time of a version, at most an hour before the recording began, and not in the future.

        A session may be days old, and a time line of days hides the minutes that were recorded.
        """
        at_ns = int((at - datetime(1970, 1, 1, tzinfo=UTC)).total_seconds() * NANOSECONDS)
        return min(max(at_ns, self._start_ns - _BEFORE_NS), self._now_ns())
