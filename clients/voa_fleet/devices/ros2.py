"""A simulated robot that speaks as a ROS 2 robot behind a bridge does: CDR on `<robot>/scan` and `<robot>/odom`.

It never calls the service to send a scan. Where it has stopped it publishes revolution after revolution, as a driver
does, each with an odometry message of the same time; the service, by its mapping, takes their median for one look.
While it drives it is silent: a look is a stop, and nothing else is published of a drive. The odometry's frame is the
world, and the lidar is in the middle of the robot: so where the robot believes to be is where its lidar believes to be.

A mapped robot keeps its session, whoever opens others on its scenario. So each session that is opened here claims its
robot, and robots that are mapped to one scenario can be in sessions of their own.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from voa_client import Client, ConflictError, InvalidRequestError, ProblemError
from voa_fleet.devices.clocks import Clock
from voa_fleet.devices.looking import FRAME, REVOLUTIONS, laser_scan
from voa_fleet.devices.protocol import DeviceError, SensorRobot
from voa_fleet.devices.session_looks import TakenLook
from voa_fleet.world.lidar import LidarGeometry
from voa_msgs.geometry import PoseUncertainty, SensorConfiguration
from voa_msgs.robots import RobotReport
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, Session, SessionRequest
from voa_ros.cdr import encode_laser_scan, encode_odometry
from voa_ros.look_taker import AWAY_BY_POSE
from voa_ros.messages import Odometry, Pose, Stamp

Publish = Callable[[str, bytes], None]
"""Puts a payload on a key of the router."""

_LOOK_S, _AGAIN_S, _ASK_S = 10.0, 2.0, 0.02
_FITTING = "`voa fleet --ros2 --print-mapping`, with the other options as here, prints one that fits"


@dataclass(frozen=True)
class Mapped:
    """One robot of a mapping.

    Attributes:
        robot: its name, and the namespace of its topics.
        scenario: its looks are for the session on it that claims the robot.
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
        f'scenario = "{mapped.scenario}"  # its sessions claim the robot',
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

    def open(self, scenario: Scenario) -> Session:
        """Open a session that claims the robot: its scans are for this session from now on.

        Raises:
            DeviceError: the service cannot give the robot to a session on this scenario; says which mapping it needs.
            VoaClientError: the service refuses something else, or does not answer.
        """
        try:
            return self.client.create_session(SessionRequest(scenario=scenario.id, robots=[self.robot.name]))
        except (ConflictError, InvalidRequestError) as error:
            if not _is_about_robots(error):
                raise
            raise DeviceError(
                f"the service cannot give the robot {self.robot.name!r} to a session: {error.problem.detail}; expected "
                f"`voa serve --robots FILE` with a mapping of it to scenario {scenario.id!r}: {_FITTING}"
            ) from error

    def look(self, session: Session, sensor: SensorConfiguration) -> TakenLook:
        """Publish from where the robot stands until the service has taken a look for this session.

        Where no look follows the revolutions are published again: messages get lost, and the service may have noticed
        in the middle of them that the robot is in another session now.

        Raises:
            DeviceError: it takes none; says what it waits for, or why it refused.
            VoaClientError: the service does not answer.
        """
        version = self.client.get_session(session.id).version
        before = self._report(session)
        end = self.now_s() + _LOOK_S
        while self.now_s() < end:
            # As many revolutions as show that it has moved on, then those of the look.
            for _ in range(AWAY_BY_POSE + self.revolutions):
                self._revolution()
            if self._looked(session, before.looks):
                return self._taken(session, sensor, version)
        raise self._no_look(session, self._report(session))

    def _looked(self, session: Session, before: int) -> bool:
        """Wait a while for the service to take a look; whether it has taken more than `before`."""
        until = self.now_s() + _AGAIN_S
        while self._report(session).looks <= before:
            if self.now_s() > until:
                return False
            self.sleep(_ASK_S)
        return True

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

    def _report(self, session: Session) -> RobotReport:
        """Report of the service on the robot; raises DeviceError where its scans are not for the session."""
        for report in self.client.robots().items:
            if report.robot == self.robot.name and report.source == "ros2":
                if report.session == session.id:
                    return report
                raise DeviceError(
                    f"the scans of the robot {self.robot.name!r} are for session {report.session} now, expected "
                    f"{session.id}: somebody else has claimed the robot; play again when it is free"
                )
        raise DeviceError(
            f"the service has no mapping (`voa serve --robots FILE`) for the robot {self.robot.name!r}; {_FITTING}"
        )

    def _no_look(self, session: Session, report: RobotReport) -> DeviceError:
        why = f"it waits for {report.waiting_for or 'nothing'}"
        if report.last_refusal is not None:
            why += f", and refused a scan last because of: {report.last_refusal}"
        return DeviceError(
            f"the service took no look of {self.robot.name!r} for session {session.id} of {report.scans} scans that it "
            f"received: {why}; expected a mapping of {self.revolutions} revolutions in a look: {_FITTING}"
        )

    def _taken(self, session: Session, sensor: SensorConfiguration, version: int | None) -> TakenLook:
        after = self.client.get_session(session.id)
        if after.version == version:
            return TakenLook(sensor.name, None, after, None)
        newest = list(self.client.history(session.id))[-1]
        return TakenLook(sensor.name, ScanRequest.model_validate(newest.request), after, newest.update)


def _is_about_robots(error: ProblemError) -> bool:
    """Whether a session was refused because of the robots that it claims."""
    return error.kind == "claim-conflict" or "body.robots" in error.problem.detail
