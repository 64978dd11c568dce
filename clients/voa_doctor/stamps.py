"""Checks of the stamps of a topic's messages: the clock that made them runs, and is right."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from voa_doctor.findings import Finding
from voa_doctor.over_http import CLOCK_S
from voa_doctor.scans import in_segments
from voa_ros.messages import LaserScan, Odometry, PoseWithCovariance, Stamp
from voa_ros.robot_places import AttachmentPlace, SensorPlace
from voa_ros.robots import RobotMapping

_TRAVELS_S = 0.5
"""Largest plausible age of a received scan, seconds: a revolution of 0.2 s, and the time on the network."""
_SIMULATED_S = 1e8
"""Stamps before this time (1973), in seconds since 1970, are simulated or of a clock that was never set."""


@dataclass(frozen=True)
class Stamped:
    """A decoded message with its time of receipt, seconds since 1970."""

    message: LaserScan | Odometry | PoseWithCovariance
    at_s: float


def clock(check: str, robot: RobotMapping, what: str, received: Sequence[Stamped]) -> Finding:
    """Check the stamps of messages.

    Args:
        check: name of the check.
        robot: the mapping of the robot.
        what: a few words about the messages, with which the finding begins.
        received: messages without copies, in order of receipt, at least one.
    """
    stamps = [one.message.stamp for one in received]
    driver = "make the driver stamp its messages: check that its clock, or /clock of a simulation, runs"
    if Stamp() in stamps:
        return Finding(check, "warning", f"{what}, stamped 0: {_consequence(robot)}", driver)
    if _is_frozen(received):
        return Finding(check, "warning", f"{what}, and the stamp does not change: {_consequence(robot)}", driver)
    if any(next_ < earlier for earlier, next_ in pairwise(stamps)):
        seen = f"{what}, and some stamps go back in time: {_consequence(robot)}"
        return Finding(
            check,
            "warning",
            seen,
            "check that a single driver publishes on this topic, and that its clock is not set again and again",
        )
    if isinstance(received[0].message, PoseWithCovariance):
        return Finding(check, "ok", f"{what}; AMCL publishes when the robot has moved, so old messages are normal")
    return _right(check, what, received[0])


def _right(check: str, what: str, first: Stamped) -> Finding:
    stamped_s = first.message.stamp.seconds
    if stamped_s < _SIMULATED_S:
        seen = f"{what}, stamped {stamped_s:.2f} s: simulated time, or a clock that was never set"
        advice = "in a simulation: use_sim_time for all of its nodes; on a robot: set its clock by NTP or chrony"
        return Finding(check, "warning", seen, advice)
    late = first.at_s - stamped_s
    seen = f"{what}, stamped {abs(late):.2f} s {'before' if late >= 0.0 else 'after'} it was received"
    if -CLOCK_S <= late <= _TRAVELS_S:
        return Finding(check, "ok", seen)
    return Finding(check, "warning", seen, "set the robot's clock by NTP or chrony")


def _is_frozen(received: Sequence[Stamped]) -> bool:
    """Return True if three messages in a row, or both of two, have the same stamp and are no segments of a turn."""
    scans = [one.message for one in received if isinstance(one.message, LaserScan)]
    if scans and in_segments(scans):
        return False
    stamps = [one.message.stamp for one in received]
    length = min(3, len(stamps))
    return length > 1 and any(len(set(stamps[at : at + length])) == 1 for at in range(len(stamps) - length + 1))


def _consequence(robot: RobotMapping) -> str:
    if isinstance(robot.place, SensorPlace | AttachmentPlace):
        return "no harm is done, because the mapping does not use the robot's own pose"
    return "scans are placed by the newest pose, whatever its time"
