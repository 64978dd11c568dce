"""One mapped ROS 2 robot in a service: the session that its scans are for, and the looks that follow.

Every replica receives everything and gathers the same looks. A look is counted once because it has a number: one more
than the looks of this robot that its session has accepted. Which number comes next is read from the session at each
stop, so that a replica that has missed some looks, or was started just now, goes on where the session is.
"""

import threading
import time
from dataclasses import dataclass

from voa_msgs.sessions import ScanRequest
from voa_msgs.warnings import ProbableMistake
from voa_ros.grids import BeamGrid
from voa_ros.mapped import ContradictoryHeader, MappedLooks, Received, UnusableMessage
from voa_ros.robots import AttachmentPlace, RobotMapping
from voa_ros.taken import Taken, robot_of
from voa_ros.topics import LASER_SCAN, MessageType
from voa_service.failures import GRID_MISMATCH, INVALID, Failure, not_found
from voa_service.rpc import attachment_of
from voa_service.services import Services

FOLLOW_SECONDS = 1.0
"""How late a change of the mapping, or of a robot's session, is noticed."""
_NEWEST = 50
"""Versions of a session among which the newest look of a robot is searched."""
_SHOWS_STOP = 2
"""Revolutions of a stop after which the session is asked for looks that other replicas took."""


@dataclass(frozen=True)
class Sample:
    """A message on one of a robot's topics, as it came."""

    type: MessageType
    key: str
    payload: bytes
    attachment: bytes | None
    received_s: float


@dataclass(frozen=True)
class DueLook:
    """A look to be applied to a session, under a number."""

    session: str
    number: int
    taken: Taken


class MappedRobot:
    """One mapped robot; all methods may be called from any thread."""

    def __init__(self, mapping: RobotMapping, services: Services) -> None:
        self.mapping = mapping
        self.name = mapping.name
        self._services = services
        self._looks: MappedLooks | None = None
        self._session: str | None = None
        self._scenario: str | None = None
        self._issued = 0
        """Number of the newest look that was given out, or that the session has."""
        self._followed = -FOLLOW_SECONDS
        self._missing: str | None = None
        self._requested = False
        self._lock = threading.Lock()

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet, in words; None where each scan is a look."""
        if self._missing is not None:
            return self._missing
        if self._looks is None:
            return "a request" if self.mapping.look.mode == "on_request" and not self._requested else "a scan"
        return self._looks.waiting_for

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Probable mistakes in how the robot is used."""
        return [] if self._looks is None else self._looks.warnings

    @property
    def session(self) -> str | None:
        """The session that its scans are for, as far as that is known."""
        return self._session or self.mapping.session

    def request(self) -> None:
        """Ask for a look; raises ValueError where looks are not taken on request."""
        with self._lock:
            if self._looks is not None:
                self._looks.request()
            elif self.mapping.look.mode == "on_request":
                self._requested = True
            else:
                mode = self.mapping.look.mode
                raise ValueError(f"expected a robot in mode 'on_request', {self.name!r} is in mode {mode!r}")

    def accepted(self, number: int) -> None:
        """Note that the session has accepted a look of this robot."""
        with self._lock:
            self._issued = max(self._issued, number)

    def counted(self, number: int, look: ScanRequest | None) -> None:
        """Note that the session has looks up to this number, and which its newest is, whoever applied it."""
        with self._lock:
            if number < self._issued:  # the robot has had a later look since
                return
            self._issued = number
            if look is not None and self._looks is not None:
                self._looks.resume(look)

    def rejected(self, due: DueLook, reason: str) -> None:
        """Let the next revolutions make another look: this one was not accepted."""
        with self._lock:
            if self._issued == due.number:
                self._issued = due.number - 1
            if self._looks is not None and due.session == self._session:
                self._looks.rejected(reason, due.taken.request)

    def receive(self, sample: Sample) -> DueLook | None:
        """Take a message; returns a look for a session, where there is one now.

        Raises:
            Failure: it cannot be used, or there is no session for it.
        """
        with self._lock:
            if sample.type == LASER_SCAN:
                self._services.robots.heard(self.name, "ros2", sample.key, self._session)
            looks = self._following(sample.type)
            if looks is None:
                return None
            attached = attachment_of(sample.attachment) if isinstance(self.mapping.place, AttachmentPlace) else None
            try:
                found = looks.receive(Received(sample.type, sample.payload, sample.received_s, attached))
            except ContradictoryHeader as error:
                raise Failure(GRID_MISMATCH, str(error)) from error
            except UnusableMessage as error:
                raise Failure(INVALID, str(error)) from error
            if isinstance(found, Taken):
                return self._due(found)
            if looks.standing == _SHOWS_STOP and self._session is not None:
                self._catch_up(self._session)
            if sample.type == LASER_SCAN and self._missing is not None:
                raise not_found("session yet on scenario", self.mapping.scenario or "")
            return None

    def _due(self, taken: Taken) -> DueLook:
        session = self._settled()
        if session != self._session:
            self._enter(session)
        self._issued += 1
        return DueLook(session, self._issued, taken)

    def _settled(self) -> str:
        """The session that a look goes to which is due now; from now on it is the robot's.

        Raises:
            Failure: there is none.
        """
        if self.mapping.session is not None:
            return self.mapping.session
        session = self._services.claims.settle(self.name, self.mapping.scenario or "")
        if session is None:
            self._missing = self._none()
            self._looks_or_fail().rejected("no session")
            raise not_found("session yet on scenario", self.mapping.scenario or "")
        return session

    def _following(self, received: MessageType) -> MappedLooks | None:
        """The looks, for the session that is the robot's, which is asked once in a while.

        None for a pose of a robot whose scenario or session is not there: its scans say so.

        Raises:
            Failure: the scenario or session that the mapping names is not there.
        """
        now = time.monotonic()
        if self._looks is None or now - self._followed >= FOLLOW_SECONDS:
            try:
                self._follow()
            except Failure:
                if received == LASER_SCAN:
                    raise
                return None
            self._followed = now
        return self._looks_or_fail()

    def _looks_or_fail(self) -> MappedLooks:
        if self._looks is None:
            raise not_found("scenario", self._scenario or "")
        return self._looks

    def _follow(self) -> None:
        sessions, mapping = self._services.sessions, self.mapping
        try:
            if mapping.session is not None:
                scenario = sessions.state(mapping.session).scenario
                session: str | None = mapping.session
            else:
                scenario = mapping.scenario or ""
                session = self._services.claims.peek(self.name, scenario)
            if scenario != self._scenario or self._looks is None:
                self._look_at(scenario)
        except Failure as failure:
            self._missing = f"what the mapping names: {failure.detail}"
            raise
        self._missing = self._none() if session is None else None
        if session != self._session:
            self._enter(session)

    def _none(self) -> str:
        scenario = self.mapping.scenario
        return (
            f"a session on scenario {scenario!r}: open one, or claim the robot for one (`robots` of POST /v1/sessions)"
        )

    def _look_at(self, scenario: str) -> None:
        """Begin to gather looks on the grid of a scenario's lidar."""
        model = self._services.sessions.models.get(scenario)
        if model is None:
            raise not_found("scenario", scenario)
        grid = model.scenario.lidar.grid
        self._scenario = scenario
        beams = BeamGrid(grid.beams, grid.angle_min, grid.angle_increment)
        self._looks = MappedLooks(self.mapping, beams, self._services.limits.beams)
        if self._requested:
            self._requested = False
            self._looks.request()

    def _enter(self, session: str | None) -> None:
        """Begin the looks for a session; None: for none, so far."""
        looks = self._looks_or_fail()
        if self._session is not None:  # what was gathered before there was any session is not lost
            looks.restart()
        self._session = session
        self._issued = 0
        if session is not None:
            self._catch_up(session)

    def _catch_up(self, session: str) -> None:
        """Take note of a look that the session has, and that is not known here."""
        newest = self._services.sessions.robot_looks(session, self.name, 1)
        if newest and newest[0].number > self._issued:
            self._issued = newest[0].number
            look = last_look(self._services, session, self.name)
            if look is not None:
                self._looks_or_fail().resume(look)


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
