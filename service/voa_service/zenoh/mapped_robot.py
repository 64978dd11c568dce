"""One mapped ROS 2 robot in a service: the session that its scans are for, and the looks that follow.

Every replica receives everything and gathers looks of the same stops. What the session has already is read as each stop
begins (`ledger`), so that a replica that has missed some looks, or was started just now, goes on where the session is.
"""

import threading
import time

from voa_msgs.sessions import ScanRequest
from voa_msgs.warnings import ProbableMistake
from voa_ros.grids import BeamGrid
from voa_ros.looks import GatheredLook
from voa_ros.pipeline import ContradictoryHeader, LookPipeline, Received, UnusableMessage
from voa_ros.robot_places import AttachmentPlace
from voa_ros.robots import RobotMapping
from voa_ros.topics import LASER_SCAN, MessageType
from voa_service.failures import BeamGridMismatch, Failure, InvalidRequest, NotFound, UnknownReference, not_found
from voa_service.rpc.methods import attachment_of
from voa_service.services import Services
from voa_service.zenoh.applying import DueLook
from voa_service.zenoh.ledger import LookLedger
from voa_service.zenoh.samples import Sample
from voa_service.zenoh.stops import SameStop, same_stop

FOLLOW_SECONDS = 1.0
"""How late a change of the mapping, or of a robot's session, is noticed."""
_SHOWS_STOP = 2
"""Revolutions of a stop, at most, after which the session is asked for looks that other replicas took."""
_ABSENT = (NotFound.kind, UnknownReference.kind)
"""Kinds of failures that say that something is not there, and not that it cannot be read."""


class MappedRobot:
    """One mapped robot; all methods may be called from any thread."""

    def __init__(self, mapping: RobotMapping, services: Services) -> None:
        self.mapping = mapping
        self.name = mapping.name
        self._services = services
        self._looks: LookPipeline | None = None
        self._session: str | None = None
        self._scenario: str | None = None
        self._ledger: LookLedger | None = None
        self._same_stop: SameStop | None = None
        self._stop_known = False
        """Whether the session was asked in the present stop."""
        self._followed = -FOLLOW_SECONDS
        self._missing: str | None = None
        self._absent: Failure | None = None
        """Why the mapping's scenario or session cannot be followed."""
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

    def rejected(self, due: DueLook, reason: str) -> None:
        """Let the next revolutions make another look: this one was not accepted."""
        with self._lock:
            if self._looks is not None and due.ledger is self._ledger:
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
                raise BeamGridMismatch(str(error)) from error
            except UnusableMessage as error:
                raise InvalidRequest(str(error)) from error
            if isinstance(found, GatheredLook):
                return self._due(found)
            self._learn_of_the_stop(looks)
            if sample.type == LASER_SCAN and self._missing is not None:
                raise not_found("session yet on scenario", self.mapping.scenario or "")
            return None

    def _due(self, taken: GatheredLook) -> DueLook | None:
        """Give out a look; None: another replica's look of this stop came first, while the robot's session changed.

        Raises:
            Failure: it is not known for which session it is; it does not use up the stop.
        """
        looks = self._looks_or_fail()
        try:
            session = self._settled()
            ledger = self._ledger
            if ledger is None or session != self._session:
                ledger = self._enter(session)
                if self._is_taken(ledger.newest, taken):
                    return None
                if self._same_stop is not None:
                    looks.resume(taken.request)
        except Failure as failure:
            looks.rejected(failure.kind, taken.request)
            raise
        self._missing = None
        self._stop_known = False
        ledger.take(taken)
        return DueLook(self.name, taken, ledger, ledger.version)

    def _is_taken(self, newest: ScanRequest | None, taken: GatheredLook) -> bool:
        return newest is not None and self._same_stop is not None and self._same_stop(newest, taken.request)

    def _learn_of_the_stop(self, looks: LookPipeline) -> None:
        """Once in each stop: take note of a look that others took of it, perhaps."""
        rule = self.mapping.look
        if rule.mode == "every" or looks.standing < min(_SHOWS_STOP, rule.scans - 1):
            self._stop_known = False
        elif not self._stop_known and self._ledger is not None:
            newest = self._ledger.begin_stop()
            self._stop_known = True
            if newest is not None:
                looks.resume(newest)

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
            raise not_found("session yet on scenario", self.mapping.scenario or "")
        return session

    def _following(self, received: MessageType) -> LookPipeline | None:
        """The looks, for the session that is the robot's, which is asked once in a while.

        None for a pose of a robot whose scenario or session is not there: its scans say so.

        Raises:
            Failure: the scenario or session that the mapping names is not there.
        """
        now = time.monotonic()
        if now - self._followed >= FOLLOW_SECONDS:
            self._followed = now
            try:
                self._follow()
                self._absent = None
            except Failure as failure:  # a database that fails for a moment stops no look from being gathered
                self._absent = failure if self._looks is None or failure.kind in _ABSENT else None
        if self._absent is None:
            return self._looks_or_fail()
        if received == LASER_SCAN:
            raise self._absent.with_traceback(None)
        return None

    def _looks_or_fail(self) -> LookPipeline:
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
            if failure.kind in _ABSENT or self._looks is None:
                self._missing = f"what the mapping names: {failure.detail}"
            raise
        self._missing = self._none() if session is None else None
        if session is None:
            self._leave()
        elif session != self._session:
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
        self._looks = LookPipeline(self.mapping, beams, self._services.limits.beams)
        self._same_stop = same_stop(self.mapping.look, beams)
        if self._requested:
            self._requested = False
            self._looks.request()

    def _enter(self, session: str) -> LookLedger:
        """Begin the looks for a session; raises Failure, and changes nothing, where it cannot be read."""
        ledger = LookLedger(self._services.sessions, session, self.name, self._same_stop)
        self._leave()
        self._session, self._ledger = session, ledger
        if ledger.newest is not None:
            self._looks_or_fail().resume(ledger.newest)
        return ledger

    def _leave(self) -> None:
        """End the looks for a session, if there was one; what was gathered before there was any is not lost."""
        if self._session is not None:
            self._looks_or_fail().restart()
        self._session = self._ledger = None
        self._stop_known = False
