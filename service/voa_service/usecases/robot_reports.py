"""Parts of the report on a robot: what a mapped robot contributes, its place, and its refusals."""

from dataclasses import dataclass
from typing import Literal, Protocol

from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.robots import Refusal, RobotReport
from voa_msgs.warnings import ProbableMistake
from voa_service.usecases.seen_scans import SeenScan

_MOST_REFUSALS = 5


@dataclass(frozen=True)
class Standing:
    """Present place of a mapped robot, and the progress of its next look.

    Attributes:
        sensor: sensor configuration at which the lidar is; None: none, or not known.
        sensor_pose: measured pose of the lidar; None: not measured.
        gathered: number of revolutions gathered for the next look; None: each scan is a look.
        wanted: number of revolutions that make a look; None: each scan is a look.
    """

    sensor: str | None = None
    sensor_pose: UncertainSensorPose | None = None
    gathered: int | None = None
    wanted: int | None = None


class LookSource(Protocol):
    """Port to a mapped robot: the facts that its report shows, and the request for a look."""

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet; None: every scan is a look."""

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Probable mistakes in how the robot is used."""

    @property
    def standing(self) -> Standing:
        """Present place of the robot, and the progress of its next look."""

    def request(self) -> None:
        """Request a look.

        Raises:
            ValueError: the robot's looks are not taken on request.
        """


def at_place(report: RobotReport, scan: SeenScan | None) -> RobotReport:
    """Complete the report on a robot that puts its scans with the place of its newest scan.

    The place is not for the readers of another session, to which the robot has moved since that scan.
    """
    if scan is None or scan.session != report.session:
        return report
    return report.model_copy(update={"sensor": scan.sensor, "sensor_pose": scan.sensor_pose})


def in_order_of_use(report: RobotReport) -> tuple[bool, str]:
    """Return the sort key of a report for removal: first those of which every scan was refused, the oldest of each."""
    newest = report.last_scan_at or (report.refusals[0].at if report.refusals else None)
    return report.last_scan_at is not None, str(newest)


def with_refusal(before: list[Refusal], newest: Refusal) -> list[Refusal]:
    """Put a refusal in front; one with the same reason as the newest counts as a repetition of it."""
    if before and before[0].reason == newest.reason:
        return [newest.model_copy(update={"times": before[0].times + 1}), *before[1:]]
    return [newest, *before][:_MOST_REFUSALS]


def empty_report(robot: str, source: Literal["scan", "ros2"], key: str) -> RobotReport:
    """Make the report on a robot before its first scan."""
    return RobotReport(
        robot=robot,
        session=None,
        source=source,
        key=key,
        last_scan_at=None,
        scans=0,
        looks=0,
        refused=0,
        last_refusal=None,
        waiting_for=None,
    )
