"""Make the scene of a session at one version from what its viewer knows about it."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_msgs.geometry import SensorPose, UncertainSensorPose
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Scan
from voa_scene.shapes import Scene


@dataclass(frozen=True)
class TakenScan:
    """Scan with the pose of the lidar, and what the likeliest pose predicts there.

    Attributes:
        scan: as the driver reported it.
        place: pose of the lidar in the world.
        predicted: ranges that the likeliest pose predicts on the beams of `scan`, metres, None for a no-return; empty:
            not known.
    """

    scan: Scan
    place: SensorPose
    predicted: Sequence[float | None] = ()


@dataclass(frozen=True)
class RobotPlace:
    """Robot that carries a lidar, and where its lidar is.

    Attributes:
        name: of the robot.
        place: pose of the lidar, with its uncertainty where that is known.
    """

    name: str
    place: UncertainSensorPose


@dataclass(frozen=True)
class SessionView:
    """What a viewer knows about a session at one version.

    Attributes:
        scenario: of the session.
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


def scene_of(view: SessionView) -> Scene:
    """Make the scene of a session: table and workspace, ghosts of the object, towers of places, scan, robots, grasp."""
    raise NotImplementedError(view)
