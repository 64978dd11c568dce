"""A simulated robot that parks at stops in a room and drives between them, and the messages that it sends.

The room is 3 m by 3 m; nothing in it is symmetric about the world's origin. Every beam is measured from where the robot
is at that moment.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from random import Random

from voa_ros.cdr import MOST_BEAMS, encode_laser_scan, encode_odometry, encode_pose
from voa_ros.grids import BeamGrid, upside_down
from voa_ros.looks import GatheredLook
from voa_ros.messages import LaserScan, Odometry, Pose, PoseWithCovariance, Stamp
from voa_ros.motions import Motion, composed, inverse, wrapped
from voa_ros.pipeline import LookPipeline, Received, UnusableMessage
from voa_ros.robots import load
from voa_ros.topics import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE_STAMPED

NOWHERE_ELSE = Motion(0.0, 0.0, 0.0)
GRID = BeamGrid(120, 0.0, math.tau / 120)
STOPS = (
    Motion(-0.8, -0.3, 0.0),
    Motion(-0.2, -0.4, 0.5),
    Motion(0.5, -0.1, 1.2),
    Motion(0.6, 0.6, 2.5),
    Motion(-0.3, 0.9, -2.2),
)
PARKED_S = 4.0
DRIVING_S = 3.0
LEG_S = PARKED_S + DRIVING_S
START_S = 1_000.0
"""Time by the robot's clock and by the clock of the receiver, seconds."""
PARKED_AT_S = START_S + 2 * LEG_S + 0.5
"""Half a second into the third stop."""
DRIVING_AT_S = START_S + 2 * LEG_S - 1.52
"""On the way there."""
LATENCY_S = 0.02

Clock = Callable[[float], float]
"""The stamp that a clock gives at a time; both in seconds."""


def true(now_s: float) -> float:
    """A clock that is right."""
    return now_s


def seen_from(place: Motion, angle: float) -> float:
    """Range of the walls from a place in the room, at an angle about it."""
    cos, sin = math.cos(place.yaw_rad + angle), math.sin(place.yaw_rad + angle)
    across = ((1.7 if cos > 0 else -1.3) - place.x) / cos if abs(cos) > 1e-9 else math.inf
    along = ((1.9 if sin > 0 else -1.1) - place.y) / sin if abs(sin) > 1e-9 else math.inf
    return min(across, along)


def between(one: Motion, other: Motion, share: float) -> Motion:
    """On the straight way from one place to another."""
    turned = wrapped(other.yaw_rad - one.yaw_rad)
    return Motion(
        one.x + share * (other.x - one.x), one.y + share * (other.y - one.y), wrapped(one.yaw_rad + share * turned)
    )


@dataclass
class ParkingRobot:
    """A simulated robot: its position, and the messages that it sends.

    Attributes:
        hz: revolutions per second.
        layout: "steady", as an LDS-01; "irregular", as an LDS-02 or LD19; "segments", as a picoScan.
        scan_clock, odometry_clock: what they stamp.
        odometry_frame: in the world.
        lidar: on the robot.
        hangs: whether the lidar hangs upside down.
    """

    hz: float = 10.0
    layout: str = "steady"
    scan_clock: Clock = true
    odometry_clock: Clock = true
    odometry_frame: Motion = NOWHERE_ELSE
    lidar: Motion = NOWHERE_ELSE
    hangs: bool = False
    stops: Sequence[Motion] = STOPS
    frame_id: str = "base_scan"

    @property
    def end_s(self) -> float:
        return START_S + LEG_S * (len(self.stops) - 1) + PARKED_S

    def base(self, now_s: float) -> Motion:
        """The robot in the world."""
        leg, into = divmod(now_s - START_S, LEG_S)
        stop = min(max(int(leg), 0), len(self.stops) - 1)
        driven = max(into - PARKED_S, 0.0) / DRIVING_S if stop < len(self.stops) - 1 else 0.0
        return between(self.stops[stop], self.stops[min(stop + 1, len(self.stops) - 1)], driven)

    def messages(self) -> Iterator[Received]:
        """All that it sends, in the order of arrival."""
        sent = [*self._scans(), *self._odometry()]
        return iter(sorted(sent, key=lambda message: message.received_s))

    def _odometry(self) -> Iterator[Received]:
        for step in range(round((self.end_s - START_S) * 20.0)):
            now_s = START_S + step / 20.0
            pose = composed(inverse(self.odometry_frame), self.base(now_s))
            odometry = Odometry(
                Stamp.of(self.odometry_clock(now_s)), "odom", "base", Pose.planar(pose.x, pose.y, pose.yaw_rad)
            )
            yield Received(ODOMETRY, encode_odometry(odometry), now_s + LATENCY_S)

    def amcl(self) -> Iterator[Received]:
        """Poses of an AMCL whose map is the world: one each quarter metre, a little late."""
        last: Motion | None = None
        for step in range(round((self.end_s - START_S) * 20.0)):
            now_s = START_S + step / 20.0 + 0.013
            pose = self.base(now_s)
            if last is None or math.hypot(pose.x - last.x, pose.y - last.y) > 0.25:
                last = pose
                amcl = PoseWithCovariance(
                    Stamp.of(self.scan_clock(now_s)), "map", Pose.planar(pose.x, pose.y, pose.yaw_rad)
                )
                yield Received(POSE_WITH_COVARIANCE_STAMPED, encode_pose(amcl), now_s + 0.1)

    def _scans(self) -> Iterator[Received]:
        for seen in _seen(self.hz, self.layout, self.lidar, tuple(self.stops)):
            last = seen.low + (len(seen.ranges) - 1) * seen.step
            took_s = len(seen.ranges) * seen.step / math.tau / self.hz
            stamp = Stamp.of(self.scan_clock(seen.begin_s))
            scan = LaserScan(stamp, self.frame_id, seen.low, last, seen.step, 0.0, took_s, 0.1, 8.0, seen.ranges)
            sent = upside_down(scan) if self.hangs else scan  # as it sees the room from below
            yield Received(LASER_SCAN, encode_laser_scan(sent), seen.begin_s + took_s + LATENCY_S)


@dataclass(frozen=True)
class _Seen:
    """A scan without its header."""

    begin_s: float
    low: float
    step: float
    ranges: tuple[float, ...]


@cache
def _seen(hz: float, layout: str, lidar: Motion, stops: tuple[Motion, ...]) -> tuple[_Seen, ...]:
    """Every scan of a drive, which no clock changes."""
    own, chance = ParkingRobot(hz, stops=stops), Random(11)  # noqa: S311  # noise, not a secret
    seen = []
    for turn in range(int((own.end_s - START_S) * hz)):
        begin_s = START_S + 0.003 + turn / hz
        for beams, low, step in _layout(layout, chance):
            ranges = []
            for beam in range(beams):
                angle = low + beam * step
                place = composed(own.base(begin_s + angle / math.tau / hz), lidar)
                ranges.append(seen_from(place, angle) * (1.0 + chance.gauss(0.0, 0.01)))
            seen.append(_Seen(begin_s + low / math.tau / hz, low, step, tuple(ranges)))
    return tuple(seen)


def _layout(layout: str, chance: Random) -> list[tuple[int, float, float]]:
    """Beams, first angle and increment of the scans of a revolution."""
    if layout == "segments":
        return [(20, math.tau * part / 12, math.tau / 240) for part in range(12)]
    if layout == "irregular":
        beams = chance.randrange(226, 234)
        step = math.tau / (beams - 1)
        return [(beams, chance.uniform(0.0, step), step)]
    return [(GRID.beams, 0.0, GRID.angle_increment)]


def with_amcl(own: ParkingRobot, received: Callable[[Received], Received] = lambda message: message) -> list[Received]:
    """All that a robot sends, with what AMCL says as it is received."""
    sent = [*own.messages(), *map(received, own.amcl())]
    return sorted(sent, key=lambda message: message.received_s)


def mapped(
    place: str = 'from = "odometry"', more: str = "", look: str = "", most_beams: int = MOST_BEAMS
) -> LookPipeline:
    """Looks of a robot whose mapping says this of its place, of itself and of its looks."""
    (mapping,) = load(f'[[robot]]\nname = "tb3_1"\nsession = "s"\n{more}\n[robot.look]\n{look}\n[robot.place]\n{place}')
    return LookPipeline(mapping, GRID, most_beams)


@dataclass
class Outcome:
    """Results of the messages of a robot."""

    looks: list[GatheredLook] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    waiting: list[str] = field(default_factory=list)
    """Conditions that were waited for, each change of them."""


def play(looks: LookPipeline, messages: Iterator[Received] | Sequence[Received]) -> Outcome:
    """Send messages to a mapped robot's looks."""
    came = Outcome()
    for message in messages:
        try:
            result = looks.receive(message)
        except UnusableMessage as error:
            came.refused.append(str(error))
        else:
            if isinstance(result, GatheredLook):
                came.looks.append(result)
        now = looks.waiting_for or ""
        if came.waiting[-1:] != [now]:
            came.waiting.append(now)
    return came


def check_places(came: Outcome, places: Sequence[Motion]) -> None:
    """Each stop of the lidar has one look, within a centimetre and a degree of it."""
    poses = [look.request.sensor_pose for look in came.looks]
    assert len(poses) == len(places), [pose and (pose.x, pose.y) for pose in poses]
    for pose, place in zip(poses, places, strict=True):
        assert pose is not None
        assert math.hypot(pose.x - place.x, pose.y - place.y) < 0.01, (pose, place)
        assert abs(wrapped(pose.yaw_rad - place.yaw_rad)) < math.radians(1.0), (pose, place)


def check_looks(came: Outcome, places: Sequence[Motion]) -> None:
    """Each stop of the lidar has one look at its place, of the room as it is seen from there."""
    check_places(came, places)
    for look, place in zip(came.looks, places, strict=True):
        scan = look.request.scan
        assert scan.angle_min is not None
        assert scan.angle_increment is not None
        off = [
            abs(value - seen_from(place, scan.angle_min + beam * scan.angle_increment))
            for beam, value in enumerate(scan.ranges)
            if value is not None
        ]
        assert len(off) > 0.9 * len(scan.ranges)
        assert sum(off) / len(off) < 0.03, sum(off) / len(off)
