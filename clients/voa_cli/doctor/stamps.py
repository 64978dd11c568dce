"""Stamps of the messages of a topic: does the clock behind them run, and is it right."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from voa_cli.doctor.findings import Finding
from voa_cli.doctor.over_http import CLOCK_S
from voa_cli.doctor.scans import in_segments
from voa_ros.messages import LaserScan, Odometry, PoseWithCovariance, Stamp
from voa_ros.robot_places import AttachmentPlace, SensorPlace
from voa_ros.robots import RobotMapping

_TRAVELS_S = 0.5
"""A scan is stamped at the beginning of its revolution of 0.2 s, or at its end, and travels."""
_SIMULATED_S = 1e8
"""No clock that was ever set says a time before 1973."""


@dataclass(frozen=True)
class Stamped:
    """A message, and when it came in seconds since 1970."""

    message: LaserScan | Odometry | PoseWithCovariance
    at_s: float


def clock(check: str, robot: RobotMapping, what: str, received: Sequence[Stamped]) -> Finding:
    """Judge the stamps of messages.

    Args:
        check: name of the line.
        robot: whose messages they are.
        what: the messages in a few words, with which the finding begins.
        received: in the order in which they came, without copies, at least one.
    """
    stamps = [one.message.stamp for one in received]
    driver = "have the driver stamp its messages: is its clock, or /clock of a simulation, running?"
    if Stamp() in stamps:
        return Finding(check, "warning", f"{what}, stamped 0: {_consequence(robot)}", driver)
    if _is_frozen(received):
        return Finding(check, "warning", f"{what}, and the stamp stands still: {_consequence(robot)}", driver)
    if any(later < earlier for earlier, later in pairwise(stamps)):
        seen = f"{what}, and the stamps run backwards now and then: {_consequence(robot)}"
        return Finding(check, "warning", seen, "do two drivers publish on this topic? is the clock being set?")
    if isinstance(received[0].message, PoseWithCovariance):
        return Finding(check, "ok", f"{what}; AMCL publishes when the robot has moved, so its age says nothing")
    return _right(check, what, received[0])


def _right(check: str, what: str, first: Stamped) -> Finding:
    stamped_s = first.message.stamp.seconds
    if stamped_s < _SIMULATED_S:
        seen = f"{what}, stamped {stamped_s:.2f} s: simulated time, or a clock that was never set"
        advice = "in a simulation: use_sim_time for all of its nodes; on a robot: set its clock by NTP or chrony"
        return Finding(check, "warning", seen, advice)
    late = first.at_s - stamped_s
    seen = f"{what}, stamped {abs(late):.2f} s {'before' if late >= 0.0 else 'after'} it came"
    if -CLOCK_S <= late <= _TRAVELS_S:
        return Finding(check, "ok", seen)
    return Finding(check, "warning", seen, "set the robot's clock by NTP or chrony")


def _is_frozen(received: Sequence[Stamped]) -> bool:
    """Whether three messages in a row, or all of two, have one stamp; the segments of one turn may."""
    scans = [one.message for one in received if isinstance(one.message, LaserScan)]
    if scans and in_segments(scans):
        return False
    stamps = [one.message.stamp for one in received]
    length = min(3, len(stamps))
    return length > 1 and any(len(set(stamps[at : at + length])) == 1 for at in range(len(stamps) - length + 1))


def _consequence(robot: RobotMapping) -> str:
    if isinstance(robot.place, SensorPlace | AttachmentPlace):
        return "nothing depends on it, since the mapping does not ask the robot where it is"
    return "scans are placed by the pose that came last"
