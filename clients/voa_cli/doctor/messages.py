"""Messages of a mapped topic: are they of the right type, do their headers make sense, do their clocks run."""

from collections.abc import Sequence
from itertools import pairwise

from voa_cli.doctor.findings import Finding
from voa_cli.doctor.over_http import CLOCK_S
from voa_cli.doctor.samples import Sample
from voa_cli.limits import most_beams
from voa_ros.cdr import InvalidCdr, decode_laser_scan, decode_odometry, decode_pose
from voa_ros.messages import LaserScan, Odometry, PoseWithCovariance, Stamp, header_contradiction
from voa_ros.robots import RobotMapping, Subscription
from voa_ros.topics import LASER_SCAN, ODOMETRY

_TRAVELS_S = 0.5
"""A scan is stamped at the beginning of its revolution of 0.2 s, or at its end, and travels."""

_Message = LaserScan | Odometry | PoseWithCovariance


def judged(check: str, robot: RobotMapping, each: Subscription, samples: Sequence[Sample]) -> Finding:
    """Judge the messages of one topic.

    Args:
        check: name of the line.
        robot: whose topic it is.
        each: the topic and the type that is expected on it.
        samples: of the topic, in the order in which they came, at least one.
    """
    named = next((sample.type_name for sample in samples if sample.type_name not in (None, each.type.name)), None)
    if named is not None:
        return Finding(check, "wrong", f"found a {named}", f"expected {each.type.name}: is it the right topic?")
    try:
        messages = [_decoded(each, sample.payload) for sample in samples]
    except InvalidCdr as error:
        return Finding(check, "wrong", str(error), f"expected {each.type.name}: is it the right topic?")
    scans = [message for message in messages if isinstance(message, LaserScan)]
    return (_scans_wrong(check, robot, scans) if scans else None) or _clock(check, messages, samples[0].at_s)


def _scans_wrong(check: str, robot: RobotMapping, scans: Sequence[LaserScan]) -> Finding | None:
    """Whatever keeps scans from being used."""
    wrong = next((why for scan in scans if (why := header_contradiction(scan)) is not None), None)
    if wrong is not None:
        return Finding(check, "wrong", wrong, "scans with such a header are refused: correct the driver's settings")
    frames = sorted({scan.frame_id for scan in scans})
    listed = ", ".join(repr(frame) for frame in frames)
    if robot.frame_id is None and len(frames) > 1:
        seen = f"scans of {len(frames)} frames come on this topic: {listed}"
        return Finding(check, "wrong", seen, f"say which are used: frame_id = {frames[0]!r} in the mapping")
    if robot.frame_id is not None and robot.frame_id not in frames:
        seen = f"scans are of frame {listed}, the mapping says {robot.frame_id!r}"
        return Finding(check, "wrong", seen, "correct frame_id in the mapping, or leave it out")
    return None


def _clock(check: str, messages: Sequence[_Message], came_s: float) -> Finding:
    stamps = [message.stamp for message in messages]
    first = messages[0]
    beams = f"{len(first.ranges)} beams" if isinstance(first, LaserScan) else "received"
    by_arrival = "they are matched with the pose that was received last"
    if stamps[0] == Stamp():
        return Finding(check, "warning", f"{beams}, stamped 0: {by_arrival}", "have the driver stamp its messages")
    if len(stamps) > 1 and len(set(stamps)) == 1:
        seen = f"{beams}, and the stamp does not change: {by_arrival}"
        return Finding(check, "warning", seen, "have the driver stamp its messages; is its clock, or /clock, running?")
    if any(later < earlier for earlier, later in pairwise(stamps)):
        seen = f"{beams}, and the stamps run backwards now and then: {by_arrival}"
        return Finding(check, "warning", seen, "do two drivers publish on this topic? is the clock being set?")
    if isinstance(first, PoseWithCovariance):
        return Finding(check, "ok", "received; AMCL publishes when the robot has moved, so its age says nothing")
    late = came_s - stamps[0].seconds
    if -CLOCK_S <= late <= _TRAVELS_S:
        return Finding(check, "ok", f"{beams}, stamped {late:.2f} s before it came")
    seen = f"{beams}, stamped {abs(late):.2f} s {'before' if late > 0.0 else 'after'} it came"
    return Finding(check, "warning", seen, "set the robot's clock by NTP or chrony")


def _decoded(each: Subscription, payload: bytes) -> _Message:
    if each.type == LASER_SCAN:
        return decode_laser_scan(payload, most_beams())
    return decode_odometry(payload) if each.type == ODOMETRY else decode_pose(payload)
