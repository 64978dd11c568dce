"""The role of the robot that carries the lidar: where to look, drive there, send what was seen."""

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass

from voa_client._async_client import AsyncClient
from voa_client._client import Client
from voa_msgs.geometry import Candidate, CandidateSensor, SensorPose, UncertainSensorPose
from voa_msgs.rankings import GraspNow, Look, VoaRequest
from voa_msgs.sessions import Scan, ScanRequest, UpdatedSession

MOST_LOOKS = 10


@dataclass(frozen=True)
class TakenLook:
    """A look: from where, and what it did to the session."""

    sensor: str
    after: UpdatedSession


@dataclass(frozen=True)
class Tour:
    """What a drive came to.

    Attributes:
        looks: in the order in which they were taken.
        advice: what the service recommends now: to grasp, or, where the looks were used up, to look on.
    """

    looks: tuple[TakenLook, ...]
    advice: Look | GraspNow


class SensorClient:
    """The lidar robot's side of one session.

    Args:
        client: of the service; it stays the caller's.
        session_id: which session.
    """

    def __init__(self, client: Client, session_id: str) -> None:
        self._client = client
        self._session = session_id

    def where_to_look(
        self, reachable: Sequence[Candidate] | None = None, grasps: Sequence[str] | None = None
    ) -> Look | GraspNow:
        """The look that is worth most, or to grasp now because none is worth its cost.

        Args:
            reachable: where the robot can stand now: names of the scenario's configurations, or poses of the lidar;
                None: all of the scenario's.
            grasps: what the arm can reach now; None: all.
        """
        return self._client.rank_looks(self._session, _asked(reachable, grasps)).recommendation

    def send_scan(
        self,
        scan: Scan,
        sensor: str | None = None,
        sensor_pose: UncertainSensorPose | None = None,
        *,
        key: str | None = None,
    ) -> UpdatedSession:
        """Update the session by a scan that was taken at a configuration, or at any pose: one of the two.

        With a `key` of its own, the same scan can be sent again later, and takes effect once.
        """
        request = ScanRequest(sensor=sensor, sensor_pose=sensor_pose, scan=scan)
        return self._client.apply_scan(self._session, request, key=key)

    def run(
        self,
        drive: Callable[[str], None],
        take_scan: Callable[[], Scan],
        reachable: Sequence[Candidate] | None = None,
        most_looks: int = MOST_LOOKS,
    ) -> Tour:
        """Look where it is worth most, again and again, until grasping is better.

        Args:
            drive: brings the lidar to a configuration, or to a pose of `reachable` (by its name, or its index);
                returns when it is there.
            take_scan: one scan, or the median of several, from where the lidar is.
            reachable: as in `where_to_look`.
            most_looks: a scan that is not accepted counts too.
        """
        looks: list[TakenLook] = []
        advice = self.where_to_look(reachable)
        while isinstance(advice, Look) and len(looks) < most_looks:
            drive(advice.sensor)
            request = _taken(take_scan(), advice.sensor, reachable)
            looks.append(TakenLook(advice.sensor, self._client.apply_scan(self._session, request)))
            advice = self.where_to_look(reachable)
        return Tour(tuple(looks), advice)


class AsyncSensorClient:
    """The same for asyncio."""

    def __init__(self, client: AsyncClient, session_id: str) -> None:
        self._client = client
        self._session = session_id

    async def where_to_look(
        self, reachable: Sequence[Candidate] | None = None, grasps: Sequence[str] | None = None
    ) -> Look | GraspNow:
        """As in `SensorClient`."""
        return (await self._client.rank_looks(self._session, _asked(reachable, grasps))).recommendation

    async def send_scan(
        self,
        scan: Scan,
        sensor: str | None = None,
        sensor_pose: UncertainSensorPose | None = None,
        *,
        key: str | None = None,
    ) -> UpdatedSession:
        """As in `SensorClient`."""
        request = ScanRequest(sensor=sensor, sensor_pose=sensor_pose, scan=scan)
        return await self._client.apply_scan(self._session, request, key=key)

    async def run(
        self,
        drive: Callable[[str], Awaitable[None]],
        take_scan: Callable[[], Awaitable[Scan]],
        reachable: Sequence[Candidate] | None = None,
        most_looks: int = MOST_LOOKS,
    ) -> Tour:
        """As in `SensorClient`."""
        looks: list[TakenLook] = []
        advice = await self.where_to_look(reachable)
        while isinstance(advice, Look) and len(looks) < most_looks:
            await drive(advice.sensor)
            request = _taken(await take_scan(), advice.sensor, reachable)
            looks.append(TakenLook(advice.sensor, await self._client.apply_scan(self._session, request)))
            advice = await self.where_to_look(reachable)
        return Tour(tuple(looks), advice)


def _asked(reachable: Sequence[Candidate] | None, grasps: Sequence[str] | None) -> VoaRequest:
    """The ranking to ask for."""
    sensors = None if reachable is None else list(reachable)
    return VoaRequest(sensors=sensors, grasps=None if grasps is None else list(grasps))


def _taken(scan: Scan, name: str, reachable: Sequence[Candidate] | None) -> ScanRequest:
    """A scan with where it was taken: a pose that the scenario does not know goes along."""
    for index, candidate in enumerate(reachable or ()):
        if isinstance(candidate, CandidateSensor) and name == (candidate.name or str(index)):
            pose = UncertainSensorPose(**candidate.model_dump(include=set(SensorPose.model_fields)))
            return ScanRequest(sensor_pose=pose, scan=scan)
    return ScanRequest(sensor=name, scan=scan)
