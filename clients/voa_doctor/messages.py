"""Checks of a mapped topic's messages: type, usability, and clock."""

from collections.abc import Sequence

from voa_doctor.findings import Finding
from voa_doctor.samples import Sample
from voa_doctor.scans import layout, unusable
from voa_doctor.stamps import Stamped, clock
from voa_ros.cdr import InvalidCdr, decode_laser_scan, decode_odometry, decode_pose
from voa_ros.messages import LaserScan, Odometry, PoseWithCovariance, Stamp
from voa_ros.repeats import payload_digest
from voa_ros.robots import RobotMapping, Subscription
from voa_ros.topics import LASER_SCAN, ODOMETRY

_MOST_COPIES = 4
"""Copies of a message that several bridges may bring; more come from a driver that repeats it."""


def judged(check: str, robot: RobotMapping, each: Subscription, samples: Sequence[Sample], most_beams: int) -> Finding:
    """Check the messages of a topic.

    Args:
        check: name of the check.
        robot: the mapping of the robot.
        each: the topic, with the expected type.
        samples: of the topic, in order of receipt, at least one.
        most_beams: largest number of beams that the service accepts.
    """
    named = next((sample.type_name for sample in samples if sample.type_name not in (None, each.type.name)), None)
    right = f"expected a {each.type.name}: correct the topic in the mapping, or what publishes on it"
    if named is not None:
        return Finding(check, "wrong", f"found a {named}", right)
    try:
        stamped = [Stamped(_decoded(each, sample.payload), sample.at_s) for sample in samples]
    except InvalidCdr as error:
        return Finding(check, "wrong", str(error), right)
    scans = [one.message for one in stamped if isinstance(one.message, LaserScan)]
    wrong = unusable(check, robot, scans, most_beams) if scans else None
    if wrong is not None:
        return wrong
    of_frame = [(one, sample) for one, sample in zip(stamped, samples, strict=True) if _is_used(robot, one)]
    used = _without_copies(of_frame)
    if len(of_frame) > _MOST_COPIES and len(used) == 1:
        seen = f"the same message was received {len(of_frame)} times, with the same stamp: it is used once"
        return Finding(check, "wrong", seen, "restart the driver: it repeats an old message")
    return clock(check, robot, _described(each, used), used)


def other_domains(samples: Sequence[Sample], used: Sequence[Sample]) -> str:
    """Name the ROS domains whose messages are ignored, as the end of a sentence; "" if there are none."""
    domains = sorted({sample.domain for sample in samples if sample not in used and sample.domain is not None})
    return f"; those of ROS domain {' and '.join(map(str, domains))} are ignored" if domains else ""


def _is_used(robot: RobotMapping, one: Stamped) -> bool:
    scan = one.message
    return not isinstance(scan, LaserScan) or robot.frame_id in (None, scan.frame_id)


def _without_copies(received: Sequence[tuple[Stamped, Sample]]) -> list[Stamped]:
    """Remove copies, which several bridges bring; messages stamped 0 are kept, because copies cannot be recognised."""
    known: set[bytes] = set()
    kept = []
    for one, sample in received:
        digest = payload_digest(sample.payload)
        if one.message.stamp == Stamp() or digest not in known:
            kept.append(one)
            known.add(digest)
    return kept


def _described(each: Subscription, used: Sequence[Stamped]) -> str:
    scans = [one.message for one in used if isinstance(one.message, LaserScan)]
    return layout(scans) if each.type == LASER_SCAN else "received"


def _decoded(each: Subscription, payload: bytes) -> LaserScan | Odometry | PoseWithCovariance:
    if each.type == LASER_SCAN:
        return decode_laser_scan(payload, len(payload))  # the number of beams is checked apart
    return decode_odometry(payload) if each.type == ODOMETRY else decode_pose(payload)
