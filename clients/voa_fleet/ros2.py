"""A simulated robot that speaks as a ROS 2 robot behind a bridge does: CDR on `<robot>/scan` and `<robot>/odom`.

It never calls the service to send a scan. Where it has stopped it publishes revolution after revolution, as a driver
does, each with an odometry message of the same time; the service, by its mapping, takes their median for one look.
While it drives it is silent: a look is a stop, and nothing else is told of a drive. The odometry's frame is the world,
and the lidar is in the middle of the robot: so where the robot believes to be is where its lidar believes to be.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from voa_client import Client
from voa_fleet.clocks import Clock
from voa_fleet.devices import DeviceError, SensorRobot
from voa_fleet.lidar import LidarGeometry
from voa_fleet.looking import FRAME, REVOLUTIONS, laser_scan
from voa_fleet.story import TakenLook
from voa_msgs.geometry import PoseUncertainty, SensorConfiguration
from voa_msgs.robots import RobotReport
from voa_msgs.sessions import ScanRequest, Session
from voa_ros.cdr import encode_laser_scan, encode_odometry
from voa_ros.looks import AWAY_BY_POSE
from voa_ros.messages import Odometry, Pose, Stamp

Publish = Callable[[str, bytes], None]
"""Puts a payload on a key of the router."""

_JOIN_S, _LOOK_S = 5.0, 10.0
_JOIN_EVERY_S, _ASK_S = 0.25, 0.02


@dataclass(frozen=True)
class Mapped:
    """One robot of a mapping.

    Attributes:
        robot: its name, and the namespace of its topics.
        scenario: its looks are for the newest session on it.
        std: of the lidar's pose; None: it is known.
    """

    robot: str
    scenario: str
    std: PoseUncertainty | None


def mapping(robots: Sequence[Mapped], revolutions: int = REVOLUTIONS) -> str:
    """The robots.toml with which a service takes the looks of these robots."""
    return "\n".join(_entry(robot, revolutions) for robot in robots)


def _entry(mapped: Mapped, revolutions: int) -> str:
    lines = [
        "[[robot]]",
        f'name = "{mapped.robot}"',
        f'scenario = "{mapped.scenario}"  # its newest session',
        f'look = {{ mode = "stationary", scans = {revolutions} }}',
        "",
        "[robot.place]",
        'from = "odometry"',
        "origin = { x = 0.0, y = 0.0, yaw_rad = 0.0 }",
    ]
    if mapped.std is not None:
        lines.append(f"std = {{ xy_m = {mapped.std.xy_m!r}, yaw_rad = {mapped.std.yaw_rad!r} }}")
    return "\n".join([*lines, ""])


@dataclass(frozen=True, eq=False)
class ByRos2:
    """Looks that the service gathers from what the robot publishes.

    Attributes:
        client: to learn what became of them.
        publish: to the router.
        robot: that looks; its name is its namespace.
        lidar: its beams.
        clock: the robot's.
        revolutions: of which the mapping makes a look.
        sleep: real seconds, between two questions to the service.
        now_s: real seconds.
    """

    client: Client
    publish: Publish
    robot: SensorRobot
    lidar: LidarGeometry
    clock: Clock
    revolutions: int = REVOLUTIONS
    sleep: Callable[[float], None] = time.sleep
    now_s: Callable[[], float] = time.monotonic

    def look(self, session: Session, sensor: SensorConfiguration) -> TakenLook:
        """Publish from where the robot stands until the service has taken a look for this session.

        Raises:
            DeviceError: it takes none; says what it waits for, or why it refused.
            VoaClientError: the service does not answer.
        """
        version = self.client.get_session(session.id).version
        before = self._join(session)
        # As many revolutions as show that it has moved on, then those of the look.
        for _ in range(AWAY_BY_POSE + self.revolutions):
            self._revolution()
        end = self.now_s() + _LOOK_S
        while (report := self._report()) is None or report.looks <= before.looks:
            if self.now_s() > end:
                raise self._no_look(session, report)
            self.sleep(_ASK_S)
        return self._taken(session, sensor, version)

    def _join(self, session: Session) -> RobotReport:
        """Wait until the robot's scans go to the session: the service notices a new one within a second.

        They are few, so that the session before this one takes no look of them.
        """
        end = self.now_s() + _JOIN_S
        while (report := self._report()) is None or report.session != session.id:
            if self.now_s() > end:
                raise self._no_look(session, report)
            self._revolution()
            self.sleep(_JOIN_EVERY_S)
        return report

    def _revolution(self) -> None:
        at_s = self.clock.now_s()
        scan = laser_scan(self.robot.take_scan(), self.lidar, at_s)
        pose = self.robot.pose()
        odometry = Odometry(
            stamp=Stamp.of(at_s + scan.scan_time / 2.0),  # of the middle, when the scan's place counts
            frame_id="odom",
            child_frame_id=FRAME,
            pose=Pose.planar(pose.x, pose.y, pose.yaw_rad),
        )
        self.publish(f"{self.robot.name}/odom", encode_odometry(odometry))
        self.publish(f"{self.robot.name}/scan", encode_laser_scan(scan))

    def _report(self) -> RobotReport | None:
        """What the service says of the robot; None: it has no mapping for it."""
        for report in self.client.robots().items:
            if report.robot == self.robot.name and report.source == "ros2":
                return report
        return None

    def _no_look(self, session: Session, report: RobotReport | None) -> DeviceError:
        fitting = "`voa fleet --ros2 --print-mapping` prints one that fits"
        if report is None:
            return DeviceError(f"the service has no mapping (--robots) for the robot {self.robot.name!r}; {fitting}")
        why = report.last_refusal or f"it waits for {report.waiting_for or 'nothing'}"
        return DeviceError(
            f"the service took no look of {self.robot.name!r} for session {session.id}; it has heard {report.scans} "
            f"scans, for session {report.session}: {why}; {fitting}"
        )

    def _taken(self, session: Session, sensor: SensorConfiguration, version: int | None) -> TakenLook:
        after = self.client.get_session(session.id)
        if after.version == version:
            return TakenLook(sensor.name, None, after, None)
        newest = list(self.client.history(session.id))[-1]
        return TakenLook(sensor.name, ScanRequest.model_validate(newest.request), after, newest.update)
