"""Facts that a page shows about a session at one moment, and the scene that they give."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from voa_console.session.moments import Moment
from voa_msgs.geometry import SensorPose, UncertainSensorPose
from voa_msgs.rankings import RankedSensor, Ranking
from voa_msgs.robots import RobotReport
from voa_msgs.scenarios import Predictions, Scenario
from voa_msgs.sessions import HistoryEntry, ScanRequest, Session
from voa_scene.views import RobotPlace, SessionView, TakenScan


@dataclass(frozen=True)
class Facts:
    """Facts about a session at the moment that a page shows.

    Attributes:
        scenario: of the session.
        session: its newest version.
        moment: version that is shown.
        history: every version with its belief, in ascending order; empty: not received yet.
        ranking: of the newest version; None: not received yet.
        outcomes: row of the recommended place with its expected results; None: not known.
        grasps: each grasp with its expected score at the moment, the best first; empty: not received yet.
        taken: newest scan at the moment; None: there is none.
        robots: reports of the robots whose scans are applied to the session.
    """

    scenario: Scenario
    session: Session
    moment: Moment
    history: Sequence[HistoryEntry] = ()
    ranking: Ranking | None = None
    outcomes: RankedSensor | None = None
    grasps: Sequence[tuple[str, float]] = ()
    taken: TakenScan | None = None
    robots: Sequence[RobotReport] = ()

    @property
    def ranking_at_moment(self) -> Ranking | None:
        """Ranking of the version that is shown; None for a past one, of which none is stored."""
        is_current = self.ranking is not None and self.ranking.version == self.moment.version
        return self.ranking if is_current else None

    @property
    def entry(self) -> HistoryEntry | None:
        """Version that is shown, with the request that made it; None: not received yet."""
        return next((each for each in self.history if each.version == self.moment.version), None)


def view_of(facts: Facts) -> SessionView:
    """Return the facts that the scene of a moment shows; robots stand in the present, and are left out of the past."""
    places = [] if facts.moment.is_past else [robot_place(robot, facts.scenario) for robot in facts.robots]
    return SessionView(
        facts.scenario,
        facts.moment.belief,
        facts.moment.best_grasp,
        facts.ranking_at_moment,
        facts.taken,
        [place for place in places if place is not None],
    )


def robot_place(robot: RobotReport, scenario: Scenario) -> RobotPlace | None:
    """Return where a robot's newest look was taken; None: no look of it is known."""
    look = robot.last_look
    if look is None:
        return None
    if look.sensor_pose is not None:
        return RobotPlace(robot.robot, look.sensor_pose)
    listed = next((sensor for sensor in scenario.sensors if sensor.name == look.sensor), None)
    if listed is None:
        return None
    return RobotPlace(robot.robot, UncertainSensorPose(x=listed.x, y=listed.y, yaw_rad=listed.yaw_rad))


def newest_scan(history: Sequence[HistoryEntry], version: int) -> HistoryEntry | None:
    """Return the newest scan of a history up to `version`; None: there is none."""
    return next((each for each in reversed(history) if each.kind == "scan" and each.version <= version), None)


def scan_request(entry: HistoryEntry) -> ScanRequest:
    """Read the body of a scan from the history."""
    return ScanRequest.model_validate_json(json.dumps(entry.request))


def taken_scan(
    request: ScanRequest, scenario: Scenario, belief: Sequence[float], predictions: Predictions | None
) -> TakenScan | None:
    """Put a scan, its place and the outline of the likeliest pose together.

    Args:
        request: the scan with its place.
        scenario: of the session.
        belief: probability of each pose.
        predictions: from the place of the scan alone; None: not known.

    Returns:
        None: the scenario does not list the sensor of the scan.
    """
    place = place_of(request, {sensor.name: sensor for sensor in scenario.sensors})
    if place is None:
        return None
    best = max(range(len(belief)), key=lambda index: belief[index])
    return TakenScan(request.scan, place, () if predictions is None else predictions.ranges[0][best])


def place_of(request: ScanRequest, listed: Mapping[str, SensorPose]) -> SensorPose | None:
    """Return the pose of the lidar at a scan; None: the sensor is not listed."""
    return request.sensor_pose if request.sensor_pose is not None else listed.get(request.sensor or "")
