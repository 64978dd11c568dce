"""Clients for the program on the robot that carries the lidar: choose the next look, drive there, send the scan."""

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
    """A look that was taken: the name of its sensor configuration or pose, and the session after it."""

    sensor: str
    after: UpdatedSession


@dataclass(frozen=True)
class Tour:
    """The looks of a drive, and the service's recommendation after them.

    Attributes:
        looks: in the order in which they were taken.
        advice: to grasp; or, if the largest number of looks was reached, perhaps to look again.
    """

    looks: tuple[TakenLook, ...]
    advice: Look | GraspNow


class SensorClient:
    """Client of the robot that carries the lidar, in one session.

    Args:
        client: of the service; the caller closes it.
        session_id: of the session.
    """

    def __init__(self, client: Client, session_id: str) -> None:
        self._client = client
        self._session = session_id

    def where_to_look(
        self, reachable: Sequence[Candidate] | None = None, grasps: Sequence[str] | None = None
    ) -> Look | GraspNow:
        """Return the look of the highest net value, or the grasp to try now if no look is worth its cost.

        Args:
            reachable: places that the robot can reach: names of sensor configurations, or poses of the lidar; None: all
                sensor configurations of the scenario.
            grasps: names of the grasps that the arm can reach; None: all.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        return self._client.rank_looks(self._session, _ranking_request(reachable, grasps)).recommendation

    def send_scan(
        self,
        scan: Scan,
        sensor: str | None = None,
        sensor_pose: UncertainSensorPose | None = None,
        *,
        key: str | None = None,
    ) -> UpdatedSession:
        """Update the session by a scan.

        Args:
            scan: ranges of one revolution.
            sensor: name of the sensor configuration where it was taken; or None, and then:
            sensor_pose: pose of the lidar, metres and radians in the world frame.
            key: idempotency key: a scan that is repeated with it takes effect once; None: a new key.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
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
        """Take the recommended looks, one after another, until the service recommends to grasp.

        Args:
            drive: brings the lidar to a sensor configuration, given by name, or to a pose of `reachable`, given by its
                name or index; returns on arrival.
            take_scan: returns a scan, or the median of several, from where the lidar stands.
            reachable: places that the robot can reach: names of sensor configurations, or poses of the lidar; None: all
                sensor configurations of the scenario.
            most_looks: largest number of looks, those that are not accepted included.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        looks: list[TakenLook] = []
        advice = self.where_to_look(reachable)
        while isinstance(advice, Look) and len(looks) < most_looks:
            drive(advice.sensor)
            request = _scan_request(take_scan(), advice.sensor, reachable)
            looks.append(TakenLook(advice.sensor, self._client.apply_scan(self._session, request)))
            advice = self.where_to_look(reachable)
        return Tour(tuple(looks), advice)


class AsyncSensorClient:
    """Client of the robot that carries the lidar, in one session, for asyncio.

    Args:
        client: of the service; the caller closes it.
        session_id: of the session.
    """

    def __init__(self, client: AsyncClient, session_id: str) -> None:
        self._client = client
        self._session = session_id

    async def where_to_look(
        self, reachable: Sequence[Candidate] | None = None, grasps: Sequence[str] | None = None
    ) -> Look | GraspNow:
        """Return the look of the highest net value, or the grasp to try now if no look is worth its cost.

        Args:
            reachable: places that the robot can reach: names of sensor configurations, or poses of the lidar; None: all
                sensor configurations of the scenario.
            grasps: names of the grasps that the arm can reach; None: all.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        return (await self._client.rank_looks(self._session, _ranking_request(reachable, grasps))).recommendation

    async def send_scan(
        self,
        scan: Scan,
        sensor: str | None = None,
        sensor_pose: UncertainSensorPose | None = None,
        *,
        key: str | None = None,
    ) -> UpdatedSession:
        """Update the session by a scan.

        Args:
            scan: ranges of one revolution.
            sensor: name of the sensor configuration where it was taken; or None, and then:
            sensor_pose: pose of the lidar, metres and radians in the world frame.
            key: idempotency key: a scan that is repeated with it takes effect once; None: a new key.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        request = ScanRequest(sensor=sensor, sensor_pose=sensor_pose, scan=scan)
        return await self._client.apply_scan(self._session, request, key=key)

    async def run(
        self,
        drive: Callable[[str], Awaitable[None]],
        take_scan: Callable[[], Awaitable[Scan]],
        reachable: Sequence[Candidate] | None = None,
        most_looks: int = MOST_LOOKS,
    ) -> Tour:
        """Take the recommended looks, one after another, until the service recommends to grasp.

        Args:
            drive: brings the lidar to a sensor configuration, given by name, or to a pose of `reachable`, given by its
                name or index; returns on arrival.
            take_scan: returns a scan, or the median of several, from where the lidar stands.
            reachable: places that the robot can reach: names of sensor configurations, or poses of the lidar; None: all
                sensor configurations of the scenario.
            most_looks: largest number of looks, those that are not accepted included.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        looks: list[TakenLook] = []
        advice = await self.where_to_look(reachable)
        while isinstance(advice, Look) and len(looks) < most_looks:
            await drive(advice.sensor)
            request = _scan_request(await take_scan(), advice.sensor, reachable)
            looks.append(TakenLook(advice.sensor, await self._client.apply_scan(self._session, request)))
            advice = await self.where_to_look(reachable)
        return Tour(tuple(looks), advice)


def _ranking_request(reachable: Sequence[Candidate] | None, grasps: Sequence[str] | None) -> VoaRequest:
    """Make the request for a ranking of the reachable places."""
    sensors = None if reachable is None else list(reachable)
    return VoaRequest(sensors=sensors, grasps=None if grasps is None else list(grasps))


def _scan_request(scan: Scan, name: str, reachable: Sequence[Candidate] | None) -> ScanRequest:
    """Make the request for a scan at a place: by its pose if it is one of `reachable`, else by its sensor's name."""
    for index, candidate in enumerate(reachable or ()):
        if isinstance(candidate, CandidateSensor) and name == (candidate.name or str(index)):
            pose = UncertainSensorPose(**candidate.model_dump(include=set(SensorPose.model_fields)))
            return ScanRequest(sensor_pose=pose, scan=scan)
    return ScanRequest(sensor=name, scan=scan)
