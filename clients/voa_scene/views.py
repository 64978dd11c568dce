"""Facts about a session that its scene shows, gathered by the viewer."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_msgs.geometry import SensorPose, UncertainSensorPose
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Scan


@dataclass(frozen=True)
class TakenScan:
    """Scan with the pose of the lidar, and the prediction of the likeliest pose from there.

    Attributes:
        scan: as the driver reported it.
        place: pose of the lidar in the world.
        predicted: ranges that the likeliest pose predicts on the beams of the scenario's lidar, metres, None for a
            no-return; empty: not known.
    """

    scan: Scan
    place: SensorPose
    predicted: Sequence[float | None] = ()


@dataclass(frozen=True)
class RobotPlace:
    """Robot that carries a lidar, and the pose of that lidar.

    Attributes:
        name: of the robot.
        place: pose of the lidar, with its uncertainty if that is known.
    """

    name: str
    place: UncertainSensorPose


@dataclass(frozen=True)
class SessionView:
    """Facts that a viewer has about a session at one version.

    Attributes:
        scenario: of the session, as the service stored it, with every field of the lidar.
        belief: probability of each pose, in the order of the scenario.
        best_grasp: name of the grasp with the largest expected score; None: every grasp scores 0.
        ranking: of places at this version; None: not known.
        scan: newest scan; None: there is none.
        robots: whose scans are applied to the session.
    """

    scenario: Scenario
    belief: Sequence[float]
    best_grasp: str | None = None
    ranking: Ranking | None = None
    scan: TakenScan | None = None
    robots: Sequence[RobotPlace] = ()
