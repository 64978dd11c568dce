"""One mapped ROS 2 robot: what was heard of it, the session that its scans are for, and the looks that follow."""

import threading
import time
from dataclasses import dataclass

from voa_msgs.keys import Attachment
from voa_msgs.sessions import ScanRequest
from voa_ros.cdr import InvalidCdr, decode_laser_scan, decode_odometry, decode_pose
from voa_ros.looks import LookTaker, Taken, Waiting, Where, robot_of
from voa_ros.places import NoPose, localisation, middle_s
from voa_ros.robots import AttachmentPlace, RobotMapping, SensorPlace
from voa_ros.topics import LASER_SCAN, ODOMETRY, MessageType
from voa_service.failures import INVALID, Failure, not_found
from voa_service.rpc import attachment_of
from voa_service.services import Services

LOOK_SECONDS = 1.0
"""How late a change of the mapping, or a new session on a mapped scenario, is noticed."""
_NEWEST = 50
"""Versions of a session among which the newest look of a robot is searched."""


@dataclass(frozen=True)
class Heard:
    """A message on one of a robot's topics."""

    type: MessageType
    key: str
    payload: bytes
    attachment: bytes | None


class MappedRobot:
    """One mapped robot: what was heard of it, and the looks that follow."""

    def __init__(self, mapping: RobotMapping, services: Services) -> None:
        self.mapping = mapping
        self.name = mapping.name
        self._services = services
        self._localisation = localisation(mapping)
        self._taker = LookTaker(mapping.name, mapping.look)
        self._session: str | None = None
        self._order = -1
        self._looked_for_session = -LOOK_SECONDS
        self._lock = threading.Lock()

    @property
    def waiting_for(self) -> str | None:
        """See `LookTaker`."""
        return self._taker.waiting_for

    @property
    def session(self) -> str | None:
        """The session that its scans are for, as far as that is known."""
        return self._session or self.mapping.session

    def has_look(self, request: ScanRequest) -> None:
        """The session has this look of the robot, whoever applied it."""
        with self._lock:
            self._taker.resume(request)

    def request(self) -> None:
        """See `LookTaker`."""
        with self._lock:
            self._taker.request()

    def heard(self, heard: Heard) -> tuple[str, Taken] | None:
        """Take a message in; a look for a session, where there is one now.

        Raises:
            Failure: it cannot be used.
        """
        with self._lock:
            try:
                return self._heard(heard)
            except InvalidCdr as error:
                raise Failure(INVALID, str(error)) from error

    def _heard(self, heard: Heard) -> tuple[str, Taken] | None:
        if heard.type == ODOMETRY and self._localisation is not None:
            self._localisation.hear_odometry(decode_odometry(heard.payload))
            return None
        if heard.type != LASER_SCAN and self._localisation is not None:
            self._localisation.hear_amcl(decode_pose(heard.payload))
            return None
        self._services.robots.heard(self.name, "ros2", heard.key, self._session)
        scan = decode_laser_scan(heard.payload, self._services.limits.beams)
        session = self._current_session()
        where = self._where(middle_s(scan, self.mapping.stamp), heard.attachment)
        found = self._taker.heard(scan, where)
        if isinstance(found, Waiting):
            if isinstance(where, NoPose):
                raise Failure(INVALID, f"it is not known where the lidar was: {where.reason}")
            return None
        return session, found

    def _where(self, at_s: float, attachment: bytes | None) -> Where | NoPose:
        match self.mapping.place:
            case SensorPlace(sensor=sensor):
                return sensor
            case AttachmentPlace():
                beside: Attachment = attachment_of(attachment)
                return beside.sensor or beside.sensor_pose or NoPose("the attachment of the scan does not say")
            case _:
                return NoPose("nothing tells") if self._localisation is None else self._localisation.at(at_s)

    def _current_session(self) -> str:
        """The session that the scans are for; where it is another one now, the looks begin anew.

        Raises:
            Failure: there is none.
        """
        now = time.monotonic()
        if self._session is not None and now - self._looked_for_session < LOOK_SECONDS:
            return self._session
        session = self._mapped_session()
        self._looked_for_session = now
        if session != self._session:
            newest = last_look(self._services, session, self.name)
            requested = self._taker.requested
            self._taker = LookTaker(self.name, self.mapping.look)
            if newest is not None:
                self._taker.resume(newest)
            if requested:
                self._taker.request()
            self._session = session
        return session

    def _mapped_session(self) -> str:
        sessions = self._services.sessions
        if self.mapping.session is not None:
            return self.mapping.session
        scenario = self.mapping.scenario or ""
        newest = sessions.newest(scenario)
        # When the newest one is deleted, an older one, which may be finished, is not to be changed any more.
        if newest is None or newest.order < self._order:
            raise not_found("session yet on scenario", scenario)
        self._order = newest.order
        return newest.id


def last_look(services: Services, session: str, robot: str) -> ScanRequest | None:
    """The newest look of a robot in a session's history.

    Raises:
        Failure: there is no such session.
    """
    for entry in services.sessions.newest_entries(session, _NEWEST):
        if entry.kind == "scan":
            request = ScanRequest.model_validate_json(entry.request)
            if robot_of(request) == robot:
                return request
    return None
