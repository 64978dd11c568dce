"""Pipeline from the messages of one mapped robot to its looks, for live robots and for replays.

A message passes these steps, each in a module of its own: its bytes are decoded (`cdr`), its header is checked
(`messages`), scans of other frames are dropped (`frames`), scans that arrive twice are dropped (`repeats`), the scan of
a lidar that hangs upside down is mirrored (`grids`), segments are joined to revolutions (`segments`), the pose of the
lidar is determined (`localisation`), and revolutions are gathered into looks (`look_taker`).
"""

from dataclasses import dataclass

from voa_msgs.keys import Attachment
from voa_msgs.sessions import ScanRequest
from voa_msgs.warnings import ProbableMistake
from voa_ros.cdr import MOST_BEAMS, InvalidCdr, decode_laser_scan, decode_odometry, decode_pose
from voa_ros.frames import FrameFilter
from voa_ros.grids import BeamGrid, upside_down, without_measured_limits
from voa_ros.localisation import localisation, middle_s
from voa_ros.look_taker import PARKED, LookTaker
from voa_ros.looks import GatheredLook, Waiting, Where
from voa_ros.messages import LaserScan, Stamp, header_contradiction
from voa_ros.repeats import Repeats, payload_digest
from voa_ros.robot_places import AttachmentPlace, SensorPlace
from voa_ros.robots import RobotMapping
from voa_ros.segments import SegmentJoiner
from voa_ros.topics import LASER_SCAN, ODOMETRY, MessageType
from voa_ros.tracks import NoPose

_MOST_PUBLISHERS = 4
"""Number of publishers that may forward the same scan of a robot without a report."""
_FROZEN = 2
"""Successive scans with an unchanged stamp that show a clock that does not run."""


class UnusableMessage(ValueError):
    """Error for a message that cannot be used; its text says what was expected."""


class UnreadableMessage(UnusableMessage):
    """Error for bytes that are not the expected message."""


class ContradictoryHeader(UnusableMessage):
    """Error for a scan whose angles contradict one another."""


@dataclass(frozen=True)
class Received:
    """Message that was received on a topic of a robot.

    Attributes:
        type: type of the topic.
        payload: bytes of the message, CDR.
        received_s: time of arrival, seconds by any steady clock (in a recording: its log time).
        attached: attachment of the sample, with the place of the scan for `place = {from = "attachment"}`.
    """

    type: MessageType
    payload: bytes
    received_s: float
    attached: Attachment | None = None


@dataclass(frozen=True)
class SeenScan:
    """Revolution that could be decoded, whether a look is made of it or not.

    Attributes:
        scan: as it is used, that of a lidar that hangs mirrored.
        where: pose of the lidar, or the name of its sensor configuration; None: not known.
    """

    scan: LaserScan
    where: Where | None


class LookPipeline:
    """Pipeline that turns the messages of one mapped robot into looks."""

    def __init__(self, mapping: RobotMapping, grid: BeamGrid, most_beams: int = MOST_BEAMS) -> None:
        """Start with no message.

        Args:
            mapping: mapping of the robot.
            grid: grid of the scenario's lidar.
            most_beams: largest number of beams of a scan that is accepted.
        """
        self._mapping = mapping
        self._grid = grid
        self._most_beams = most_beams
        self._localisation = localisation(mapping)
        self._frames = FrameFilter(mapping.frame_id)
        self._repeats = Repeats()
        self._segments = SegmentJoiner[Received](grid)
        self._taker = LookTaker(mapping.name, mapping.look, grid)
        self._newest: Stamp | None = None
        self._frozen = 0
        self._seen: SeenScan | None = None
        self._waiting_for: str | None = self._taker.waiting_for

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet, in words; None where each scan is a look."""
        return self._waiting_for

    @property
    def requested(self) -> bool:
        """True if a look was requested and not taken yet."""
        return self._taker.requested

    @property
    def seen(self) -> SeenScan | None:
        """Newest revolution that could be decoded; None: there is none."""
        return self._seen

    @property
    def standing(self) -> int:
        """Number of revolutions of the present stop so far."""
        return self._taker.standing

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Probable mistakes in how the robot is used."""
        if not self._taker.parked:
            return []
        detail = (
            f"every scan is a look (mode 'every'), and the last {PARKED} or more were taken from one place: they "
            "repeat the same errors, so that the belief becomes falsely certain; use mode 'stationary', or drive on"
        )
        return [ProbableMistake(kind="every-while-parked", detail=detail)]

    def request(self) -> None:
        """Request a look; raises ValueError where the mode of the robot is not `on_request`."""
        self._taker.request()
        self._waiting_for = self._taker.waiting_for

    def resume(self, request: ScanRequest) -> None:
        """Register the newest look of the robot in its session, as `LookTaker.resume` explains."""
        self._taker.resume(request)

    def rejected(self, reason: str, request: ScanRequest | None = None) -> None:
        """Let the next revolutions make another look, because the last one was not accepted (`LookTaker.rejected`)."""
        self._taker.rejected(reason, request)
        self._waiting_for = self._taker.waiting_for

    def restart(self) -> None:
        """Start gathering looks again for another session; poses and a requested look are kept."""
        requested = self.requested
        self._taker = LookTaker(self._mapping.name, self._mapping.look, self._grid)
        if requested:
            self._taker.request()
        self._waiting_for = self._taker.waiting_for

    def receive(self, message: Received) -> GatheredLook | Waiting | None:
        """Process a message, in the order of arrival.

        Returns:
            A look, or the condition for the next look that is not met yet; None for a message that is not a scan.

        Raises:
            UnusableMessage: the message cannot be used, or the pose of the lidar is not known.
        """
        try:
            return self._receive(message)
        except InvalidCdr as error:
            raise UnreadableMessage(str(error)) from error

    def _receive(self, message: Received) -> GatheredLook | Waiting | None:
        if message.type == LASER_SCAN:
            return self._receive_scan(message)
        if self._localisation is not None and message.type == ODOMETRY:
            self._localisation.receive_odometry(decode_odometry(message.payload), message.received_s)
        elif self._localisation is not None:
            self._localisation.receive_amcl(decode_pose(message.payload), message.received_s)
        return None

    def _receive_scan(self, message: Received) -> GatheredLook | Waiting:
        self._waiting_for = "a scan that can be used"
        scan = decode_laser_scan(message.payload, self._most_beams)
        wrong = header_contradiction(scan)
        if wrong is not None:
            raise ContradictoryHeader(wrong)
        self._waiting_for = self._taker.waiting_for
        if not self._has_our_frame(scan):
            return self._skip_frame()
        if self._repeats.is_repeated(scan, payload_digest(message.payload)):
            return self._skip_repetition()
        scan = without_measured_limits(scan)
        upright = upside_down(scan) if self._mapping.lidar.upside_down else scan
        revolution = self._segments.receive(upright, message, message.received_s)
        if revolution is None:
            return self._wait(f"a whole revolution of the lidar: {self._segments.segments} segments received so far")
        where = self._where(revolution.scan, revolution.message)
        self._seen = SeenScan(revolution.scan, None if isinstance(where, NoPose) else where)
        result = self._taker.receive(revolution.scan, where)
        self._waiting_for = self._taker.waiting_for
        if isinstance(where, NoPose):
            raise UnusableMessage(f"it is not known where the lidar was: {where.reason}")
        return result

    def _wait(self, reason: str) -> Waiting:
        self._waiting_for = reason
        return Waiting(reason)

    def _skip_repetition(self) -> Waiting:
        """Wait for a new scan; report it only when there are more repetitions than several bridges would cause."""
        reason = "a scan that was not received before: this one equals an earlier one, stamp included"
        return self._wait(reason) if self._repeats.in_a_row > _MOST_PUBLISHERS else Waiting(reason)

    def _skip_frame(self) -> Waiting:
        """Wait for a scan of the frame; report it only when none of the latest scans has that frame."""
        others = ", ".join(map(repr, self._frames.others))
        reason = f"a scan of frame {self._mapping.frame_id!r}: found {others}"
        return self._wait(reason) if self._frames.missing else Waiting(reason)

    def _has_our_frame(self, scan: LaserScan) -> bool:
        try:
            return self._frames.receive(scan.frame_id)
        except ValueError as error:
            self._waiting_for = "scans of one frame"
            raise UnusableMessage(str(error)) from error

    def _where(self, scan: LaserScan, message: Received) -> Where | NoPose:
        match self._mapping.place:
            case SensorPlace(sensor=sensor):
                return sensor
            case AttachmentPlace():
                attached = message.attached or Attachment()
                return attached.sensor or attached.sensor_pose or NoPose("the attachment of the scan does not state it")
            case _ if self._localisation is not None:
                return self._localisation.at(self._time_s(scan), message.received_s)
        return NoPose("the mapping has no source of poses")

    def _time_s(self, scan: LaserScan) -> float | None:
        """Return the time of the middle of the revolution by the robot's clock; None: the stamp cannot be used."""
        before, self._newest = self._newest, scan.stamp
        self._frozen = self._frozen + 1 if before == scan.stamp else 0
        set_back = before is not None and scan.stamp < before
        if scan.stamp == Stamp() or self._frozen >= _FROZEN or set_back:
            return None
        return middle_s(scan, self._mapping.stamp)
