"""Client for the program on the robot that carries the lidar: choose the next look, drive there, send the scan."""

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, suppress

from voa_client._client import Client
from voa_client._errors import ProblemError, VoaClientError
from voa_client._tour import (
    MOST_LOOKS,
    Itinerary,
    Reach,
    Tour,
    announcement,
    may_lack_announcements,
    reach_by_poses,
    scan_request,
    still_under_way,
)
from voa_msgs.geometry import Candidate, Departure, PoseUncertainty, UncertainSensorPose
from voa_msgs.looks import AnnouncedLook, AtPlace
from voa_msgs.rankings import GraspNow, Look
from voa_msgs.sessions import Scan, ScanRequest, UpdatedSession


class SensorClient:
    """Client of the robot that carries the lidar, in one session.

    Args:
        client: of the service; the caller closes it.
        session_id: of the session.
        robot: name of the robot in its announcements, for people; None: none.
        sensor_std: standard deviations of the poses at which the robot arrives: rankings take them into account, and
            `run` states them with its scans; None: those of the session's last scan in rankings, none with scans.
        cost_per_m: cost of driving one metre in a straight line, in units of success probability.
    """

    def __init__(
        self,
        client: Client,
        session_id: str,
        *,
        robot: str | None = None,
        sensor_std: PoseUncertainty | None = None,
        cost_per_m: float = 0.0,
    ) -> None:
        self._client = client
        self._session = session_id
        self._robot = robot
        self._std = sensor_std
        self._cost_per_m = cost_per_m
        self._announces = True

    def where_to_look(
        self,
        reachable: Sequence[Candidate] | None = None,
        grasps: Sequence[str] | None = None,
        stands_at: Departure | None = None,
    ) -> Look | GraspNow:
        """Return the look of the highest net value, the first of a pair, or the grasp to try now if no look pays.

        Args:
            reachable: places that the robot can reach: names of sensor configurations, or poses of the lidar; None: all
                sensor configurations of the scenario.
            grasps: names of the grasps that the arm can reach; None: all.
            stands_at: name of the sensor configuration, or point, from which the robot drives; None: unknown, so that
                driving costs nothing.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        request = self._reach(reachable).ranking_request(stands_at, grasps)
        return self._client.rank_looks(self._session, request).recommendation

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
        *,
        stands_at: Departure | None = None,
    ) -> Tour:
        """Take the recommended looks, one after another, until the service recommends to grasp.

        Each look is announced in the session before the drive, so that the rankings of other robots value their looks
        by what these add to it; its scan, or a failure of the drive or scan, ends the announcement, and so do 120 s.
        Services that do not know announcements get none.

        Where no single look is worth its cost, the service may recommend a pair: after its first look the second is
        taken, unless the ranking in between recommends another single look, or values the second at no more than its
        cost, as when the first look left no doubt. A pair is not begun where `most_looks` leaves only one look.

        Args:
            drive: brings the lidar to a sensor configuration, given by name, or to a pose of `reachable`, given by its
                name or index; returns on arrival.
            take_scan: returns a scan, or the median of several, from where the lidar stands.
            reachable: places that the robot can reach: names of sensor configurations, or poses of the lidar; None: all
                sensor configurations of the scenario.
            most_looks: largest number of looks, those that are not accepted included.
            stands_at: name of the sensor configuration, or point, from which the first drive starts; None: unknown, so
                that the first drive costs nothing.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        itinerary = Itinerary(self._reach(reachable), most_looks, stands_at)
        ranking = self._client.rank_looks(self._session, itinerary.request())
        while (look := itinerary.next(ranking)) is not None:
            place = itinerary.reach.place(look.sensor)
            with self._announced(place) as announced:
                drive(look.sensor)
                after = self._client.apply_scan(self._session, scan_request(place, take_scan()))
            if announced is not None and still_under_way(announced, after):
                self._cancel(announced)
            itinerary.take(look, after)
            ranking = self._client.rank_looks(self._session, itinerary.request())
        return itinerary.tour(ranking)

    def _reach(self, reachable: Sequence[Candidate] | None) -> Reach:
        """Make the reach of the robot; a stated uncertainty needs the poses of the sensor configurations."""
        reach = Reach(None if reachable is None else tuple(reachable), self._std, self._cost_per_m)
        if self._std is None:
            return reach
        scenario_id = self._client.get_session(self._session).scenario
        return reach_by_poses(reach, self._client.get_scenario(scenario_id))

    @contextmanager
    def _announced(self, place: AtPlace) -> Generator[AnnouncedLook | None, None, None]:
        """Announce a look for the length of a `with`; a failure in it, Ctrl-C included, ends the announcement."""
        look = self._announce(place)
        try:
            yield look
        except BaseException:
            if look is not None:
                self._cancel(look)
            raise

    def _announce(self, place: AtPlace) -> AnnouncedLook | None:
        """Announce a look; None: the service does not know announcements."""
        if not self._announces:
            return None
        try:
            return self._client.announce_look(self._session, announcement(place, self._robot))
        except ProblemError as error:
            if not may_lack_announcements(error):
                raise
        # It raises NotFoundError where it is the session that does not exist.
        self._client.get_session(self._session)
        self._announces = False
        return None

    def _cancel(self, look: AnnouncedLook) -> None:
        with suppress(VoaClientError):  # it ends by itself
            self._client.cancel_look(self._session, look.id)
