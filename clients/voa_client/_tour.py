"""Tours of the robot that carries the lidar: which look comes next, and where it is taken; without I/O."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from voa_client._errors import ProblemError
from voa_msgs.geometry import (
    Candidate,
    CandidateSensor,
    Departure,
    Location,
    PoseUncertainty,
    SensorPose,
    UncertainSensorPose,
)
from voa_msgs.looks import AnnouncedLook, AtPlace, LookAnnouncement
from voa_msgs.rankings import GraspNow, Look, Ranking, VoaRequest
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Scan, ScanRequest, UpdatedSession
from voa_msgs.warnings import ProbableMistake

MOST_LOOKS = 10
_NOTHING = 1e-9
"""Net values up to this are worth nothing: they are rounding errors of 0."""


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
        warnings: about the advice, above all that the object is probably at none of the poses.
    """

    looks: tuple[TakenLook, ...]
    advice: Look | GraspNow
    warnings: tuple[ProbableMistake, ...] = ()


@dataclass(frozen=True)
class Reach:
    """Places that a robot can reach, and what its looks from there have in common.

    Attributes:
        candidates: names of sensor configurations, or poses of the lidar; None: all sensor configurations.
        std: standard deviations of the poses at which the robot arrives; None: it states none.
        cost_per_m: cost of driving one metre, in units of success probability.
    """

    candidates: tuple[Candidate, ...] | None
    std: PoseUncertainty | None = None
    cost_per_m: float = 0.0

    def ranking_request(self, stands_at: Departure | None = None, grasps: Sequence[str] | None = None) -> VoaRequest:
        """Make the request for a ranking of the places, with the fields that are stated and no others.

        Args:
            stands_at: name of a sensor configuration, or point, from which the robot drives; None: unknown.
            grasps: names of the grasps that the arm can reach; None: all.
        """
        request = VoaRequest(
            sensors=None if self.candidates is None else list(self.candidates),
            grasps=None if grasps is None else list(grasps),
        )
        # Services of older releases refuse fields that they do not know, so none is sent without a need.
        if self.std is not None:
            request = request.model_copy(update={"sensor_std": self.std})
        if self.cost_per_m > 0.0 and stands_at is not None:
            request = request.model_copy(update={"from_": stands_at, "cost_per_m": self.cost_per_m})
        return request

    def place(self, name: str) -> AtPlace:
        """Return the place of a ranked look: by its pose if it is a pose of the candidates, else by its name."""
        for index, candidate in enumerate(self.candidates or ()):
            if isinstance(candidate, CandidateSensor) and name == (candidate.name or str(index)):
                pose = UncertainSensorPose(**candidate.model_dump(include=set(SensorPose.model_fields)))
                return AtPlace(sensor_pose=pose if self.std is None else pose.model_copy(update={"std": self.std}))
        return AtPlace(sensor=name)


def reach_by_poses(reach: Reach, scenario: Scenario) -> Reach:
    """Replace the names of sensor configurations by their poses, which alone can have standard deviations.

    The names stay where the scenario has predictions as data, because they hold for its own sensor configurations only.
    """
    if reach.std is None or scenario.object is None or scenario.predictions is not None:
        return reach
    listed = {sensor.name: pose for sensor, pose in zip(scenario.sensors, poses_of(scenario), strict=True)}
    candidates = tuple(listed) if reach.candidates is None else reach.candidates
    poses = tuple(listed.get(each, each) if isinstance(each, str) else each for each in candidates)
    return Reach(poses, reach.std, reach.cost_per_m)


def poses_of(scenario: Scenario) -> list[CandidateSensor]:
    """Return the sensor configurations of a scenario as poses of the lidar, with their names and costs.

    A robot that states the uncertainty of its pose has to rank poses, because it sends its scans with poses, and looks
    from a pose are never counted for the sensor configuration that stands there.
    """
    fields = set(CandidateSensor.model_fields)
    poses = [CandidateSensor(**sensor.model_dump(include=fields)) for sensor in scenario.sensors]
    # A pose that equals a sensor configuration in every field, name included, counts as that configuration.
    height_m = scenario.lidar.height_m
    return [pose if pose.height_m is not None else pose.model_copy(update={"height_m": height_m}) for pose in poses]


@dataclass(eq=False)
class Itinerary:
    """Course of a tour: the looks that were taken, and the next one by the newest ranking.

    Attributes:
        reach: the places, and the robot's errors and costs.
        most_looks: largest number of looks.
        stands_at: name of the sensor configuration, or point, where the robot stands; None: unknown.
        looks: that were taken, in order.
        second: name of the second look of a pair whose first was taken; None: there is no such pair.
    """

    reach: Reach
    most_looks: int
    stands_at: Departure | None = None
    looks: list[TakenLook] = field(default_factory=list)
    second: str | None = None

    def request(self) -> VoaRequest:
        """Make the request for the ranking that decides on the next look."""
        return self.reach.ranking_request(self.stands_at)

    def next(self, ranking: Ranking) -> Look | None:
        """Return the next look by the newest ranking; None: the tour is over.

        A pair is not begun where only one look is left.
        """
        left = self.most_looks - len(self.looks)
        look = next_look(ranking, self.second) if left > 0 else None
        return None if look is None or (look.then is not None and left == 1) else look

    def take(self, look: Look, after: UpdatedSession) -> None:
        """Add a look that was taken, with the session after it."""
        place = self.reach.place(look.sensor)
        pose = place.sensor_pose
        self.looks.append(TakenLook(look.sensor, after))
        self.stands_at = place.sensor if pose is None else Location(x=pose.x, y=pose.y)
        self.second = look.then if after.update.accepted else None

    def tour(self, ranking: Ranking) -> Tour:
        """Return the tour that ended with a ranking."""
        return Tour(tuple(self.looks), ranking.recommendation, tuple(ranking.warnings))


def next_look(ranking: Ranking, second: str | None = None) -> Look | None:
    """Return the look to take next: the recommended one, or the second of a pair; None: grasp.

    Two looks may be worth their costs together and neither alone. After the first, the ranking is computed again. Its
    recommendation is followed if it is a single look. Else, be it another pair or a grasp, the second look of the pair
    comes next as long as it is worth more than its cost: the pair has passed the test by which looks are recommended.

    Args:
        ranking: after the newest look.
        second: name of the second look of a pair whose first was the newest look; None: there is no such pair.
    """
    advice = ranking.recommendation
    if isinstance(advice, Look) and advice.then is None:
        return advice
    planned = next((each for each in ranking.ranking if each.sensor == second), None)
    if planned is not None and planned.net_value > _NOTHING:
        return Look(action="look", sensor=planned.sensor, net_value=planned.net_value)
    return advice if isinstance(advice, Look) else None


def scan_request(place: AtPlace, scan: Scan) -> ScanRequest:
    """Make the request for a scan from a place."""
    if place.sensor_pose is None:
        return ScanRequest(sensor=place.sensor, scan=scan)
    return ScanRequest(sensor_pose=place.sensor_pose, scan=scan)


def announcement(place: AtPlace, robot: str | None) -> LookAnnouncement:
    """Make the announcement of a look from a place by a robot; None: the robot has no name."""
    fields = place.model_dump(exclude_unset=True) | ({} if robot is None else {"robot": robot})
    return LookAnnouncement.model_validate(fields)


def still_under_way(look: AnnouncedLook, after: UpdatedSession) -> bool:
    """True if a session still lists an announced look after its scan, which was not accepted."""
    return any(each.id == look.id for each in after.under_way)


def may_lack_announcements(error: ProblemError) -> bool:
    """True if a refused announcement may be that of a service of an older release, without announcements."""
    return error.problem.status in (404, 405)
