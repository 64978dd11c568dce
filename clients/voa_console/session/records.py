"""Record of a session: what all its open pages share, requested from the service once per version."""

import asyncio
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Hashable
from typing import Any, TypeVar, cast

from voa_client import AsyncClient
from voa_msgs.geometry import CandidateSensor
from voa_msgs.rankings import Look, RankedSensor, Ranking, VoaRequest
from voa_msgs.scenarios import Predictions, PredictionsRequest
from voa_msgs.sessions import HistoryEntry, ScanRequest

T = TypeVar("T")
_MOST_KEPT = 16
"""Most results of each session, such as predictions for past scans."""
MOST_RECORDS = 16
"""Most sessions whose records are kept beside those of open pages."""


class SessionRecord:
    """Facts about a session beside those of the hub: its history, grasps, and predictions for its scans.

    Args:
        session_id: of the session.
        client: of the service.
    """

    def __init__(self, session_id: str, client: AsyncClient) -> None:
        self._id = session_id
        self._client = client
        self._history: list[HistoryEntry] = []
        self._history_lock = asyncio.Lock()
        self._kept: OrderedDict[Hashable, asyncio.Task[Any]] = OrderedDict()

    async def history(self, version: int) -> list[HistoryEntry]:
        """Return the history with beliefs up to at least `version`; only versions that are not known yet are read.

        Raises:
            VoaClientError: the service did not return it.
        """
        async with self._history_lock:
            if self._history and self._history[-1].version >= version:
                return self._history
            known = self._history[-1].version if self._history else -1
            new = [entry async for entry in self._client.history(self._id, beliefs=True, after=known)]
            self._history = [*self._history, *new]
            return self._history

    async def grasps(self, version: int) -> list[tuple[str, float]]:
        """Return the grasps with their expected scores at the newest version, the best first; raises VoaClientError."""

        async def fetch() -> list[tuple[str, float]]:
            ranked = await self._client.rank_grasps(self._id)
            return [(grasp.name, grasp.expected_score) for grasp in ranked.grasps]

        return await self._once(("grasps", version), fetch)

    async def outcomes(self, ranking: Ranking) -> RankedSensor | None:
        """Return the row of the recommended single look with its expected results; None: no look is recommended.

        Raises:
            VoaClientError: the service did not rank it.
        """
        recommended = ranking.recommendation
        if not isinstance(recommended, Look) or recommended.then is not None:
            return None
        request = VoaRequest(sensors=[recommended.sensor], outcomes=True, lookahead=1)

        async def fetch() -> RankedSensor:
            return (await self._client.rank_looks(self._id, request)).ranking[0]

        return await self._once(("outcomes", ranking.version, recommended.sensor), fetch)

    async def predictions(self, scenario_id: str, version: int, request: ScanRequest) -> Predictions:
        """Return the scans that each pose would give at the place of a scan; raises VoaClientError.

        Args:
            scenario_id: of the scenario.
            version: that the scan made.
            request: the scan with its place.
        """
        pose = request.sensor_pose
        sensor = (
            request.sensor or ""
            if pose is None
            else CandidateSensor(x=pose.x, y=pose.y, yaw_rad=pose.yaw_rad, height_m=pose.height_m)
        )
        return await self._once(
            ("predictions", version),
            lambda: self._client.predict(scenario_id, PredictionsRequest(sensors=[sensor])),
        )

    async def _once(self, key: Hashable, fetch: Callable[[], Awaitable[T]]) -> T:
        """Fetch a result once, however many pages wait for it; a failure is not kept."""
        task = self._kept.get(key)
        if task is None or (task.done() and (task.cancelled() or task.exception() is not None)):
            task = asyncio.ensure_future(fetch())
            self._kept[key] = task
            while len(self._kept) > _MOST_KEPT:
                self._kept.popitem(last=False)
        self._kept.move_to_end(key)
        return cast(T, await asyncio.shield(task))


class Records:
    """Records of sessions, the least recently used of which are dropped.

    Args:
        client: of the service.
        most: most records.
    """

    def __init__(self, client: AsyncClient, most: int = MOST_RECORDS) -> None:
        self._client = client
        self._most = most
        self._records: OrderedDict[str, SessionRecord] = OrderedDict()

    def of(self, session_id: str) -> SessionRecord:
        """Return the record of a session, which all its pages share."""
        if session_id not in self._records:
            self._records[session_id] = SessionRecord(session_id, self._client)
        self._records.move_to_end(session_id)
        while len(self._records) > self._most:
            self._records.popitem(last=False)
        return self._records[session_id]
