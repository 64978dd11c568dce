"""What was heard of robots, so that a scan that came to nothing can be seen."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from pydantic import BaseModel, Field

from voa_msgs.robots import LookReport, RobotReport
from voa_msgs.robots import Robots as RobotsMessage
from voa_msgs.sessions import ScanRequest, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_service.failures import InvalidRequest, not_found
from voa_service.ports import Clock

_MOST = 1_000  # anyone may put anything as a robot's name


class LookOutcome(BaseModel):
    """Fields of the answer to a scan that a robot's report needs; the others are not read."""

    version: int
    update: UpdateReport
    warnings: list[ProbableMistake] = Field(default=[])


class LookSource(Protocol):
    """A mapped robot, as far as its report needs it."""

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet; None: each scan is a look."""

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Probable mistakes in how the robot is used."""

    def request(self) -> None:
        """Ask for a look; raises ValueError where looks are not taken on request."""


@dataclass(frozen=True)
class MappedTo:
    """Session of a robot as its mapping says: the one that it names, or one on a scenario."""

    scenario: str | None
    session: str | None


@dataclass(frozen=True)
class _Mapped:
    """A mapped robot, and what its mapping names."""

    to: MappedTo
    source: LookSource


class Robots:
    """Reports by robot, as this process heard them; from any thread."""

    def __init__(self, now: Clock, session_of: Callable[[str, str], str | None]) -> None:
        """Begin with nobody heard.

        Args:
            now: the time.
            session_of: the session that a look of a robot, mapped to a scenario, would go to now.
        """
        self.mapping_error: str | None = None
        """Why the mapping in force is not the one that its file has."""
        self._now = now
        self._session_of = session_of
        self._reports: dict[tuple[str, str], RobotReport] = {}
        self._mapped: dict[str, _Mapped] = {}
        self._lock = threading.Lock()

    def mapped(
        self, robot: str, key: str, source: LookSource, *, scenario: str | None = None, session: str | None = None
    ) -> None:
        """Note that a robot's topic is subscribed to; its mapping names either a scenario or a session."""
        with self._lock:
            self._mapped[robot] = _Mapped(MappedTo(scenario, session), source)
            self._reports.setdefault((robot, "ros2"), _unheard(robot, "ros2", key))

    def mapped_to(self, robot: str) -> MappedTo | None:
        """Return what the mapping says of a robot's session; None: there is no such robot in it."""
        with self._lock:
            mapped = self._mapped.get(robot)
        return None if mapped is None else mapped.to

    def names(self) -> list[str]:
        """List the mapped robots by name."""
        with self._lock:
            return sorted(self._mapped)

    def unmapped(self, robot: str) -> None:
        """A robot's topic is no longer listened to."""
        with self._lock:
            self._mapped.pop(robot, None)
            self._reports.pop((robot, "ros2"), None)

    def heard(self, robot: str, source: Literal["scan", "ros2"], key: str, session: str | None) -> None:
        """A scan came in."""
        with self._lock:
            if self._is_gone(robot, source):
                return
            before = self._report(robot, source, key)
            session = before.session if session is None else session
            heard = {"session": session, "key": key, "last_scan_at": self._now(), "scans": before.scans + 1}
            self._keep(before.model_copy(update=heard))

    def looked(
        self,
        robot: str,
        source: Literal["scan", "ros2"],
        key: str,
        session: str,
        request: ScanRequest,
        outcome: LookOutcome,
    ) -> None:
        """Note that a look was applied to a session, accepted or not."""
        look = LookReport(
            at=self._now(),
            sensor=request.sensor,
            sensor_pose=request.sensor_pose,
            accepted=outcome.update.accepted,
            reason=outcome.update.reason,
            version=outcome.version,
        )
        with self._lock:
            if self._is_gone(robot, source):
                return
            before = self._report(robot, source, key)
            applied = {"session": session, "looks": before.looks + 1, "last_look": look, "warnings": outcome.warnings}
            self._keep(before.model_copy(update=applied))

    def refused(self, robot: str, source: Literal["scan", "ros2"], key: str, why: str) -> bool:
        """A scan could not be used; whether that is news, and not the same as for the one before."""
        with self._lock:
            if self._is_gone(robot, source):
                return False
            before = self._report(robot, source, key)
            self._keep(before.model_copy(update={"refused": before.refused + 1, "last_refusal": why}))
        return why != before.last_refusal

    def reports(self) -> RobotsMessage:
        """All of them, by name."""
        with self._lock:
            reports, mapped = sorted(self._reports.items()), dict(self._mapped)
        return RobotsMessage(
            mapping_error=self.mapping_error,
            items=[
                self._shown(report, mapped[robot]) if source == "ros2" and robot in mapped else report
                for (robot, source), report in reports
            ],
        )

    def report(self, robot: str) -> RobotReport:
        """Report one mapped robot.

        Raises:
            Failure: no such robot is mapped.
        """
        return self._shown(*self._one(robot))

    def request_look(self, robot: str) -> RobotReport:
        """The robot's next scans are to be a look.

        Raises:
            Failure: no such robot is mapped, or its looks are not on request.
        """
        report, mapped = self._one(robot)
        try:
            mapped.source.request()
        except ValueError as error:
            raise InvalidRequest(str(error)) from error
        return self._shown(report, mapped)

    def _one(self, robot: str) -> tuple[RobotReport, _Mapped]:
        """Find a mapped robot; raises Failure where there is none."""
        with self._lock:
            mapped, report = self._mapped.get(robot), self._reports.get((robot, "ros2"))
        if mapped is None or report is None:
            raise not_found("mapped robot", robot)
        return report, mapped

    def _shown(self, report: RobotReport, mapped: _Mapped) -> RobotReport:
        """Complete a mapped robot's report by what holds at this moment; without the lock, it reads the store."""
        session = mapped.to.session or report.session
        if mapped.to.scenario is not None:
            session = self._session_of(report.robot, mapped.to.scenario)
        warnings = [*mapped.source.warnings, *report.warnings]
        state = {"session": session, "waiting_for": mapped.source.waiting_for, "warnings": warnings}
        return report.model_copy(update=state)

    def _report(self, robot: str, source: Literal["scan", "ros2"], key: str) -> RobotReport:
        return self._reports.get((robot, source)) or _unheard(robot, source, key)

    def _is_gone(self, robot: str, source: Literal["scan", "ros2"]) -> bool:
        """Whether this was on its way when the robot's mapping went: a report of it would stay for ever."""
        return source == "ros2" and robot not in self._mapped

    def _keep(self, report: RobotReport) -> None:
        named = (report.robot, report.source)
        if named not in self._reports and len(self._reports) >= _MOST:
            oldest = min(
                (each for each in self._reports if each[1] == "scan"),
                key=lambda each: str(self._reports[each].last_scan_at),
                default=None,
            )
            if oldest is not None:
                del self._reports[oldest]
        self._reports[named] = report


def _unheard(robot: str, source: Literal["scan", "ros2"], key: str) -> RobotReport:
    return RobotReport(
        robot=robot,
        session=None,
        source=source,
        key=key,
        last_scan_at=None,
        scans=0,
        looks=0,
        refused=0,
        last_refusal=None,
        waiting_for=None,
    )
