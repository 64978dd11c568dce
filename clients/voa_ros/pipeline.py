"""The messages of one mapped robot, turned into looks: the way is the same live and in a replay.

A message passes these steps, each in a module of its own: its bytes are read (`cdr`), its header is checked
(`messages`), scans of other frames are left out (`frames`), scans that arrive twice are dropped (`repeats`), a lidar
that hangs upside down is turned over (`grids`), segments become turns (`turns`), the lidar's pose is found (`places`),
and revolutions are gathered into looks (`looks`).
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
"""As many may bring the same scan of one robot."""
_FROZEN = 2
"""Scans in a row with the stamp of the one before them that show a clock that does not run."""


class UnusableMessage(ValueError):
    """A message that cannot be used; says what was expected."""


class UnreadableMessage(UnusableMessage):
    """Bytes that are not the message they should be."""


class ContradictoryHeader(UnusableMessage):
    """A scan whose angles contradict one another."""


@dataclass(frozen=True)
class Received:
    """A message on one of a robot's topics.

    Attributes:
        type: of the topic that it came on.
        payload: CDR.
        received_s: when it arrived, by any steady clock (of a recording: its log time).
        attached: sent beside it; where the scan was taken, for `place = {from = "attachment"}`.
    """

    type: MessageType
    payload: bytes
    received_s: float
    attached: Attachment | None = None


class LookPipeline:
    """Turns the messages of one mapped robot into looks."""

    def __init__(self, mapping: RobotMapping, grid: BeamGrid, most_beams: int = MOST_BEAMS) -> None:
        """Begin with no message.

        Args:
            mapping: of the robot.
            grid: beams of the scenario's lidar.
            most_beams: scans with more are refused.
        """
        self._mapping = mapping
        self._grid = grid
        self._most_beams = most_beams
        self._localisation = localisation(mapping)
        self._frames = FrameFilter(mapping.frame_id)
        self._repeats = Repeats()
        self._turns = SegmentJoiner[Received](grid)
        self._taker = LookTaker(mapping.name, mapping.look, grid)
        self._newest: Stamp | None = None
        self._frozen = 0
        self._waiting_for: str | None = self._taker.waiting_for

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet, in words; None where each scan is a look."""
        return self._waiting_for

    @property
    def requested(self) -> bool:
        """Whether a look was requested and not taken yet."""
        return self._taker.requested

    @property
    def standing(self) -> int:
        """Revolutions of the present stop so far."""
        return self._taker.standing

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Probable mistakes in how the robot is used."""
        if not self._taker.parked:
            return []
        detail = (
            f"every scan is a look (mode 'every'), and the last {PARKED} or more were taken from one place: they "
            "repeat the same errors, and the belief grows falsely certain; use mode 'stationary', or drive on"
        )
        return [ProbableMistake(kind="every-while-parked", detail=detail)]

    def request(self) -> None:
        """Ask for a look; raises ValueError where looks are not taken on request."""
        self._taker.request()
        self._waiting_for = self._taker.waiting_for

    def resume(self, request: ScanRequest) -> None:
        """Take note of the newest look that the robot's session has; see `LookTaker.resume`."""
        self._taker.resume(request)

    def rejected(self, reason: str, request: ScanRequest | None = None) -> None:
        """Let the next revolutions make another look: the last one was not accepted; see `LookTaker.rejected`."""
        self._taker.rejected(reason, request)
        self._waiting_for = self._taker.waiting_for

    def restart(self) -> None:
        """Begin the looks anew, for another session; poses, and a look that was requested, are kept."""
        requested = self.requested
        self._taker = LookTaker(self._mapping.name, self._mapping.look, self._grid)
        if requested:
            self._taker.request()
        self._waiting_for = self._taker.waiting_for

    def receive(self, message: Received) -> GatheredLook | Waiting | None:
        """Take a message, in the order in which they come.

        Returns:
            A look, or the condition that is not met yet; None for what is no scan.

        Raises:
            UnusableMessage: it cannot be used, or it is not known where the lidar was.
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
        if not self._of_our_frame(scan):
            return self._of_another_frame()
        if self._repeats.is_repeated(scan, payload_digest(message.payload)):
            return self._repeated()
        scan = without_measured_limits(scan)
        upright = upside_down(scan) if self._mapping.lidar.upside_down else scan
        turn = self._turns.receive(upright, message, message.received_s)
        if turn is None:
            return self._wait(f"a whole turn of the lidar: segments of it so far: {self._turns.segments}")
        where = self._where(turn.scan, turn.message)
        found = self._taker.receive(turn.scan, where)
        self._waiting_for = self._taker.waiting_for
        if isinstance(where, NoPose):
            raise UnusableMessage(f"it is not known where the lidar was: {where.reason}")
        return found

    def _wait(self, reason: str) -> Waiting:
        self._waiting_for = reason
        return Waiting(reason)

    def _repeated(self) -> Waiting:
        """Two bridges bring each scan twice, and that is all right; nothing else for a while is not."""
        reason = "a scan that was not received before: this one equals an earlier one, stamp included"
        return self._wait(reason) if self._repeats.in_a_row > _MOST_PUBLISHERS else Waiting(reason)

    def _of_another_frame(self) -> Waiting:
        """Other echoes beside the one that is used are all right; nothing but others is not."""
        found = ", ".join(map(repr, self._frames.others))
        reason = f"a scan of frame {self._mapping.frame_id!r}: found {found}"
        return self._wait(reason) if self._frames.missing else Waiting(reason)

    def _of_our_frame(self, scan: LaserScan) -> bool:
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
                beside = message.attached or Attachment()
                return beside.sensor or beside.sensor_pose or NoPose("the attachment of the scan does not say")
            case _ if self._localisation is not None:
                return self._localisation.at(self._time_s(scan), message.received_s)
        return NoPose("nothing tells")

    def _time_s(self, scan: LaserScan) -> float | None:
        """Middle of the revolution by the robot's clock; None: the stamp is 0, frozen or set back, and says nothing."""
        before, self._newest = self._newest, scan.stamp
        self._frozen = self._frozen + 1 if before == scan.stamp else 0
        set_back = before is not None and scan.stamp < before
        if scan.stamp == Stamp() or self._frozen >= _FROZEN or set_back:
            return None
        return middle_s(scan, self._mapping.stamp)
