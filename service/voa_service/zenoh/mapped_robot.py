"""A mapped ROS 2 robot in this process: gathers its messages into looks for the session that it belongs to.

Every replica receives all messages and gathers looks at the same stops. As each stop begins, the looks that the session
has are read (`ledger`), so that a replica that missed some, or has just started, continues from the session's state.
"""

import threading
import time
from collections.abc import Callable, Sequence

from voa_msgs.sessions import ScanRequest
from voa_msgs.warnings import ProbableMistake
from voa_ros.looks import GatheredLook
from voa_ros.pipeline import ContradictoryHeader, LookPipeline, Received, SeenScan, UnusableMessage
from voa_ros.robot_places import AttachmentPlace
from voa_ros.robots import RobotMapping
from voa_ros.standing import NamedPlace, nearest_place
from voa_ros.stops import SameStop, same_stop
from voa_ros.topics import LASER_SCAN
from voa_service.failures import BeamGridMismatch, Failure, InvalidRequest, NotFound, UnknownReference, not_found
from voa_service.guard import guarded
from voa_service.requests.attachments import read_attachment
from voa_service.services import Services
from voa_service.usecases.robot_reports import Standing
from voa_service.zenoh.applying import DueLook
from voa_service.zenoh.joining import FOLLOW_SECONDS, Joining
from voa_service.zenoh.ledger import LookLedger
from voa_service.zenoh.samples import Sample

_SHOWS_STOP = 2
"""Number of revolutions at a stop, at most, after which the session is read for looks by other replicas."""
_ABSENT = (NotFound.kind, UnknownReference.kind)
"""Kinds of failures for a scenario or session that does not exist, as opposed to one that cannot be read."""


class MappedRobot:
    """A mapped robot; all methods may be called from any thread.

    Args:
        mapping: the robot's entry in the mapping file.
        services: use cases and limits.
        clock: monotonic time, by which messages are stamped when they are received, seconds.
    """

    def __init__(self, mapping: RobotMapping, services: Services, clock: Callable[[], float] = time.monotonic) -> None:
        self.mapping = mapping
        self.name = mapping.name
        self._services = services
        self._clock = clock
        same_stop = self._is_same_stop if mapping.look.mode == "stationary" else None
        self._joining = Joining(services.sessions, mapping.name, same_stop, clock)
        self._looks: LookPipeline | None = None
        self._session: str | None = None
        self._scenario: str | None = None
        self._places: Sequence[NamedPlace] = ()
        self._seen: SeenScan | None = None
        self._ledger: LookLedger | None = None
        self._same_stop: SameStop | None = None
        self._stop_known = False
        """True once the session was read for looks by other replicas at the current stop."""
        self._began_s = 0.0
        """Time at which the first message of the current stop was received, by the clock."""
        self._followed = -FOLLOW_SECONDS
        self._missing: str | None = None
        self._absent: Failure | None = None
        """Reason why the mapping's scenario or session cannot be used; None: it can."""
        self._requested = False
        self._lock = threading.Lock()

    @property
    def waiting_for(self) -> str | None:
        """Condition that the next look still waits for, in words; None where each scan is a look."""
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
    def standing(self) -> Standing:
        """Present place of the robot, and the progress of its next look."""
        looks, rule = self._looks, self.mapping.look
        where = None if self._seen is None else self._seen.where
        gathered, wanted = (
            (None, None) if rule.mode == "every" else (0 if looks is None else looks.standing, rule.scans)
        )
        if where is None or isinstance(where, str):
            return Standing(where, None, gathered, wanted)
        return Standing(nearest_place(where, self._places), where, gathered, wanted)

    @property
    def session(self) -> str | None:
        """Id of the session that the robot's scans are for; None: not known yet."""
        return self._session or self.mapping.session

    def prepare(self) -> None:
        """Read the looks of the robot's session, if there is one, before the first message is received.

        Raises:
            Failure: the database does not work at the moment; nothing is prepared.
        """
        mapping = self.mapping
        try:
            with self._lock, guarded():
                session = mapping.session or self._services.claims.peek(self.name, mapping.scenario or "")
                if session is not None:
                    self._joining.begin(session)
        except Failure as failure:
            if failure.kind not in _ABSENT:
                raise

    def request(self) -> None:
        """Request a look; raises ValueError where the robot's mode is not `on_request`."""
        with self._lock:
            if self._looks is not None:
                self._looks.request()
            elif self.mapping.look.mode == "on_request":
                self._requested = True
            else:
                mode = self.mapping.look.mode
                raise ValueError(f"expected a robot in mode 'on_request', {self.name!r} is in mode {mode!r}")

    def rejected(self, due: DueLook, reason: str) -> None:
        """Note that a look was not accepted, so that the next revolutions make another look at this stop."""
        with self._lock:
            if self._looks is not None and due.ledger is self._ledger:
                self._looks.rejected(reason, due.taken.request)

    def receive(self, sample: Sample) -> DueLook | None:
        """Receive a message on a topic of the robot.

        Returns:
            A look that is due, if this message completes one.

        Raises:
            Failure: the message cannot be used, or there is no session for it.
        """
        with self._lock, guarded():
            if sample.type == LASER_SCAN:
                self._services.robots.received(self.name, "ros2", sample.key, self._session)
            looks = self._following(sample)
            if looks is None:
                return None
            attached = read_attachment(sample.attachment) if isinstance(self.mapping.place, AttachmentPlace) else None
            try:
                received = looks.receive(Received(sample.type, sample.payload, sample.received_s, attached))
            except ContradictoryHeader as error:
                raise BeamGridMismatch(str(error)) from error
            except UnusableMessage as error:
                raise InvalidRequest(str(error)) from error
            finally:
                self._show(looks.seen)
            if isinstance(received, GatheredLook):
                return self._due(received, sample.received_s)
            self._read_looks_of_others(looks, sample.received_s)
            if sample.type == LASER_SCAN and self._missing is not None:
                raise not_found("session yet on scenario", self.mapping.scenario or "")
            return None

    def _show(self, seen: SeenScan | None) -> None:
        """Keep a scan for a preview, if it is a new one."""
        if seen is not None and seen is not self._seen:
            self._seen = seen
            self._services.robots.seen(self.name, seen, self.session)

    def _due(self, taken: GatheredLook, received_s: float) -> DueLook | None:
        """Make a look due; None where another replica applied a look at this stop while the robot's session changed.

        Raises:
            Failure: there is no session for the look, or it cannot be read; the stop may then make another look.
        """
        looks = self._looks_or_fail()
        try:
            with guarded():
                session = self._joining.session_at(received_s, self._settled())
                ledger = self._ledger
                if ledger is None or session != self._session:
                    ledger = self._enter(session, received_s)
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
        return newest is not None and self._is_same_stop(newest, taken.request)

    def _is_same_stop(self, one: ScanRequest, other: ScanRequest) -> bool:
        return self._same_stop is not None and self._same_stop(one, other)

    def _read_looks_of_others(self, looks: LookPipeline, received_s: float) -> None:
        """Read, once at each stop, the looks of other replicas, and note one that was taken at this stop."""
        rule = self.mapping.look
        if looks.standing <= 1:
            self._began_s = received_s
        if rule.mode == "every" or looks.standing < min(_SHOWS_STOP, rule.scans - 1):
            self._stop_known = False
        elif not self._stop_known and self._ledger is not None:
            newest = self._ledger.begin_stop(self._began_s, received_s)
            self._stop_known = True
            if newest is not None:
                looks.resume(newest)

    def _settled(self) -> str:
        """Return the session for a look that is due, and make it the robot's own from now on.

        Raises:
            Failure: there is no session for the robot.
        """
        if self.mapping.session is not None:
            return self.mapping.session
        session = self._services.claims.settle(self.name, self.mapping.scenario or "")
        if session is None:
            self._missing = self._none()
            raise not_found("session yet on scenario", self.mapping.scenario or "")
        return session

    def _following(self, sample: Sample) -> LookPipeline | None:
        """Return the looks that are being gathered, after polling the robot's session where that is due.

        Returns:
            The looks; None for a pose where the mapping's scenario or session does not exist.

        Raises:
            Failure: for a scan, where the mapping's scenario or session does not exist.
        """
        now = self._clock()
        if now - self._followed >= FOLLOW_SECONDS:
            self._followed = now
            try:
                with guarded():
                    self._follow(sample.received_s)
                self._absent = None
            except Failure as failure:  # looks are gathered on while the database fails for a moment
                is_absent = self._looks is None or failure.kind in _ABSENT
                self._absent = failure if is_absent else None
                if is_absent:
                    self._missing = f"the mapping's scenario or session: {failure.detail}"
        if self._absent is None:
            return self._looks_or_fail()
        if sample.type == LASER_SCAN:
            raise self._absent.with_traceback(None)
        return None

    def _looks_or_fail(self) -> LookPipeline:
        if self._looks is None:
            raise not_found("scenario", self._scenario or "")
        return self._looks

    def _follow(self, received_s: float) -> None:
        sessions, mapping = self._services.sessions, self.mapping
        if mapping.session is not None:
            scenario = sessions.state(mapping.session).scenario
            session: str | None = mapping.session
        else:
            scenario = mapping.scenario or ""
            session = self._services.claims.peek(self.name, scenario)
        joins = None if session is None else self._joining.session_at(received_s, session)
        if scenario != self._scenario or self._looks is None:
            self._begin_on(scenario)
        self._missing = self._none() if joins is None else None
        if joins is None:
            self._leave()
            self._joining.leave()
        elif joins != self._session:
            self._enter(joins, received_s)

    def _none(self) -> str:
        scenario = self.mapping.scenario
        return (
            f"a session on scenario {scenario!r}: open one, or claim the robot for one (`robots` of POST /v1/sessions)"
        )

    def _begin_on(self, scenario: str) -> None:
        """Begin to gather looks on the beam grid of a scenario's lidar."""
        beams = self._services.scenarios.beam_grid(scenario)
        self._places = self._services.scenarios.places(scenario)
        self._scenario = scenario
        self._looks = LookPipeline(self.mapping, beams, self._services.limits.beams)
        self._same_stop = same_stop(self.mapping.look, beams)
        if self._requested:
            self._requested = False
            self._looks.request()

    def _enter(self, session: str, received_s: float) -> LookLedger:
        """Begin to gather looks for a session; raises Failure, and changes nothing, where it cannot be read."""
        ledger = self._joining.join(session, received_s)
        self._leave()
        self._session, self._ledger = session, ledger
        if ledger.newest is not None:
            self._looks_or_fail().resume(ledger.newest)
        return ledger

    def _leave(self) -> None:
        """Stop gathering looks for the session, if there is one; revolutions that came before any session are kept."""
        if self._session is not None:
            self._looks_or_fail().restart()
        self._session = self._ledger = None
        self._stop_known = False
