"""Looks of a robot that publishes CDR on `<robot>/scan` and `<robot>/odom`, as a ROS 2 robot behind a bridge does.

It never calls the service to send a scan. Where it has stopped it publishes one revolution after another, as a driver
does, each with an odometry message of the same time; the service takes their median for one look, as its mapping says.
It publishes nothing while it drives. The odometry's frame is the world, and the lidar is in the middle of the robot, so
that the robot's pose and the lidar's are equal.

A mapped robot stays with its session while others open sessions on its scenario. So each session that is opened here
claims its robot, and robots that are mapped to one scenario can be in different sessions.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from voa_client import Client, ConflictError, InvalidRequestError, ProblemError
from voa_fleet.devices.protocol import DeviceError, SensorRobot
from voa_fleet.episodes.look_scans import FRAME, REVOLUTIONS, driver_scan
from voa_fleet.episodes.looks import EpisodeLook
from voa_fleet.world.clocks import Clock
from voa_fleet.world.lidar import LidarGeometry
from voa_msgs.geometry import PoseUncertainty, SensorConfiguration
from voa_msgs.robots import RobotReport
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, Session, SessionRequest
from voa_ros.cdr import encode_laser_scan, encode_odometry
from voa_ros.look_taker import AWAY_BY_POSE
from voa_ros.messages import Odometry, Pose, Stamp

Publish = Callable[[str, bytes], None]
"""Function that publishes a payload under a key of the router."""

_LOOK_S = 10.0
"""Time after which a look is given up."""
_AGAIN_S = 2.0
"""Time after which revolutions are published again where no look has followed."""
_POLL_S = 0.02
_FITTING = "`voa fleet --ros2 --print-mapping`, with the other options unchanged, prints the mapping that fits"


@dataclass(frozen=True)
class MappingEntry:
    """An entry of a mapping.

    Attributes:
        robot: name of the robot, and the namespace of its topics.
        scenario: id of the scenario; its looks are for the session on that scenario that claims the robot.
        std: standard deviations of the lidar's pose; None: the pose is exact.
    """

    robot: str
    scenario: str
    std: PoseUncertainty | None


def mapping(robots: Sequence[MappingEntry], revolutions: int = REVOLUTIONS) -> str:
    """Write the robots.toml with which a service makes looks of what these robots publish."""
    return "\n".join(_entry(robot, revolutions) for robot in robots)


def _entry(mapped: MappingEntry, revolutions: int) -> str:
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
class Ros2Channel:
    """Looks that the service makes of what the robot publishes.

    Attributes:
        client: reads from the service whether a look was made.
        publish: sends messages to the router.
        robot: takes the scans; its name is the namespace of its topics.
        lidar: its beams.
        clock: of the robot.
        revolutions: of which the mapping makes a look.
        sleep: waits for real seconds between two requests.
        now_s: returns real seconds.
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
        """Open a session that claims the robot, and so receives its scans from now on.

        Raises:
            DeviceError: the robot is not mapped to this scenario; the message says which mapping is needed.
            VoaClientError: the service refuses the session for another reason, or does not answer.
        """
        try:
            return self.client.create_session(SessionRequest(scenario=scenario.id, robots=[self.robot.name]))
        except (ConflictError, InvalidRequestError) as error:
            if not _is_about_robots(error):
                raise
            raise DeviceError(
                f"no session can claim the robot {self.robot.name!r}: {error.problem.detail}; expected a service that "
                f"runs as `voa serve --robots FILE` with a mapping of it to scenario {scenario.id!r}: {_FITTING}"
            ) from error

    def look(self, session: Session, sensor: SensorConfiguration) -> EpisodeLook:
        """Publish from where the robot stands until the service has made a look for this session.

        Where no look follows, the revolutions are published again: messages get lost, and the service may only then
        have learned that another session has claimed the robot.

        Raises:
            DeviceError: the service makes no look; the message says what it waits for, or why it refused a scan.
            VoaClientError: the service does not answer.
        """
        version = self.client.get_session(session.id).version
        before = self._report(session)
        end = self.now_s() + _LOOK_S
        while self.now_s() < end:
            # First the revolutions that show that the robot has left the last place, then those of the look.
            for _ in range(AWAY_BY_POSE + self.revolutions):
                self._revolution()
            if self._looked(session, before.looks):
                return self._taken(session, sensor, version)
        raise self._no_look(session, self._report(session))

    def _looked(self, session: Session, before: int) -> bool:
        """Wait for the service to make a look; True if it has made more than `before`."""
        until = self.now_s() + _AGAIN_S
        while self._report(session).looks <= before:
            if self.now_s() > until:
                return False
            self.sleep(_POLL_S)
        return True

    def _revolution(self) -> None:
        at_s = self.clock.now_s()
        scan = driver_scan(self.robot.take_scan(), self.lidar, at_s)
        pose = self.robot.pose()
        odometry = Odometry(
            stamp=Stamp.of(
                at_s + scan.scan_time / 2.0
            ),  # of the middle of the revolution, for which the service computes the place
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
                    f"{session.id}: another client has claimed the robot; try again when it is free"
                )
        raise DeviceError(
            f"the service has no mapping (`voa serve --robots FILE`) for the robot {self.robot.name!r}; {_FITTING}"
        )

    def _no_look(self, session: Session, report: RobotReport) -> DeviceError:
        why = f"it waits for {report.waiting_for or 'nothing'}"
        if report.last_refusal is not None:
            why += f", and refused the last scan because of: {report.last_refusal}"
        return DeviceError(
            f"the service made no look of {self.robot.name!r} for session {session.id} from the {report.scans} scans "
            f"that it received: {why}; expected a mapping of {self.revolutions} revolutions in a look: {_FITTING}"
        )

    def _taken(self, session: Session, sensor: SensorConfiguration, version: int | None) -> EpisodeLook:
        after = self.client.get_session(session.id)
        if after.version == version:
            return EpisodeLook(sensor.name, None, after, None)
        newest = list(self.client.history(session.id))[-1]
        return EpisodeLook(sensor.name, ScanRequest.model_validate(newest.request), after, newest.update)


def _is_about_robots(error: ProblemError) -> bool:
    """True if a session was refused because of the robots that it claims."""
    return error.kind == "claim-conflict" or "body.robots" in error.problem.detail
